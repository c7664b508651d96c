"""Cells and boundaries of the zones of a CGNS file."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats.cgns_boundaries import Parts, elements, kind_of, patch
from ffdstudio.meshes.formats.cgns_grids import Grid
from ffdstudio.meshes.formats.cgns_nodes import Node
from ffdstudio.meshes.formats.cgns_polyhedra import NFACE, Lists, Polyhedra
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import MIDDLE_BEFORE_TOP, block_cells
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.polyhedra import Loops, faced
from ffdstudio.meshes.topology import Cells, dimension

MIXED, NGON = 20, (22, 23)
TYPES = {  # CGNS's number -> name, number of nodes
    2: ("vertex", 1),
    3: ("line", 2),
    4: ("line3", 3),
    5: ("triangle", 3),
    6: ("triangle6", 6),
    7: ("quad", 4),
    8: ("quad8", 8),
    9: ("quad9", 9),
    10: ("tetra", 4),
    11: ("tetra10", 10),
    12: ("pyramid", 5),
    13: ("pyramid14", 14),
    14: ("wedge", 6),
    15: ("wedge15", 15),
    16: ("wedge18", 18),
    17: ("hexahedron", 8),
    18: ("hexahedron20", 20),
    19: ("hexahedron27", 27),
    21: ("pyramid13", 13),
}


class Zones:
    """What the zones add up to."""

    def __init__(self, source: Source, several: bool, version: float) -> None:
        self.source, self.several = source, several
        self.shifted = 3.0 <= version < 3.05  # a version of the library with numbers of its own
        self.cells: dict[str, list[Indices]] = {}
        self.markers: Markers = {}
        self.kinds: dict[str, str] = {}
        self.zones: set[str] = set()
        self.loops: list[Loops] = []
        self._made = Polyhedra(source)

    def mesh(self, points: Array, **given: Any) -> Mesh:
        """Mesh of all zones; of faces where there are cells made of faces."""
        cells = {kind: np.concatenate(parts) for kind, parts in self.cells.items()}
        if not self.loops:
            return Mesh(points, cells, self.markers, kinds=self.kinds, **given)
        loops, count = [], 0
        for part in self.loops:
            loops.append(Loops(part.nodes, part.sizes, part.cells + count))
            count += int(part.cells.max(initial=-1)) + 1
        solids = []
        for kind, nodes in cells.items():
            if dimension(kind) == 3:
                solids.append((kind, nodes, count + np.arange(len(nodes))))
                count += len(nodes)
        faces, lost = faced(points, cells, solids, loops, str(self.source.path))
        made = Mesh(points, {}, self.markers, faces=faces, kinds=self.kinds, **given)
        return replace(made, unread=lost)

    def add(self, zone: Node, grid: Grid, first: int, families: dict[str, str], name: str) -> None:
        """Add the cells and boundaries of a zone whose nodes begin at `first`.

        `families` has the kinds of its base's families; `name` is the zone's among several.
        """
        kind = zone.child("ZoneType")
        prefix = f"{name}/" if self.several else ""
        conditions = [node for group in zone.of("ZoneBC_t") for node in group.of("BC_t")]
        surfaces: dict[str, Cells] = {}
        if kind is not None and kind.text() == "Structured":
            cells = block_cells(grid.dims)
            found = {node.name: patch(self.source, node, grid.dims) for node in conditions}
        else:
            count = len(grid.kept)
            self._made = Polyhedra(self.source)
            sections = [(node.name, self._section(node, count)) for node in zone.of("Elements_t")]
            parts = [part for _, part in sections]
            loops = self._made.loops()
            if loops is not None:  # faces of cells are no surfaces
                self.loops.append(Loops(loops.nodes + first, loops.sizes, loops.cells))
                sections = [
                    pair
                    for pair in sections
                    if not any(pair[1] is part for part in self._made.parts)
                ]
            cells, surfaces = _by_dimension(sections)
            found = {node.name: elements(self.source, node, parts, count) for node in conditions}
        self._warn_of_missing([prefix + title for title, cells in found.items() if not cells])
        for title, nodes in cells.items():
            self.cells.setdefault(title, []).append(first + nodes)
        if self.several:
            self.markers[name] = _moved(cells, first)
            self.zones.add(name)
        titles = {node.name: self._title(node, families, prefix) for node in conditions}
        for title, cells in found.items():
            self._add(titles[title], _moved(cells, first))
        for title, cells in surfaces.items():
            if not _covers(found.values(), cells):
                self._add(prefix + title, _moved(cells, first))
        for node in conditions:
            kind_is, title = kind_of(node, families), titles[node.name]
            if kind_is and title in self.markers:
                self.kinds.setdefault(title, kind_is)

    def _title(self, node: Node, families: dict[str, str], prefix: str) -> str:
        """Name of a condition's family, which users know, or its own."""
        family = next((child.text().rpartition("/")[2] for child in node.of("FamilyName_t")), "")
        if not family:
            return prefix + node.name
        return f"{family} (boundary)" if family in self.zones else family

    def _add(self, title: str, cells: Cells) -> None:
        """Add to a marker."""
        if cells:
            old = self.markers.setdefault(title, {})
            for name, nodes in cells.items():
                old[name] = np.concatenate([old[name], nodes]) if name in old else nodes

    def _warn_of_missing(self, names: list[str]) -> None:
        if names:
            warnings.warn(
                f"{self.source.path.name}: boundaries without faces or nodes that are known here "
                f"are kept but not shown: {', '.join(names)}",
                MeshWarning,
                stacklevel=2,
            )

    def _section(self, node: Node, count: int) -> Parts:
        """By type the nodes of a section's elements and their numbers."""
        limits, nodes = node.child("ElementRange"), node.child("ElementConnectivity")
        if limits is None or nodes is None or len(limits.values()) < 2 or not len(node.values()):
            raise self.source.failure(f"section {node.name} has no range or no nodes")
        if any(part.values().dtype.kind not in "iu" for part in (limits, node, nodes)):
            raise self.source.failure(f"section {node.name} holds something that is no number")
        begin, end = (int(n) for n in limits.values()[:2])
        number, flat = self._number(int(node.values()[0])), nodes.values().astype(np.int64)
        if number in NGON:
            found = Lists(self.source, node, flat, end - begin + 1)
            if number == NFACE:
                self._made.cells.append(found)
                return {}
            return self._made.take_faces(node, begin, found, count)
        if number == MIXED:
            return self._mixed(node, flat, begin, end - begin + 1, count)
        if number not in TYPES:
            raise self.source.failure(f"section {node.name} has elements of unknown type {number}")
        name, size = TYPES[number]
        many = end - begin + 1
        if many < 0 or many * size != len(flat):
            raise self.source.failure(
                f"section {node.name} does not have {many} times {size} nodes"
            )
        rows = self._checked(node, flat.reshape(many, size) - 1, count)
        return {name: (rows[:, _order(name)], begin + np.arange(many))}

    def _number(self, number: int) -> int:
        """Number of an element type: version 3.0 alone put PYRA_13 between others."""
        if not self.shifted or not 13 <= number <= 21:
            return number
        return 21 if number == 13 else number - 1

    def _mixed(self, node: Node, flat: Indices, begin: int, many: int, count: int) -> Parts:
        numbers, places, at = flat.tolist(), [], 0
        if self.shifted:
            numbers, flat = self._renumbered(node, flat)
        while at < len(numbers):
            if numbers[at] not in TYPES:
                raise self.source.failure(f"section {node.name} has an element of unknown type")
            places.append(at)
            at += 1 + TYPES[numbers[at]][1]
        if at != len(numbers) or len(places) != many:
            raise self.source.failure(f"section {node.name} does not have {many} elements")
        where = np.array(places, dtype=np.int64)
        found = {}
        for number in np.unique(flat[where]).tolist():
            name, size = TYPES[number]
            chosen = np.flatnonzero(flat[where] == number)
            rows = flat[where[chosen][:, None] + np.arange(1, size + 1)] - 1
            rows = self._checked(node, rows, count)
            found[name] = rows[:, _order(name)], begin + chosen
        return found

    def _renumbered(self, node: Node, flat: Indices) -> tuple[list[int], Indices]:
        """Elements that state their type, with the numbers of other versions."""
        numbers, at = flat.tolist(), 0
        while at < len(numbers):
            numbers[at] = self._number(numbers[at])
            if numbers[at] not in TYPES:
                raise self.source.failure(f"section {node.name} has an element of unknown type")
            at += 1 + TYPES[numbers[at]][1]
        return numbers, np.array(numbers, dtype=np.int64)

    def _checked(self, node: Node, rows: Indices, count: int) -> Indices:
        if rows.size and not (rows.min() >= 0 and rows.max() < count):
            raise self.source.failure(f"section {node.name} refers to a node not in 1 to {count}")
        return rows


def _by_dimension(sections: list[tuple[str, Parts]]) -> tuple[Cells, dict[str, Cells]]:
    """Cells of the highest dimension, and those of lower ones by the name of their section."""
    dims = [dimension(name) for _, cells in sections for name in cells]
    highest = max(dims, default=3)
    cells: dict[str, list[Indices]] = {}
    surfaces: dict[str, Cells] = {}
    for title, parts in sections:
        for name, (nodes, _) in parts.items():
            if dimension(name) == highest:
                cells.setdefault(name, []).append(nodes)
            else:
                surfaces.setdefault(title, {})[name] = nodes
    return {name: np.concatenate(parts) for name, parts in cells.items()}, surfaces


def _covers(found: Iterable[Cells], cells: Cells) -> bool:
    """Whether boundary conditions have all of these faces."""
    listed: dict[str, list[Indices]] = {}
    for part in found:
        for name, nodes in part.items():
            listed.setdefault(name, []).append(nodes)
    for name, nodes in cells.items():
        known = np.concatenate([*listed.get(name, []), nodes[:0]])
        both = np.sort(np.concatenate([known, nodes]), axis=1)
        _, rows = np.unique(both, axis=0, return_inverse=True)
        if not np.isin(rows[len(known) :], rows[: len(known)]).all():
            return False
    return True


def _moved(cells: Cells, first: int) -> Cells:
    return {name: first + nodes for name, nodes in cells.items()}


def _order(name: str) -> list[int] | slice:
    return MIDDLE_BEFORE_TOP.get(name, slice(None))
