"""The cells that quality speaks of, sorted by type.

1. Only cells of the highest dimension count: triangles beside tetrahedra are a boundary.
2. The measures of cells of higher order are those of their corners; whether they are inverted
   is told by all their nodes (`curved`), except on surfaces in space.
3. Cells of a face-based mesh that are tetrahedra, pyramids, wedges or hexahedra are treated as
   such. Any other polyhedron is split into tetrahedra: an edge of a face, the mean of the
   face's nodes, the mean of the cell's nodes. Both means follow the nodes linearly. A polygon
   is split into triangles in the same way.
4. Results are numbered as the cells are in the file: type after type as in `mesh.cells`, or
   by the cell index of a face-based mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.meshes.measures.curved import order_of, split
from ffdstudio.meshes.measures.recognise import ramps, recognised, sides, trihedra
from ffdstudio.meshes.mesh import Faces, Mesh
from ffdstudio.meshes.topology import Cells, base_type, corners, dimension

Groups = tuple[tuple[Indices, Indices], ...]
CORNERS = {  # a corner and its neighbours, in the order that makes a good cell positive
    "triangle": ((0, 1, 2),),
    "quad": ((0, 1, 3), (1, 2, 0), (2, 3, 1), (3, 0, 2)),
    "polygon": ((0, 1, 2),),
    "tetra": ((0, 1, 2, 3),),
    "pyramid": ((0, 1, 3, 4), (1, 2, 0, 4), (2, 3, 1, 4), (3, 0, 2, 4)),
    "wedge": ((0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)),
    "hexahedron": (
        (0, 1, 3, 4),
        (1, 2, 0, 5),
        (2, 3, 1, 6),
        (3, 0, 2, 7),
        (4, 7, 5, 0),
        (5, 4, 6, 1),
        (6, 5, 7, 2),
        (7, 6, 4, 3),
    ),
    "polyhedron": ((0, 1, 2, 3),),
}


@dataclass(frozen=True, eq=False)
class CellBlock:
    """Cells of one type: (k, nodes) and their numbers; simplices of polyhedra and polygons."""

    type: str
    nodes: Indices
    cells: Indices

    @property
    def corners(self) -> tuple[tuple[int, ...], ...]:
        """Node positions of the simplices whose signs make a cell valid."""
        return CORNERS[self.type]

    def __getitem__(self, chosen: np.ndarray | slice) -> CellBlock:
        return CellBlock(self.type, self.nodes[chosen], self.cells[chosen])


@dataclass(frozen=True, eq=False)
class Blocks:
    """Cells of the highest dimension.

    Attributes
    ----------
    dimension : int
        Of the cells: 3, or 2 for plane meshes and surfaces.
    flat : bool
        Whether the cells lie in the plane z = 0 of a 2D mesh.
    count : int
        Number of cells.
    blocks : tuple of CellBlock
    groups : tuple
        Groups of nodes whose mean is a point of its own: flat nodes and offsets. The
        means are numbered behind the nodes.
    trihedra : CellBlock, optional
        Corners of polyhedra where three edges meet, for their scaled Jacobian.
    curved : tuple of CellBlock
        Those of higher order once more, with all their nodes and the type that tells them.
    """

    dimension: int
    flat: bool
    count: int
    blocks: tuple[CellBlock, ...]
    groups: Groups = ()
    trihedra: CellBlock | None = None
    curved: tuple[CellBlock, ...] = ()

    def extended(self, points: Array) -> Array:
        """Points, or any value at the points, with the means behind them."""
        means = [_mean(points, *group) for group in self.groups]
        return np.concatenate([points, *means]) if means else points

    def upright(self, points: Array) -> Array | None:
        """Return the points whose normals count as up: none are needed in a plane or in space."""
        return points if self.dimension == 2 and not self.flat else None

    def moved(self, points: Array, new: Array) -> Mask:
        """Mask of the extended points that differ between two states of the points."""
        return self.spread((new != points).any(axis=1))

    def spread(self, moved: Mask) -> Mask:
        """Mask of the extended points that follow a moved one."""
        if not self.groups:
            return moved
        return self.extended(moved.astype(np.float64)[:, None])[:, 0] > 0

    def moved_cells(self, moved: np.ndarray) -> np.ndarray:
        """Mask of the cells with a moved node; `moved` is a mask of the points."""
        from ffdstudio.meshes.measures.corner_kernels import touched
        from ffdstudio.meshes.measures.work import shared

        mask, out = self.spread(moved), np.zeros(self.count, dtype=bool)
        for block in (*self.blocks, *self.curved):
            shared(touched, np.arange(len(block.nodes)), block.nodes, block.cells, mask, out)
        return out

    def of_cells(self, chosen: np.ndarray) -> tuple[CellBlock, ...]:
        """Blocks of the cells in a mask."""
        return tuple(block[chosen[block.cells]] for block in self.blocks)


_known: WeakKeyDictionary[Mesh, Blocks] = WeakKeyDictionary()


def blocks_of(mesh: Mesh) -> Blocks:
    """Cells of a mesh, sorted once."""
    if mesh not in _known:
        _known[mesh] = _faced(mesh) if mesh.faces is not None else _listed(mesh)
    return _known[mesh]


def is_checkable(kind: str) -> bool:
    """Whether cells of this type can be checked for inversion."""
    return base_type(kind) in CORNERS


def is_seen(kind: str) -> bool:
    """Whether all nodes of cells of this type are looked at, and not their corners alone."""
    base, count = split(kind)
    return is_checkable(kind) and (count == 0 or base == "polygon" or order_of(kind) > 0)


def top_dimension(cells: Cells) -> int:
    """Highest dimension of the cells that can be checked."""
    return max((dimension(kind) for kind in cells if is_checkable(kind)), default=0)


def _listed(mesh: Mesh) -> Blocks:
    top = top_dimension(mesh.cells)
    blocks, groups, count, virtual = [], [], 0, len(mesh.points)
    curved: list[CellBlock] = []
    flat = mesh.dimension == 2
    for kind, nodes in mesh.cells.items():
        if dimension(kind) != top or not is_checkable(kind):
            continue
        base, corner = base_type(kind), np.ascontiguousarray(corners(kind, nodes))
        ids = np.arange(count, count + len(corner))
        count += len(corner)
        if base == "polygon":
            size = corner.shape[1]
            mean = np.arange(virtual, virtual + len(corner))
            virtual += len(corner)
            groups.append((corner.ravel(), np.arange(0, corner.size + 1, size)))
            fan = [corner, np.roll(corner, -1, axis=1), np.repeat(mean[:, None], size, axis=1)]
            corner, ids = np.stack(fan, axis=-1).reshape(-1, 3), np.repeat(ids, size)
        blocks.append(CellBlock(base, corner, ids))
        if order_of(kind) and (top == 3 or flat):
            curved.append(CellBlock(kind, nodes, ids))
    found = tuple(blocks), tuple(groups), None, tuple(curved)
    return Blocks(top, flat, count, *found)


def _faced(mesh: Mesh) -> Blocks:
    faces = mesh.faces
    assert faces is not None
    known, rest = recognised(faces)
    blocks = [CellBlock(kind, nodes, ids) for kind, (nodes, ids) in known.items()]
    if not rest.any():
        return Blocks(3, False, faces.cells, tuple(blocks))
    fan, cell, groups = _fans(faces, rest, len(mesh.points))
    fans, corner = (
        CellBlock("polyhedron", fan, cell),
        CellBlock("polyhedron", *trihedra(faces, rest)),
    )
    return Blocks(3, False, faces.cells, (*blocks, fans), groups, corner)


def _fans(faces: Faces, chosen: np.ndarray, points: int) -> tuple[Indices, Indices, Groups]:
    """Tetrahedra (k, 4) of the chosen cells, their cells, and the groups that have means."""
    cell, face, sign = sides(faces)
    mine = chosen[cell]
    cell, face, sign = cell[mine], face[mine], sign[mine]
    size = np.diff(faces.offsets)[face]
    step = ramps(size)
    begin = np.repeat(faces.offsets[face], size)
    here = faces.nodes[begin + step]
    ahead = faces.nodes[begin + (step + 1) % np.repeat(size, size)]
    out = np.repeat(sign > 0, size)
    cell, face = np.repeat(cell, size), np.repeat(face, size)
    of_cells = _nodes_of(cell, here)
    place = np.searchsorted(np.flatnonzero(chosen), cell)
    fan = [
        np.where(out, ahead, here),
        np.where(out, here, ahead),
        points + face,
        points + len(faces) + place,
    ]
    return np.column_stack(fan), cell, ((faces.nodes, faces.offsets), of_cells)


def _nodes_of(cell: Indices, node: Indices) -> tuple[Indices, Indices]:
    """Distinct nodes of each cell, one cell after the other, and where each begins."""
    pairs = np.unique(np.column_stack([cell, node]), axis=0)
    first = np.flatnonzero(np.diff(pairs[:, 0], prepend=-1))
    return pairs[:, 1], np.append(first, len(pairs))


def _mean(values: Array, nodes: Indices, offsets: Indices) -> Array:
    total = np.add.reduceat(values[nodes], offsets[:-1], axis=0)
    return total / np.diff(offsets)[:, None]
