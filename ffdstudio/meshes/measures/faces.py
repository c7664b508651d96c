"""The faces between cells, found from the cells or taken from a face-based mesh.

1. A face belongs to one or two cells; `pairing` finds which.
2. Files list some types in the mirrored order (wedges above all). Normals refer to the order
   that most cells of a type have, so that they point out of nearly all cells.
3. In a plane the faces are edges, seen from a cell whose nodes run counter-clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio import threads
from ffdstudio.aliases import Indices, Mask
from ffdstudio.meshes.measures.blocks import CellBlock, blocks_of
from ffdstudio.meshes.measures.corners import orientation
from ffdstudio.meshes.measures.recognise import ramps, sides
from ffdstudio.meshes.mesh import Faces, Mesh
from ffdstudio.meshes.pairing import MANY, Sides, Table, partners
from ffdstudio.meshes.topology import FACES

EDGES = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "polygon": ((0, 1),),  # of its fan of triangles
}


# nodes of cells, the corners of one of their faces, the cells' numbers, the first face's number
Seen = tuple[Indices, tuple[int, ...], Indices, int]


@dataclass(frozen=True, eq=False)
class Topology:
    """Faces, and the faces of each cell, one cell after the other."""

    faces: Faces
    cell_offsets: Indices
    cell_faces: Indices

    def around(self, cells: Indices) -> Indices:
        """Sorted numbers of these cells and of those that share a face with them."""
        faces = self.faces_of(cells)
        both = np.concatenate([cells, self.faces.owner[faces], self.faces.neighbour[faces]])
        return np.unique(both[both >= 0])

    def faces_of(self, cells: Indices) -> Indices:
        """Sorted numbers of the faces of these cells."""
        count = np.diff(self.cell_offsets)[cells]
        first = np.repeat(self.cell_offsets[cells], count)
        return np.unique(self.cell_faces[first + ramps(count)])

    def part(self, cells: Indices) -> Topology:
        """Topology of these cells (sorted) alone, numbered anew; the points stay as they are."""
        chosen, faces = self.faces_of(cells), self.faces
        size = np.diff(faces.offsets)[chosen]
        nodes = faces.nodes[np.repeat(faces.offsets[chosen], size) + ramps(size)]
        offsets = np.concatenate([[0], np.cumsum(size)])
        new = np.full(len(self.cell_offsets), -1)  # one more: number -1 stays -1
        new[cells] = np.arange(len(cells))
        owner, neighbour = new[faces.owner[chosen]], new[faces.neighbour[chosen]]
        # a face owned by a cell left out is turned round
        turned = owner < 0
        place = np.repeat(offsets[:-1], size) + ramps(size)
        back = np.repeat(offsets[1:] - 1, size) - ramps(size)
        nodes = np.where(np.repeat(turned, size), nodes[back], nodes[place])
        owner, neighbour = np.where(turned, neighbour, owner), np.where(turned, -1, neighbour)
        return of_faces(Faces(nodes, offsets, owner, neighbour), len(cells))


_known: WeakKeyDictionary[Mesh, Topology] = WeakKeyDictionary()


def topology_of(mesh: Mesh) -> Topology:
    """Faces of a mesh, found once; one of more than two cells counts as an outer face of each."""
    if mesh not in _known:
        faces = mesh.faces if mesh.faces is not None else _from_cells(mesh)
        _known[mesh] = of_faces(faces, blocks_of(mesh).count)
    return _known[mesh]


def of_faces(faces: Faces, cells: int) -> Topology:
    """Topology with the faces listed by cell."""
    cell, face, _ = sides(faces)
    count = np.bincount(cell, minlength=cells)
    return Topology(faces, np.concatenate([[0], np.cumsum(count)]), face)


def _from_cells(mesh: Mesh) -> Faces:
    blocks = [block for block in blocks_of(mesh).blocks if block.type in FACES | EDGES]
    sides: list[Sides] = []
    for block in blocks:
        table: Table = (FACES | EDGES)[block.type]
        if _mirrored(block, mesh):
            table = tuple(tuple(reversed(face)) for face in table)
        sides.append((block.nodes, table))
    partner = partners(sides)
    cells = np.concatenate(
        [np.tile(b.cells, len(t)) for b, (_, t) in zip(blocks, sides, strict=True)]
        or [np.empty(0, dtype=np.int64)]
    )
    start, by_size = 0, dict[int, list[Seen]]()
    for block, (nodes, table) in zip(blocks, sides, strict=True):
        for face in table:
            by_size.setdefault(len(face), []).append((nodes, face, block.cells, start))
            start += len(nodes)
    return _joined([_distinct(found, partner, cells) for found in by_size.values()])


def _joined(parts: list[tuple[Indices, Indices, Indices]]) -> Faces:
    """Faces of all sizes, one size after the other."""
    if not parts:
        none = np.empty(0, dtype=np.int64)
        return Faces(none, np.zeros(1, dtype=np.int64), none, none)
    sizes = np.concatenate([np.full(len(nodes), nodes.shape[1]) for nodes, _, _ in parts])
    return Faces(
        np.concatenate([nodes.ravel() for nodes, _, _ in parts]),
        np.concatenate([[0], np.cumsum(sizes)]),
        np.concatenate([owner for _, owner, _ in parts]),
        np.concatenate([neighbour for _, _, neighbour in parts]),
    )


def _distinct(
    found: list[Seen], partner: Indices, cells: Indices
) -> tuple[Indices, Indices, Indices]:
    """Distinct faces of one size with owner and neighbour."""
    from ffdstudio.meshes.pairing_kernels import emitted

    others = [partner[start : start + len(nodes)] for nodes, _, _, start in found]
    begins = np.cumsum([0, *map(_firsts, others, [start for *_, start in found])])
    out = np.empty((begins[-1], len(found[0][1])), dtype=np.int64)
    owner, neighbour = np.empty(begins[-1], dtype=np.int64), np.empty(begins[-1], dtype=np.int64)

    def emit(k: int) -> None:
        nodes, face, of_cell, start = found[k]
        part = slice(begins[k], begins[k + 1])
        given = nodes, np.array(face), of_cell, start, partner, cells
        emitted(*given, out[part], owner[part], neighbour[part])

    threads.for_each(emit, range(len(found)))
    if any((other == MANY).any() for other in others):
        kept = _whole(out)  # faces of collapsed cells without area, which many cells may share
        return out[kept], owner[kept], neighbour[kept]
    return out, owner, neighbour


def _firsts(other: Indices, start: int) -> int:
    """Number of faces that are alone or the first of a pair."""
    return int(((other < 0) | (other > np.arange(start, start + len(other)))).sum())


def _whole(nodes: Indices) -> Mask:
    """Faces with three nodes that differ, edges with two."""
    ordered = np.sort(nodes, axis=1)
    distinct = 1 + (ordered[:, 1:] != ordered[:, :-1]).sum(axis=1)
    whole: Mask = distinct >= min(3, nodes.shape[1])
    return whole


def _mirrored(block: CellBlock, mesh: Mesh) -> bool:
    """Whether most cells are against the order of `FACES` (VTK's wedges look outward)."""
    blocks = blocks_of(mesh)
    points = blocks.extended(mesh.points)
    against = orientation(block, points, blocks.upright(points)) < 0
    return against != (block.type == "wedge")
