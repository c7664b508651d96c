"""Abaqus and CalculiX decks (.inp).

1. A line with one star begins a block, two stars are a comment, the rest is data separated by
   commas. Nodes stand in any number of ``*NODE`` blocks; each ``*PART`` counts anew.
2. Only coordinates change. Cylindrical and spherical ones (``SYSTEM=C``, ``S``) and local
   frames (``*SYSTEM``) are refused: the numbers are not x, y, z.
3. Element sets become markers, node sets markers of vertices.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.abaqus_types import kind_of
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.table import line_firsts, pick_numbers, split_tokens
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells, Indices


@dataclass
class Block:
    """A keyword with its parameters and the places of its data lines."""

    keyword: str
    parameters: dict[str, str]
    place: int
    spans: list[tuple[int, int]] = field(default_factory=list)


@dataclass
class Part:
    """Nodes, elements and sets of one numbering."""

    name: str = ""
    ids: list[Indices] = field(default_factory=list)
    cells: list[tuple[str, Indices, Indices, str]] = field(
        default_factory=list
    )  # kind ids nodes set
    sets: list[tuple[str, str, Block]] = field(default_factory=list)  # ELSET or NSET, name, block


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

    def mesh(self) -> Mesh:
        for block in self._blocks():
            self._take(block)
        if not self.count:
            hint = f"; it includes {self.included[0]}: open that file" if self.included else ""
            raise self.source.failure(f"there is no *NODE block with nodes in this deck{hint}")
        starts, ends = self._coordinates()
        points = np.zeros((self.count, 3))
        flat = pick_numbers(self.source, starts.ravel(), ends.ravel())
        points[:, : starts.shape[1]] = flat.reshape(starts.shape)
        cells: dict[str, list[Indices]] = {}
        markers: Markers = {}
        first = 0
        for part in self.parts:
            first = self._resolve(part, first, cells, markers)
        joined = {kind: np.concatenate(nodes) for kind, nodes in cells.items()}
        template = TextTemplate(self.source.data, points, starts, ends)
        return Mesh(points, joined, markers, dimension=starts.shape[1], template=template)

    def _blocks(self) -> list[Block]:
        data, found = self.source.data, []
        at = 0
        while at < len(data):
            end = self.source.line_end(at)
            line = data[at:end].strip()
            if line.startswith(b"*") and not line.startswith(b"**"):
                while line.endswith(b",") and end < len(data):
                    begin, end = end, self.source.line_end(end)
                    line += data[begin:end].strip()
                found.append(self._block(line, at))
            next_star = at if line.startswith(b"*") else -1
            stop = self._next_star(end) if next_star >= 0 else self._next_star(at)
            if found and data[end:stop].strip():
                found[-1].spans.append((end, stop))
            at = stop
        return found

    def _next_star(self, at: int) -> int:
        """Begin of the next line that begins with a star, from the begin of a line on."""
        data = self.source.data
        if data[at : at + 1] == b"*":
            return at
        found = data.find(b"\n*", at)
        return len(data) if found < 0 else found + 1

    def _block(self, line: bytes, place: int) -> Block:
        words = line[1:].decode("utf-8", "replace").split(",")
        parameters = {}
        for word in words[1:]:
            key, _, value = word.partition("=")
            parameters[key.strip().upper()] = value.strip().strip('"')
        return Block(words[0].strip().upper(), parameters, place)

    def _take(self, block: Block) -> None:
        match block.keyword:
            case "NODE":
                self._nodes(block)
            case "ELEMENT":
                self._elements(block)
            case "NSET" | "ELSET":
                name = block.parameters.get(block.keyword, "")
                self.parts[-1].sets.append((block.keyword, name, block))
            case "PART":
                self.parts.append(Part(block.parameters.get("NAME", "part") + "/"))
            case "END PART":
                self.parts.append(Part())
            case "INCLUDE":
                self.included.append(block.parameters.get("INPUT", "another file"))
            case "SYSTEM" if block.spans:
                raise self.source.error(block.place, "nodes in a local frame (*SYSTEM)")

    def _tokens(self, block: Block) -> tuple[Indices, Indices, Indices]:
        """Begin and end of all words of a block, and the first one of each line."""
        parts = []
        total = 0
        for begin, end in block.spans:
            text = self.source.data[begin:end]
            starts, ends = split_tokens(text, b",")
            parts.append((starts + begin, ends + begin, line_firsts(text, starts) + total))
            total += len(starts)
        if not parts:
            none = np.empty(0, dtype=np.int64)
            return none, none, none
        starts, ends, first = (np.concatenate([part[k] for part in parts]) for k in range(3))
        return starts, ends, first

    def _nodes(self, block: Block) -> None:
        if block.parameters.get("SYSTEM", "R").upper() not in ("R", ""):
            raise self.source.error(block.place, "nodes in cylindrical or spherical coordinates")
        starts, ends, first = self._tokens(block)
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
        where = first[:, None] + np.arange(1, axes + 1)
        self.parts[-1].ids.append(pick_numbers(self.source, starts[first], ends[first], np.int64))
        self.starts.append(starts[where])
        self.ends.append(ends[where])
        self.count += len(first)
        if "NSET" in block.parameters:
            self.parts[-1].sets.append(("NODES", block.parameters["NSET"], block))

    def _coordinates(self) -> tuple[Indices, Indices]:
        return np.concatenate(self.starts), np.concatenate(self.ends)

    def _elements(self, block: Block) -> None:
        kind = kind_of(block.parameters.get("TYPE", ""))
        starts, ends, _ = self._tokens(block)
        if kind is None:
            warnings.warn(
                f"{self.source.path.name}: elements of type {block.parameters.get('TYPE', '?')} "
                "are kept but not shown",
                MeshWarning,
                stacklevel=2,
            )
            return
        name, count = kind
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
            if found and upper:
                name = part.name + names[upper]
                markers[f"{name} (nodes)" if name in markers else name] = found
        return first + len(ids)

    def _members(
        self, keyword: str, block: Block, sets: dict[tuple[str, str], list[Indices]]
    ) -> Indices:
        """Numbers in a set; other sets may be named in it."""
        starts, ends, first = self._tokens(block)
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

    def _generated(self, block: Block, words: list[bytes], first: Indices) -> Indices:
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
