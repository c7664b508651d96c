"""The faces between cells, found from the cells or taken from a face-based mesh.

1. A face belongs to one or two cells. Candidates are paired by a 64-bit sum of random numbers
   of their nodes, which does not depend on the node order; that the nodes agree is checked.
2. Files list some types in the mirrored order (wedges above all). Normals refer to the order
   that most cells of a type have, so that they point out of nearly all cells.
3. In a plane the faces are edges, seen from a cell whose nodes run counter-clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.blocks import Block, blocks_of
from ffdstudio.meshes.measures.corners import orientation
from ffdstudio.meshes.measures.recognise import ramps, sides
from ffdstudio.meshes.mesh import Faces, Mesh
from ffdstudio.meshes.topology import FACES

EDGES = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "polygon": ((0, 1),),  # of its fan of triangles
}


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
    """Faces of a mesh, found once.

    Raises
    ------
    InputError
        If a face belongs to more than two cells.
    """
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
    by_size: dict[int, list[tuple[Indices, Indices]]] = {}
    for block in blocks_of(mesh).blocks:
        mirrored = _mirrored(block, mesh)
        for face in (FACES | EDGES).get(block.type, ()):
            outward = tuple(reversed(face)) if mirrored else face
            by_size.setdefault(len(face), []).append((block.nodes[:, outward], block.cells))
    parts = [
        _paired(np.concatenate([n for n, _ in found]), np.concatenate([c for _, c in found]))
        for found in by_size.values()
    ]
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


def _mirrored(block: Block, mesh: Mesh) -> bool:
    """Whether most cells are against the order of `FACES` (VTK's wedges look outward)."""
    blocks = blocks_of(mesh)
    points = blocks.extended(mesh.points)
    against = orientation(block, points, blocks.upright(points)) < 0
    return against != (block.type == "wedge")


def _paired(nodes: Indices, cells: Indices, seed: int = 0) -> tuple[Indices, Indices, Indices]:
    """Distinct faces with owner and neighbour from faces seen from each cell."""
    random = np.random.default_rng(seed)
    numbers = random.integers(2**64, size=nodes.max(initial=0) + 1, dtype=np.uint64)
    key = numbers[nodes[:, 0]]
    for column in nodes.T[1:]:
        key = key + numbers[column]
    order = np.argsort(key)
    same = key[order[1:]] == key[order[:-1]]
    if (same[1:] & same[:-1]).any():
        return _manifold(nodes, cells, order[1:-1][same[1:] & same[:-1]])
    pair = np.sort(np.stack([order[:-1][same], order[1:][same]]), axis=0)
    first, second = pair
    if not np.array_equal(np.sort(nodes[first], axis=1), np.sort(nodes[second], axis=1)):
        return _paired(nodes, cells, seed + 1)
    neighbour = np.full(len(nodes), -1)
    neighbour[first] = cells[second]
    single = np.ones(len(nodes), dtype=bool)
    single[second] = False
    return nodes[single], cells[single], neighbour[single]


def _manifold(nodes: Indices, cells: Indices, shared: Indices) -> tuple[Indices, Indices, Indices]:
    """Pair again without the faces of collapsed cells that have no area."""
    ordered = np.sort(nodes, axis=1)
    distinct = 1 + (ordered[:, 1:] != ordered[:, :-1]).sum(axis=1)
    whole = distinct >= min(3, nodes.shape[1])
    if whole[shared].any():
        bad = nodes[shared[whole[shared]][0]].tolist()
        raise InputError(f"the face of nodes {bad} (counted from 0) belongs to over two cells")
    return _paired(nodes[whole], cells[whole])
