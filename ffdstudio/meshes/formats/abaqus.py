"""Abaqus and CalculiX decks (.inp).

1. A line with one star begins a block, two stars are a comment, the rest is data separated by
   commas. Nodes stand in any number of ``*NODE`` blocks; each ``*PART`` counts anew.
2. Only coordinates change. Cylindrical and spherical ones (``SYSTEM=C``, ``S``) and local
   frames (``*SYSTEM``) are refused: the numbers are not x, y, z.
3. Element sets become markers, node sets markers of vertices; those of an instance in an
   assembly are its part's.
4. A number gets at most 20 characters, the most that both programs read: one that needs more
   is rounded, by less than 1e-12 of itself.
5. A blank coordinate is zero. Nodes in other files would not move: these decks are refused.
"""

from __future__ import annotations

import re
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Indices
from ffdstudio.files import read_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.abaqus_blocks import DeckBlock, blocks_of, fields, first_blank, tokens
from ffdstudio.meshes.formats.abaqus_types import is_slender, kind_of
from ffdstudio.meshes.formats.number_table import pick_anywhere, pick_numbers
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells

FIELD = 20  # characters of a number: CalculiX cuts longer ones off, whatever they end in
_NODES = re.compile(rb"^\*NODE[ \t]*[,\r\n]", re.I | re.M)


@dataclass
class Part:
    """Nodes, elements and sets of one numbering."""

    name: str = ""
    ids: list[Indices] = field(default_factory=list)
    cells: list[tuple[str, Indices, Indices, str]] = field(
        default_factory=list
    )  # kind ids nodes set
    sets: list[tuple[str, str, DeckBlock]] = field(
        default_factory=list
    )  # ELSET or NSET, name, block


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an Abaqus deck; see `read_mesh`."""
    return _Reader(Source(path, data)).mesh()


class _Reader:
    """What the blocks of a deck add up to."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.parts = [Part()]
        self.starts: list[Indices] = []
        self.ends: list[Indices] = []
        self.count = 0
        self.included: list[str] = []
        self.unread: Counter[str] = Counter()
        self.instances: dict[str, str] = {}  # name in capitals -> part

    def mesh(self) -> Mesh:
        for block in blocks_of(self.source):
            self._take(block)
        if not self.count:
            hint = f"; it includes {self.included[0]}: open that file" if self.included else ""
            raise self.source.failure(f"there is no *NODE block with nodes in this deck{hint}")
        if self.included:
            self._warn(f"what it includes is not read: {', '.join(self.included)}")
        starts, ends = (np.concatenate(found) for found in (self.starts, self.ends))
        points = np.zeros((self.count, 3))
        solid = starts < ends
        points[:, : starts.shape[1]][solid] = pick_anywhere(self.source, starts[solid], ends[solid])
        cells: dict[str, list[Indices]] = {}
        markers: Markers = {}
        first = 0
        for part in self.parts:
            first = self._resolve(part, first, cells, markers)
        joined = {kind: np.concatenate(nodes) for kind, nodes in cells.items()}
        template = TextTemplate(self.source.data, points, starts, ends, width=FIELD)
        return Mesh(
            points,
            joined,
            markers,
            dimension=starts.shape[1],
            unread=dict(self.unread),
            template=template,
        )

    def _take(self, block: DeckBlock) -> None:
        match block.keyword:
            case "NODE":
                self._nodes(block)
            case "ELEMENT":
                self._elements(block)
            case "NSET" | "ELSET":
                name = block.parameters.get(block.keyword, "")
                part = self._part_of(block.parameters.get("INSTANCE", ""))
                part.sets.append((block.keyword, name, block))
            case "INSTANCE":
                self._instance(block)
            case "PART":
                self.parts.append(Part(block.parameters.get("NAME", "part") + "/"))
            case "END PART":
                self.parts.append(Part())
            case "INCLUDE":
                self._include(block)
            case "SYSTEM" if block.spans:
                raise self.source.error(block.place, "nodes in a local frame (*SYSTEM)")

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

    def _include(self, block: DeckBlock) -> None:
        """Refuse an included file with nodes, which would stay behind; warn of any other."""
        name = block.parameters.get("INPUT", "another file")
        self.included.append(name)
        file = self.source.path.parent / name
        if file.is_file() and _NODES.search(read_bytes(file)):
            raise self.source.error(
                block.place,
                f"the nodes in {name}, which it includes, would not move: put them into this deck",
            )

    def _warn(self, message: str) -> None:
        warnings.warn(f"{self.source.path.name}: {message}", MeshWarning, stacklevel=2)

    def _nodes(self, block: DeckBlock) -> None:
        if "INPUT" in block.parameters:
            raise self.source.error(
                block.place,
                f"its nodes are in {block.parameters['INPUT']}: put them into this deck",
            )
        if block.parameters.get("SYSTEM", "R").upper() not in ("R", ""):
            raise self.source.error(block.place, "nodes in cylindrical or spherical coordinates")
        by_word = tokens if first_blank(self.source, block) is None else fields
        starts, ends, first = by_word(self.source, block)
        widths = np.diff(np.append(first, len(starts)))
        if not len(first):
            return
        axes = 2 if (widths == 3).all() else 3
        bad = np.flatnonzero((widths < axes + 1) | (widths > 7))
        if len(bad):
            place = int(starts[first[bad[0]]])
            raise self.source.error(place, f"a node needs its number and {axes} coordinates")
        if self.starts and self.starts[0].shape[1] != axes:
            raise self.source.error(block.place, "nodes with and without z in one deck")
        numberless = np.flatnonzero(starts[first] == ends[first])
        if len(numberless):
            raise self.source.error(int(starts[first[numberless[0]]]), "a node without a number")
        where = first[:, None] + np.arange(1, axes + 1)
        self.parts[-1].ids.append(pick_numbers(self.source, starts[first], ends[first], np.int64))
        self.starts.append(starts[where])
        self.ends.append(ends[where])
        self.count += len(first)
        if "NSET" in block.parameters:
            self.parts[-1].sets.append(("NODES", block.parameters["NSET"], block))

    def _elements(self, block: DeckBlock) -> None:
        kind = kind_of(block.parameters.get("TYPE", ""))
        starts, ends, _ = tokens(self.source, block)
        if kind is None or "INPUT" in block.parameters:
            where = f" in {block.parameters['INPUT']}" if kind else ""
            title = block.parameters.get("TYPE", "?")
            self._warn(f"elements of type {title}{where} are kept but not shown")
            if kind or not is_slender(title):
                self.unread[title] += max(_records(self.source, block), 1)
            return
        name, count = kind
        blank = first_blank(self.source, block)
        if blank is not None:
            raise self.source.error(blank, "an element with a node left blank")
        numbers = pick_numbers(self.source, starts, ends, np.int64)
        if len(numbers) % (count + 1):
            raise self.source.error(block.place, f"elements of this type have {count} nodes")
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
        sets: dict[tuple[str, str], list[Indices]] = {}
        for kind, numbers, nodes, own in part.cells:
            rows = first + self._index(ids, nodes, "an element refers to node")
            cells.setdefault(kind, []).append(rows)
            elements.append((kind, numbers, rows))
            if own:
                sets.setdefault(("ELSET", own.upper()), []).append(numbers)
        names = {key[1]: key[1] for key in sets}
        names |= {own.upper(): own for *_, own in part.cells}
        for keyword, name, block in part.sets:
            key = "NSET" if keyword == "NODES" else keyword
            members = self._members(keyword, block, sets)
            sets.setdefault((key, name.upper()), []).append(members)
            names[name.upper()] = name
        for (keyword, upper), numbers_of in sets.items():
            members = np.unique(np.concatenate(numbers_of))
            found = self._cells(keyword, members, elements, ids, first)
            name = part.name + names[upper]
            if found and upper:
                markers[f"{name} (nodes)" if name in markers else name] = found
            elif upper:
                self._warn(f"set {name} is kept but not shown: none of its members is known here")
        return first + len(ids)

    def _members(
        self, keyword: str, block: DeckBlock, sets: dict[tuple[str, str], list[Indices]]
    ) -> Indices:
        """Numbers in a set; other sets may be named in it."""
        starts, ends, first = tokens(self.source, block)
        if keyword == "NODES":
            return pick_numbers(self.source, starts[first], ends[first], np.int64)
        data = self.source.data
        words = [data[i:j] for i, j in zip(starts.tolist(), ends.tolist(), strict=True)]
        if "GENERATE" in block.parameters:
            return self._generated(block, words, first)
        found = [np.array([int(word) for word in words if word.isdigit()], dtype=np.int64)]
        for word in words:
            if not word.isdigit():
                found += sets.get((keyword, word.decode("utf-8", "replace").upper()), [])
        return np.concatenate(found)

    def _generated(self, block: DeckBlock, words: list[bytes], first: Indices) -> Indices:
        found = [np.empty(0, dtype=np.int64)]
        for begin, end in zip(first, [*first[1:], len(words)], strict=False):
            line = [self.source.integer(w, block.place, "a number") for w in words[begin:end]]
            low, high, step = (*line, 1) if len(line) == 2 else (*line, 0, 0, 0)[:3]
            if step < 1 or (high - low) // step > len(self.source.data):
                raise self.source.error(block.place, "GENERATE needs first, last and step")
            found.append(np.arange(low, high + 1, step))
        return np.concatenate(found)

    def _cells(
        self,
        keyword: str,
        members: Indices,
        elements: list[tuple[str, Indices, Indices]],
        ids: Indices,
        first: int,
    ) -> Cells:
        if keyword == "NSET":
            inside = members[np.isin(members, ids)]
            rows = first + self._index(ids, inside, "a set refers to node")
            return {"vertex": rows[:, None]} if len(rows) else {}
        parts: dict[str, list[Indices]] = {}
        for kind, numbers, rows in elements:
            chosen = np.isin(numbers, members)
            if chosen.any():
                parts.setdefault(kind, []).append(rows[chosen])
        return {kind: np.concatenate(found) for kind, found in parts.items()}

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


def _records(source: Source, block: DeckBlock) -> int:
    """Number of elements of a block of an unknown type: a comma at the end goes on."""
    lines = [
        line.strip()
        for begin, end in block.spans
        for line in source.data[begin:end].splitlines()
        if line.strip() and not line.lstrip().startswith(b"**")
    ]
    return sum(not line.endswith(b",") for line in lines)
