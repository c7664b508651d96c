"""Cells and boundaries of the zones of a CGNS file."""

from __future__ import annotations

import warnings

import numpy as np

from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.tree import Node
from ffdstudio.meshes.formats.vtkcells import MIDDLE_BEFORE_TOP, block_cells
from ffdstudio.meshes.mesh import Markers, MeshWarning
from ffdstudio.meshes.topology import Cells, Indices, dimension

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
KINDS = {
    "Wall": "wall",
    "Symmetry": "symmetry",
    "Farfield": "farfield",
    "Inflow": "inflow",
    "Outflow": "outflow",
}


class Zones:
    """What the zones add up to."""

    def __init__(self, source: Source, several: bool) -> None:
        self.source, self.several = source, several
        self.cells: dict[str, list[Indices]] = {}
        self.markers: Markers = {}
        self.kinds: dict[str, str] = {}

    def add(self, zone: Node, coordinate: Node, first: int) -> None:
        """Add the cells and boundaries of a zone whose nodes begin at `first`."""
        kind = zone.child("ZoneType")
        prefix = f"{zone.name}/" if self.several else ""
        if kind is not None and kind.text() == "Structured":
            cells = block_cells(coordinate.dims, first)
            boundaries = self._patches(zone, coordinate.dims, first)
        else:
            cells, boundaries = self._sections(zone, len(coordinate.values()), first)
        for name, nodes in cells.items():
            self.cells.setdefault(name, []).append(nodes)
        if self.several:
            self.markers[zone.name] = cells
        for name, (elements, kind_name) in boundaries.items():
            self.markers[prefix + name] = elements
            if kind_name:
                self.kinds[prefix + name] = kind_name

    def _conditions(self, zone: Node) -> list[Node]:
        return [node for group in zone.of("ZoneBC_t") for node in group.of("BC_t")]

    def _patches(
        self, zone: Node, dims: tuple[int, ...], first: int
    ) -> dict[str, tuple[Cells, str]]:
        """Boundary conditions of a structured zone, given by the corners of a range."""
        found = {}
        for node in self._conditions(zone):
            corners = node.child("PointRange")
            if corners is None or len(corners.values()) != 2 * len(dims):
                continue
            ends = corners.values().astype(np.int64).reshape(2, -1)
            low, high = ends.min(axis=0), ends.max(axis=0)
            if (low < 1).any() or (high > np.array(dims)).any():
                raise self.source.failure(f"boundary {node.name} lies outside its zone")
            part = np.ix_(
                *(np.arange(a - 1, b) for a, b in zip(low[::-1], high[::-1], strict=True))
            )
            rows = np.arange(int(np.prod(dims))).reshape(dims[::-1])[part].ravel()
            shape = tuple((high - low + 1).tolist())
            cells = {name: first + rows[nodes] for name, nodes in block_cells(shape).items()}
            found[node.name] = cells, _kind(node)
        return found

    def _sections(
        self, zone: Node, count: int, first: int
    ) -> tuple[Cells, dict[str, tuple[Cells, str]]]:
        """Cells and boundaries of an unstructured zone."""
        sections = [(node.name, *self._section(node, count)) for node in zone.of("Elements_t")]
        dims = [dimension(name) for _, _, cells in sections for name in cells]
        highest = max(dims, default=3)
        cells: dict[str, list[Indices]] = {}
        surfaces: dict[str, tuple[Cells, str]] = {}
        for title, _, parts in sections:
            for name, (nodes, _) in parts.items():
                if dimension(name) == highest:
                    cells.setdefault(name, []).append(first + nodes)
                else:
                    own = surfaces.setdefault(title, ({}, ""))[0]
                    own[name] = first + nodes
        conditions = {}
        for node in self._conditions(zone):
            elements = self._listed(node, sections, first)
            if elements:
                conditions[node.name] = elements, _kind(node)
        joined = {name: np.concatenate(parts) for name, parts in cells.items()}
        return joined, conditions or surfaces

    def _section(self, node: Node, count: int) -> tuple[int, dict[str, tuple[Indices, Indices]]]:
        """First number of a section, and by type its nodes and numbers."""
        limits, nodes = node.child("ElementRange"), node.child("ElementConnectivity")
        if limits is None or nodes is None or len(limits.values()) < 2 or not len(node.values()):
            raise self.source.failure(f"section {node.name} has no range or no nodes")
        begin, end = (int(n) for n in limits.values()[:2])
        number, flat = int(node.values()[0]), nodes.values().astype(np.int64)
        if number in NGON:
            warnings.warn(
                f"{self.source.path.name}: cells made of faces are kept but not shown",
                MeshWarning,
                stacklevel=2,
            )
            return begin, {}
        if number == MIXED:
            return begin, self._mixed(node, flat, begin, end - begin + 1, count)
        if number not in TYPES:
            raise self.source.failure(f"section {node.name} has elements of unknown type {number}")
        name, size = TYPES[number]
        many = end - begin + 1
        if many < 0 or many * size != len(flat):
            raise self.source.failure(
                f"section {node.name} does not have {many} times {size} nodes"
            )
        rows = self._checked(node, flat.reshape(many, size) - 1, count)
        return begin, {name: (rows[:, _order(name)], begin + np.arange(many))}

    def _mixed(
        self, node: Node, flat: Indices, begin: int, many: int, count: int
    ) -> dict[str, tuple[Indices, Indices]]:
        numbers, places, at = flat.tolist(), [], 0
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

    def _checked(self, node: Node, rows: Indices, count: int) -> Indices:
        if rows.size and not (rows.min() >= 0 and rows.max() < count):
            raise self.source.failure(f"section {node.name} refers to a node not in 1 to {count}")
        return rows

    def _listed(
        self,
        node: Node,
        sections: list[tuple[str, int, dict[str, tuple[Indices, Indices]]]],
        first: int,
    ) -> Cells:
        """Elements that a boundary condition lists by number or range."""
        wanted = np.empty(0, dtype=np.int64)
        for name in ("ElementList", "PointList"):
            child = node.child(name)
            wanted = wanted if child is None else child.values().astype(np.int64)
        for name in ("ElementRange", "PointRange"):
            child = node.child(name)
            if child is not None and len(child.values()) == 2:
                low, high = (int(n) for n in child.values())
                if high - low > len(self.source.data):
                    raise self.source.failure(f"boundary {node.name} has an impossible range")
                wanted = np.arange(low, high + 1)
        location = node.child("GridLocation")
        by_node = (location is None or location.text() == "Vertex") and node.child(
            "ElementList"
        ) is None
        if by_node and node.child("ElementRange") is None:
            return {}
        found: dict[str, list[Indices]] = {}
        for _, _, parts in sections:
            for name, (nodes, numbers) in parts.items():
                chosen = np.isin(numbers, wanted)
                if chosen.any():
                    found.setdefault(name, []).append(first + nodes[chosen])
        return {name: np.concatenate(nodes) for name, nodes in found.items()}


def _order(name: str) -> list[int] | slice:
    return MIDDLE_BEFORE_TOP.get(name, slice(None))


def _kind(node: Node) -> str:
    """Our name for the kind of a boundary condition, or CGNS's own."""
    text = node.text().removeprefix("BC")
    return next((kind for word, kind in KINDS.items() if text.startswith(word)), text)
