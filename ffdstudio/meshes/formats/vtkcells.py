"""VTK's cell types, and the cells of structured blocks: shared by several formats."""

from __future__ import annotations

import warnings
from collections import Counter

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Mesh, MeshWarning, Template
from ffdstudio.meshes.polyhedra import Loops, faced
from ffdstudio.meshes.topology import CORNERS, Cells, dimension

SIZED = {  # VTK's number -> name and number of nodes
    1: ("vertex", 1),
    3: ("line", 2),
    5: ("triangle", 3),
    9: ("quad", 4),
    10: ("tetra", 4),
    12: ("hexahedron", 8),
    13: ("wedge", 6),
    14: ("pyramid", 5),
    21: ("line3", 3),
    22: ("triangle6", 6),
    23: ("quad8", 8),
    24: ("tetra10", 10),
    25: ("hexahedron20", 20),
    26: ("wedge15", 15),
    27: ("pyramid13", 13),
    28: ("quad9", 9),
    29: ("hexahedron27", 27),
    30: ("quad6", 6),
    31: ("wedge12", 12),
    32: ("wedge18", 18),
    33: ("hexahedron24", 24),
    34: ("triangle7", 7),
    37: ("pyramid19", 19),
}
LAGRANGE = {  # VTK's number -> its corners; of any order, told by the number of nodes
    69: "triangle",
    70: "quad",
    71: "tetra",
    72: "hexahedron",
    73: "wedge",
    74: "pyramid",
}
SLENDER = (0, 2, 4, 35, 60, 68, 75)  # nothing, points, lines and curves
STRIP, POLYHEDRON, PRISM_TYPES = 6, 42, {15: 10, 16: 12}
SWAPPED = {8: ("quad", [0, 1, 3, 2]), 11: ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6])}
POLYGON = 7
MIDDLE_BEFORE_TOP = {  # VTK's order for formats that list the middle edges before the upper ones
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "wedge18": [*range(9), 12, 13, 14, 9, 10, 11, 15, 16, 17],
}


class Collected:
    """Cells of a VTK file, piece by piece.

    Attributes
    ----------
    unread : Counter
        Cells with an area or a volume of types that are not known here.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.unread: Counter[str] = Counter()
        self._parts: dict[str, list[Indices]] = {}
        self._solids: list[tuple[str, Indices, Indices]] = []  # type, nodes, place in the file
        self._loops: list[Loops] = []
        self._count = 0  # cells of the pieces so far

    def take(self, cells: Cells, first: int = 0) -> None:
        """Add cells of known types whose nodes begin at `first`."""
        for name, nodes in cells.items():
            self._parts.setdefault(name, []).append(nodes + first)

    def add(
        self,
        offsets: Indices,
        nodes: Indices,
        types: Indices,
        count: int,
        first: int = 0,
        polyhedra: Loops | None = None,
    ) -> None:
        """Add the cells of a piece from VTK's flat arrays.

        Parameters
        ----------
        offsets : numpy.ndarray
            (cells + 1,) where each cell begins in `nodes`.
        nodes, types : numpy.ndarray
            Node indices of all cells, and VTK's number for each cell.
        count, first : int
            Number of points of the piece, and of those before it.
        polyhedra : Loops, optional
            Faces of the polyhedra, by the number of the cell in the piece.

        Raises
        ------
        InputError
            If the arrays do not fit each other or a node does not exist.
        """
        sizes = np.diff(offsets)
        fit = len(sizes) == len(types) and offsets[0] == 0 and offsets[-1] <= len(nodes)
        if not fit or (sizes < 0).any():
            raise self.source.failure("the offsets, nodes and types of the cells do not fit")
        self._check(nodes, count)
        for number in np.unique(types).tolist():
            chosen = np.flatnonzero(types == number)
            place = self._count + chosen
            if number == STRIP:
                self.take({"triangle": strips(nodes, offsets[chosen], sizes[chosen])}, first)
            elif number == POLYHEDRON:
                self._polyhedra(polyhedra, len(chosen), count, first)
            elif number in PRISM_TYPES:
                self._sized(chosen, sizes, PRISM_TYPES[number], "prism")
                rows = nodes[offsets[chosen][:, None] + np.arange(PRISM_TYPES[number])]
                self._solids.append(("prism", rows + first, place))
            else:
                for name, rows in self._rows(number, offsets[chosen], sizes[chosen]):
                    self._parts.setdefault(name, []).append(nodes[rows] + first)
                    self._remember(name, place)
        self._count += len(types)

    def _remember(self, name: str, place: Indices) -> None:
        if dimension(name) == 3:
            self._solids.append((name, self._parts[name][-1], place))

    def _check(self, nodes: Indices, count: int) -> None:
        if nodes.size and not (nodes.min() >= 0 and nodes.max() < count):
            raise self.source.failure(f"a cell refers to a point that is not in 0 to {count - 1}")

    def _sized(self, chosen: Indices, sizes: Indices, wanted: int, name: str) -> None:
        if (sizes[chosen] != wanted).any():
            raise self.source.failure(f"a {name} with another number of nodes than {wanted}")

    def _polyhedra(self, found: Loops | None, many: int, count: int, first: int) -> None:
        if found is None:
            self.unread["polyhedron"] += many
            self._warn(POLYHEDRON)
            return
        self._check(found.nodes, count)
        if len(np.unique(found.cells)) != many or (found.sizes < 3).any():
            raise self.source.failure("the faces of the polyhedra do not fit the cells")
        self._loops.append(Loops(found.nodes + first, found.sizes, found.cells + self._count))

    def _rows(self, number: int, begins: Indices, sizes: Indices) -> list[tuple[str, Indices]]:
        """Names and places of the nodes of cells that have the same VTK number."""
        if number in SIZED or number in SWAPPED:
            name, order = SWAPPED.get(number) or (SIZED[number][0], list(range(SIZED[number][1])))
            self._sized(np.arange(len(sizes)), sizes, len(order), name)
            return [(name, begins[:, None] + np.array(order))]
        if number in SLENDER:
            return []
        if number in LAGRANGE:
            return [
                (name_of(LAGRANGE[number], size), begins[sizes == size][:, None] + np.arange(size))
                for size in np.unique(sizes).tolist()
            ]
        if number != POLYGON:
            self.unread[f"VTK type {number}"] += len(begins)
            self._warn(number)
            return []
        return [
            (polygon_name(size), begins[sizes == size][:, None] + np.arange(size))
            for size in np.unique(sizes).tolist()
            if size > 0
        ]

    def _warn(self, number: int) -> None:
        warnings.warn(
            f"{self.source.path.name}: cells of VTK's type {number} are kept but not shown",
            MeshWarning,
            stacklevel=2,
        )

    def mesh(self, points: Array, template: Template) -> Mesh:
        """Mesh of all pieces; of faces where there are polyhedra."""
        cells = {name: np.concatenate(found) for name, found in self._parts.items()}
        if not self._loops and not any(name == "prism" for name, _, _ in self._solids):
            return Mesh(points, cells, unread=dict(self.unread), template=template)
        faces, unread = faced(points, cells, self._solids, self._loops, str(self.source.path))
        unread = dict(self.unread + Counter(unread))
        return Mesh(points, faces=faces, unread=unread, template=template)


def strips(nodes: Indices, begins: Indices, sizes: Indices) -> Indices:
    """Triangles of strips: every second one is turned round, so that all look the same way.

    Examples
    --------
    >>> strips(np.array([7, 8, 9, 6]), np.array([0]), np.array([4])).tolist()
    [[7, 8, 9], [9, 8, 6]]
    """
    many = np.maximum(sizes - 2, 0)
    step = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
    rows = nodes[np.repeat(begins, many)[:, None] + step[:, None] + np.arange(3)]
    odd = step % 2 == 1
    rows[odd] = rows[odd][:, [1, 0, 2]]
    kept: Indices = rows[(rows != np.roll(rows, 1, axis=1)).all(axis=1)]
    return kept


def streams(values: Indices, begins: Indices, cells: Indices) -> Loops:
    """Faces of polyhedra from VTK's streams: how many faces, then size and nodes of each.

    Raises
    ------
    IndexError
        If a stream runs beyond the values.
    """
    starts: list[int] = []
    sizes: list[int] = []
    owner: list[int] = []
    for begin, cell in zip(begins.tolist(), cells.tolist(), strict=True):
        at = begin + 1
        for _ in range(int(values[begin])):
            size = int(values[at])
            if size < 0 or at + size >= len(values):
                raise IndexError(at)
            starts.append(at + 1)
            sizes.append(size)
            owner.append(cell)
            at += size + 1
    many = np.array(sizes, dtype=np.int64)
    step = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
    nodes = values[np.repeat(np.array(starts, dtype=np.int64), many) + step]
    return Loops(nodes, many, np.array(owner, dtype=np.int64))


def name_of(base: str, size: int) -> str:
    """Type of a cell with that many nodes.

    Examples
    --------
    >>> name_of("hexahedron", 64), name_of("hexahedron", 8)
    ('hexahedron64', 'hexahedron')
    """
    return base if size == CORNERS[base] else f"{base}{size}"


def polygon_name(size: int) -> str:
    """Type of a face with that many corners.

    Examples
    --------
    >>> polygon_name(4), polygon_name(5)
    ('quad', 'polygon5')
    """
    return {1: "vertex", 2: "line", 3: "triangle", 4: "quad"}.get(size, f"polygon{size}")


def offsets_of(sizes: Indices) -> Indices:
    """(k + 1,) where each of k lists of these sizes begins when they follow each other."""
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def block_cells(shape: tuple[int, ...], first: int = 0) -> Cells:
    """Cells of a structured block of nodes, the first index running fastest.

    Directions with a single node do not count: a block of one layer gives quads.

    Examples
    --------
    >>> block_cells((2, 2, 1))
    {'quad': array([[0, 1, 3, 2]])}
    """
    index = first + np.arange(int(np.prod(shape)), dtype=np.int64).reshape(shape[::-1])
    index = index.reshape([n for n in shape[::-1] if n > 1])
    match index.ndim:
        case 1:
            return {"line": np.stack([index[:-1], index[1:]], axis=1)}
        case 2:
            return {"quad": _quads(index[:-1], index[1:])}
        case 3:
            layers = [_layer(index[:-1]), _layer(index[1:])]
            return {"hexahedron": np.concatenate(layers, axis=1)}
    return {}


def _quads(low: Indices, high: Indices) -> Indices:
    corners = [low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]]
    return np.stack([corner.ravel() for corner in corners], axis=1)


def _layer(index: Indices) -> Indices:
    """Quads of every layer of a block, (k, 4)."""
    corners = [index[:, :-1, :-1], index[:, :-1, 1:], index[:, 1:, 1:], index[:, 1:, :-1]]
    return np.stack([corner.ravel() for corner in corners], axis=1)
