"""Abaqus and CalculiX decks (.inp), with the files that they include.

1. A line with one star begins a block, two stars are a comment, the rest is data separated by
   commas. Nodes stand in any number of ``*NODE`` blocks; each ``*PART`` counts anew.
2. Only coordinates change. Cylindrical and spherical ones (``SYSTEM=C``, ``S``) and those in a
   local frame (``*SYSTEM``) are put into x, y, z and back. Nodes that ``*NGEN`` and its like
   make are in no file, so that these decks are refused.
3. Element sets and surfaces become markers, node sets markers of vertices; those of an instance
   in an assembly are its part's.
4. A number gets at most 20 characters, the most that both programs read: one that needs more
   is rounded, by less than 1e-12 of itself.
5. A blank coordinate is zero. A plane part may have points of reference with a z: the mesh is
   plane if no element has a node with one.
6. Included files (``*INCLUDE``, ``INPUT=``) are written beside the deck.
"""

from __future__ import annotations

import os
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import read_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.abaqus_blocks import DeckBlock, blocks_of, fields, first_blank, tokens
from ffdstudio.meshes.formats.abaqus_sets import Part, Sets
from ffdstudio.meshes.formats.abaqus_types import is_slender, kind_of
from ffdstudio.meshes.formats.deck_files import DeckFile, DeckTemplate, located
from ffdstudio.meshes.formats.framed import Framing
from ffdstudio.meshes.formats.frames import Frame
from ffdstudio.meshes.formats.number_table import pick_anywhere, pick_numbers
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning, Template
from ffdstudio.meshes.topology import Cells

FIELD = 20  # characters of a number: CalculiX cuts longer ones off, whatever they end in
MOST = 10_000  # files of a deck
MAKERS = ("NGEN", "NFILL", "NCOPY", "NMAP")
CELL_MAKERS = ("ELGEN", "ELCOPY")
KINDS = {"": "R", "R": "R", "C": "C", "S": "L"}


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an Abaqus deck; see `read_mesh`."""
    return _Reader(Source(path, data)).mesh()


class _Reader:
    """What the blocks of a deck add up to."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.files = [DeckFile(source, "")]
        self.parts = [Part()]
        self.starts: list[Indices] = []
        self.ends: list[Indices] = []
        self.owner: list[Indices] = []  # file of each node
        self.frames: list[tuple[Frame, Indices]] = []
        self.system: Frame | None = None
        self.count = 0
        self.missing: list[str] = []
        self.unread: Counter[str] = Counter()
        self.instances: dict[str, str] = {}  # name in capitals -> part

    def mesh(self) -> Mesh:
        for block in blocks_of(self.source):
            self._take(block)
        if not self.count:
            hint = f"; it includes {self.missing[0]}, which is not there" if self.missing else ""
            raise self.source.failure(f"there is no *NODE block with nodes in this deck{hint}")
        if self.missing:
            self._warn(f"what it includes is not there, so not read: {', '.join(self.missing)}")
        starts, ends = (np.concatenate(found) for found in (self.starts, self.ends))
        owner = np.concatenate(self.owner)
        local = self._numbers(starts, ends, owner)
        framing = Framing.of(local, self.frames)
        cells: dict[str, list[Indices]] = {}
        markers: Markers = {}
        first = 0
        for part in self.parts:
            first = self._resolve(part, first, cells, markers)
        joined = {kind: np.concatenate(nodes) for kind, nodes in cells.items()}
        dimension = self._dimension(starts, joined)
        axes = 2 if (starts[:, 2] < 0).all() else 3
        return Mesh(
            framing.original,
            joined,
            markers,
            dimension=dimension,
            unread=dict(self.unread),
            template=self._template(framing, starts[:, :axes], ends[:, :axes], owner),
        )

    def _numbers(self, starts: Indices, ends: Indices, owner: Indices) -> Array:
        found = np.zeros((self.count, 3))
        for k, file in enumerate(self.files):
            solid = (starts < ends) & (owner == k)[:, None]
            found[solid] = pick_anywhere(file.source, starts[solid], ends[solid])
        return found

    def _dimension(self, starts: Indices, cells: Cells) -> int:
        """Two if no node of an element has a z."""
        used = [nodes.ravel() for nodes in cells.values()] or [np.arange(self.count)]
        return 2 if (starts[np.concatenate(used), 2] < 0).all() else 3

    def _template(
        self, framing: Framing, starts: Indices, ends: Indices, owner: Indices
    ) -> Template:
        """The deck as a text, or with the files that it includes."""
        texts = []
        for k, file in enumerate(self.files):
            rows = np.flatnonzero(owner == k)
            slots = None if len(self.files) == 1 else rows
            texts.append(
                TextTemplate(
                    file.source.data, framing.local, starts[rows], ends[rows], slots, width=FIELD
                )
            )
        if len(texts) == 1 and not framing.frames:
            return texts[0]

        def contents(points: Array) -> list[bytes]:
            numbers = framing.numbers(points)
            return [text.patched(numbers) for text in texts]

        return DeckTemplate(
            self.source.path, framing.original, self.files, contents, lambda path, points: None
        )

    def _take(self, block: DeckBlock) -> None:
        block = self._elsewhere(block)
        match block.keyword:
            case "NODE":
                self._nodes(block)
            case "ELEMENT":
                self._elements(block)
            case "NSET" | "ELSET":
                name = block.parameters.get(block.keyword, "")
                part = self._part_of(block.parameters.get("INSTANCE", ""))
                part.sets.append((block.keyword, name, block))
            case "SURFACE":
                self.parts[-1].sets.append(("SURFACE", block.parameters.get("NAME", ""), block))
            case "INSTANCE":
                self._instance(block)
            case "PART":
                self.system = None
                self.parts.append(Part(block.parameters.get("NAME", "part") + "/"))
            case "END PART":
                self.system = None
                self.parts.append(Part())
            case "INCLUDE":
                self._include(block)
            case "SYSTEM":
                self.system = _system(block)
            case keyword if keyword in MAKERS:
                raise block.source.error(
                    block.place,
                    f"*{keyword} makes nodes that are in no file, so that they cannot move: "
                    "write them out in *NODE",
                )
            case keyword if keyword in CELL_MAKERS:
                self._warn(f"elements that *{keyword} makes are not shown")
                self.unread[f"*{keyword}"] += max(_records(block), 1)

    def _instance(self, block: DeckBlock) -> None:
        """Remember whose sets the assembly names; nodes stay where their part has them."""
        name, part = (block.parameters.get(key, "") for key in ("NAME", "PART"))
        if part.upper() in (used.upper() for used in self.instances.values()):
            self._warn(f"part {part} stands in several places, and moves in all of them")
        if block.spans:
            self._warn(f"instance {name} is shown where its part is, not moved to its place")
        self.instances[name.upper()] = part

    def _part_of(self, instance: str) -> Part:
        """Part of an instance, the last one without a name."""
        name = f"{self.instances.get(instance.upper(), '')}/".upper()
        found = [part for part in self.parts if instance and part.name.upper() == name]
        return found[0] if found else self.parts[-1]

    def _opened(self, block: DeckBlock) -> Source | None:
        """File that a block names by INPUT, None if it is not there."""
        name = block.parameters.get("INPUT", "").replace("\\", "/")
        there = located(self.source.path, block.source.path, name) if name else None
        if there is None or not there[0].is_file():
            self.missing.append(name or "another file")
            return None
        real = os.path.realpath(there[0])
        if any(os.path.realpath(file.source.path) == real for file in self.files):
            raise block.source.error(block.place, f"includes {name}, which is included already")
        if len(self.files) >= MOST:
            raise self.source.failure("includes too many files")
        self.files.append(DeckFile(Source(there[0], read_bytes(there[0])), there[1]))
        return self.files[-1].source

    def _include(self, block: DeckBlock) -> None:
        source = self._opened(block)
        for inner in blocks_of(source) if source else ():
            self._take(inner)

    def _elsewhere(self, block: DeckBlock) -> DeckBlock:
        """Block whose data lines another file holds."""
        if (
            block.keyword not in ("NODE", "ELEMENT", "NSET", "ELSET")
            or "INPUT" not in block.parameters
        ):
            return block
        source = self._opened(block)
        spans = [(0, len(source.data))] if source else []
        return DeckBlock(block.keyword, block.parameters, 0, source or block.source, spans)

    def _warn(self, message: str) -> None:
        warnings.warn(f"{self.source.path.name}: {message}", MeshWarning, stacklevel=2)

    def _nodes(self, block: DeckBlock) -> None:
        starts, ends, first = (tokens if first_blank(block) is None else fields)(block)
        widths = np.diff(np.append(first, len(starts)))
        if not len(first):
            return
        bad = np.flatnonzero((widths < 2) | (widths > 7))
        if len(bad):
            place = int(starts[first[bad[0]]])
            raise block.source.error(place, "a node needs its number and one to three coordinates")
        numberless = np.flatnonzero(starts[first] == ends[first])
        if len(numberless):
            raise block.source.error(int(starts[first[numberless[0]]]), "a node without a number")
        where = first[:, None] + np.arange(1, 4)
        there = np.arange(1, 4) < widths[:, None]
        where = np.where(there, where, 0)
        self.parts[-1].ids.append(pick_numbers(block.source, starts[first], ends[first], np.int64))
        self.starts.append(np.where(there, starts[where], -1))
        self.ends.append(np.where(there, ends[where], -1))
        self.owner.append(np.full(len(first), self._number(block.source)))
        self._frame(block, self.count + np.arange(len(first)))
        self.count += len(first)
        if "NSET" in block.parameters:
            self.parts[-1].sets.append(("NODES", block.parameters["NSET"], block))

    def _number(self, source: Source) -> int:
        return next(k for k, file in enumerate(self.files) if file.source is source)

    def _frame(self, block: DeckBlock, nodes: Indices) -> None:
        """Remember the frame that nodes are given in."""
        kind = KINDS.get(block.parameters.get("SYSTEM", "").upper())
        if kind is None:
            raise block.source.error(block.place, "*NODE, SYSTEM= must be R, C or S")
        if self.system is not None or kind != "R":
            base = self.system or Frame("R", np.zeros(3), np.eye(3))
            self.frames.append((Frame(kind, base.origin, base.axes), nodes))

    def _elements(self, block: DeckBlock) -> None:
        title = block.parameters.get("TYPE", "?")
        kind = kind_of(title)
        if kind is None:
            self._warn(f"elements of type {title} are kept but not shown")
            if not is_slender(title):
                self.unread[title] += max(_records(block), 1)
            return
        starts, ends, _ = tokens(block)
        name, count = kind
        blank = first_blank(block)
        if blank is not None:
            raise block.source.error(blank, "an element with a node left blank")
        numbers = pick_numbers(block.source, starts, ends, np.int64)
        if len(numbers) % (count + 1):
            raise block.source.error(block.place, f"elements of this type have {count} nodes")
        table = numbers.reshape(-1, count + 1)
        own = block.parameters.get("ELSET", "")
        self.parts[-1].cells.append((name, table[:, 0], table[:, 1:], own))

    def _resolve(
        self, part: Part, first: int, cells: dict[str, list[Indices]], markers: Markers
    ) -> int:
        """Add a part's cells and sets by node index; return the index of the next part."""
        ids = np.concatenate(part.ids) if part.ids else np.empty(0, dtype=np.int64)
        if len(np.unique(ids)) != len(ids):
            values, counts = np.unique(ids, return_counts=True)
            raise self.source.failure(f"node {values[counts > 1][0]} occurs twice")
        elements: list[tuple[str, Indices, Indices]] = []
        for kind, numbers, nodes, _ in part.cells:
            rows = first + self._index(ids, nodes, "an element refers to node")
            cells.setdefault(kind, []).append(rows)
            elements.append((kind, numbers, rows))

        def rows_of(members: Indices) -> Indices:
            inside = members[np.isin(members, ids)]
            return first + self._index(ids, inside, "a set refers to node")

        Sets(part, elements, rows_of, self._warn).add_to(markers)
        return first + len(ids)

    def _index(self, ids: Indices, nodes: NDArray[np.int64], what: str) -> Indices:
        order = np.argsort(ids, kind="stable")
        if not len(ids):
            if nodes.size:
                raise self.source.failure(f"{what} {nodes.flat[0]}, which is not there")
            return nodes
        place = np.minimum(np.searchsorted(ids[order], nodes), len(ids) - 1)
        wrong = ids[order][place] != nodes
        if wrong.any():
            raise self.source.failure(f"{what} {nodes[wrong][0]}, which is not there")
        return order[place]


def _system(block: DeckBlock) -> Frame | None:
    """Frame of *SYSTEM: its origin, a point on x and one in the plane of x and y."""
    starts, ends, _ = tokens(block)
    if not len(starts):
        return None
    values = pick_numbers(block.source, starts, ends)
    if len(values) not in (3, 6, 9):
        raise block.source.error(block.place, "*SYSTEM needs one to three points")
    a = values[:3]
    x = values[3:6] - a if len(values) > 3 else np.array([1.0, 0.0, 0.0])
    flat = values[6:9] - a if len(values) > 6 else np.cross([0.0, 0.0, 1.0], x)
    z = np.cross(x, flat)
    if not (np.linalg.norm(z) > 1e-12 * np.linalg.norm(x) * np.linalg.norm(flat)):
        raise block.source.error(block.place, "the three points of *SYSTEM lie on a line")
    return Frame.through("R", a, a + z, a + x)


def _records(block: DeckBlock) -> int:
    """Number of elements of a block of an unknown type: a comma at the end goes on."""
    lines = [
        line.strip()
        for begin, end in block.spans
        for line in block.source.data[begin:end].splitlines()
        if line.strip() and not line.lstrip().startswith(b"**")
    ]
    return sum(not line.endswith(b",") for line in lines)
