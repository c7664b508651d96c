"""Sets and surfaces of an Abaqus deck as markers.

Source: Abaqus keywords reference (*ELSET, *NSET, *SURFACE) and element library (face numbers).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.abaqus_blocks import DeckBlock, tokens
from ffdstudio.meshes.formats.number_table import pick_numbers
from ffdstudio.meshes.formats.source import decoded
from ffdstudio.meshes.mesh import Markers
from ffdstudio.meshes.topology import Cells, dimension

FACES = {  # corners of face S1, S2, ...
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
}
NAMES = {2: "line", 3: "triangle", 4: "quad"}
WHOLE = ("", "SPOS", "SNEG")  # of a shell: the element itself


@dataclass
class Part:
    """Nodes, elements and sets of one numbering."""

    name: str = ""
    ids: list[Indices] = field(default_factory=list)
    cells: list[tuple[str, Indices, Indices, str]] = field(
        default_factory=list
    )  # kind, numbers, nodes, set
    sets: list[tuple[str, str, DeckBlock]] = field(
        default_factory=list
    )  # ELSET, NSET, NODES or SURFACE; name; block


class Sets:
    """The sets of a part whose elements (kind, numbers, rows of nodes) are known."""

    def __init__(
        self,
        part: Part,
        elements: list[tuple[str, Indices, Indices]],
        rows: Callable[[Indices], Indices],
        warn: Callable[[str], None],
    ) -> None:
        self.part, self.elements, self.rows, self.warn = part, elements, rows, warn
        self.members: dict[tuple[str, str], list[Indices]] = {}
        self.names: dict[str, str] = {}

    def add_to(self, markers: Markers) -> None:
        """Add a marker for each set and surface; what cannot be shown is told."""
        for _, numbers, _, own in self.part.cells:
            self._remember("ELSET", own, numbers)
        for keyword, name, block in self.part.sets:
            if keyword != "SURFACE":
                key = "NSET" if keyword == "NODES" else keyword
                self._remember(key, name, self._listed(keyword, block))
        for (keyword, upper), found in self.members.items():
            self._show(markers, self.names[upper], self._cells(keyword, np.unique(_joined(found))))
        for keyword, name, block in self.part.sets:
            if keyword == "SURFACE":
                self._show(markers, name, self._surface(block))

    def _remember(self, keyword: str, name: str, numbers: Indices) -> None:
        if name:
            self.members.setdefault((keyword, name.upper()), []).append(numbers)
            self.names[name.upper()] = name

    def _show(self, markers: Markers, name: str, cells: Cells) -> None:
        title = self.part.name + name
        if not cells:
            self.warn(f"set {name} is kept but not shown: none of its members is known here")
        elif name:
            kind = "nodes" if set(cells) == {"vertex"} else "surface"
            markers[f"{title} ({kind})" if title in markers else title] = cells

    def _listed(self, keyword: str, block: DeckBlock) -> Indices:
        """Numbers in a set; other sets may be named in it, or the elements whose nodes it has."""
        starts, ends, first = tokens(block)
        if keyword == "NODES":
            return pick_numbers(block.source, starts[first], ends[first], np.int64)
        data = block.source.data
        words = [data[i:j] for i, j in zip(starts.tolist(), ends.tolist(), strict=True)]
        if "GENERATE" in block.parameters:
            return _generated(block, words, first)
        found = [np.array([int(word) for word in words if word.isdigit()], dtype=np.int64)]
        for word in words:
            if not word.isdigit():
                found += self.members.get((keyword, decoded(word).strip('"').upper()), [])
        if keyword == "NSET" and "ELSET" in block.parameters:
            found += self._nodes_of(block.parameters["ELSET"])
        return np.concatenate(found)

    def _nodes_of(self, name: str) -> list[Indices]:
        """Numbers of the nodes of an element set."""
        chosen = _joined(self.members.get(("ELSET", name.upper()), []))
        parts = [
            nodes[np.isin(numbers, chosen)].ravel() for _, numbers, nodes, _ in self.part.cells
        ]
        return [np.unique(part) for part in parts]

    def _cells(self, keyword: str, members: Indices) -> Cells:
        if keyword == "NSET":
            rows = self.rows(members)
            return {"vertex": rows[:, None]} if len(rows) else {}
        parts: dict[str, list[Indices]] = {}
        for kind, numbers, rows in self.elements:
            chosen = np.isin(numbers, members)
            if chosen.any():
                parts.setdefault(kind, []).append(rows[chosen])
        return {kind: np.concatenate(found) for kind, found in parts.items()}

    def _surface(self, block: DeckBlock) -> Cells:
        """Faces, or nodes, that the lines of a surface name."""
        keyword = "NSET" if block.parameters.get("TYPE", "").upper() == "NODE" else "ELSET"
        parts: dict[str, list[Indices]] = {}
        for begin, end in block.spans:
            for line in block.source.data[begin:end].splitlines():
                words = [decoded(word).strip().strip('"') for word in line.split(b",")]
                if not words[0] or words[0].startswith("*"):
                    continue
                side = words[1].upper() if len(words) > 1 else ""
                for kind, nodes in self._faces(keyword, words[0], side).items():
                    parts.setdefault(kind, []).append(nodes)
        return {kind: np.concatenate(found) for kind, found in parts.items()}

    def _faces(self, keyword: str, who: str, side: str) -> Cells:
        members = self.members.get((keyword, who.upper()), [])
        chosen = np.array([int(who)]) if who.isdigit() else np.unique(_joined(members))
        cells = self._cells(keyword, chosen)
        if keyword == "NSET":
            return cells
        found: Cells = {}
        for kind, rows in cells.items():
            base = kind.rstrip("0123456789")
            flat = dimension(kind) == 2
            sides = FACES.get(base, ())
            place = int(side[1:]) - 1 if side[:1] in ("S", "E") and side[1:].isdigit() else -1
            if flat and side in WHOLE:
                found[kind] = rows
            elif 0 <= place < len(sides):
                name = NAMES[len(sides[place])]
                faces = rows[:, list(sides[place])]
                found[name] = np.concatenate([found[name], faces]) if name in found else faces
        return found


def _joined(parts: list[Indices]) -> Indices:
    return np.concatenate([np.empty(0, dtype=np.int64), *parts])


def _generated(block: DeckBlock, words: list[bytes], first: Indices) -> Indices:
    """Numbers from first to last in steps."""
    source, found = block.source, [np.empty(0, dtype=np.int64)]
    for begin, end in zip(first, [*first[1:], len(words)], strict=False):
        line = [source.integer(w, block.place, "a number") for w in words[begin:end]]
        low, high, step = (*line, 1) if len(line) == 2 else (*line, 0, 0, 0)[:3]
        if step < 1 or (high - low) // step > len(source.data):
            raise source.error(block.place, "GENERATE needs first, last and step")
        found.append(np.arange(low, high + 1, step))
    return np.concatenate(found)
