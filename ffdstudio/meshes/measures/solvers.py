"""What the solvers themselves would say of the cells, beside our own test for inversion.

1. OpenFOAM (checkMesh): the pyramids from the centre of a cell to its faces, and the volumes
   of cells, must not be negative.
2. SU2: the dual volumes, the share of its cells that belongs to a node (median dual: edge
   middles, face means, cell means), must be positive; signed here, so that folds show.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures.blocks import Blocks, CellBlock
from ffdstudio.meshes.measures.corners import orientation
from ffdstudio.meshes.measures.face_measures import Fabric
from ffdstudio.meshes.measures.vectors import cross, dot, gathered, pieces, triple
from ffdstudio.meshes.topology import FACES

SMALL = 1.0e-15  # OpenFOAM's SMALL in double precision


def wrong_pyramids(fabric: Fabric) -> int:
    """Faces with a pyramid of negative volume on either side (checkFacePyramids)."""
    faces = fabric.faces
    out = fabric.centres - fabric.middles[faces.owner]
    wrong = dot(fabric.areas.T, out.T) / 3 < -SMALL
    inner = np.flatnonzero(faces.neighbour >= 0)
    back = fabric.middles[faces.neighbour[inner]] - fabric.centres[inner]
    wrong[inner] |= dot(fabric.areas[inner].T, back.T) / 3 < -SMALL
    return int(wrong.sum())


def dual_volumes(blocks: Blocks, points: Array, rest: Array) -> Array:
    """(n,) signed volume, or area in a plane, that belongs to each node; NaN without cells."""
    here, start = blocks.extended(points), blocks.extended(rest)
    up = blocks.upright(start)
    out, seen = np.zeros(len(here)), np.zeros(len(here), dtype=bool)
    for block in blocks.blocks:
        sign = orientation(block, start, up)
        for piece in pieces(len(block.nodes), 65536):
            seen[block.nodes[piece]] = True
            for nodes, share in _shares(block[piece], here, up):
                out += np.bincount(nodes, share * sign, minlength=len(out))
    return np.where(seen, out, np.nan)[: len(points)]


def _shares(block: CellBlock, here: Array, up: Array | None) -> list[tuple[Indices, Array]]:
    """Pairs of node numbers and what they get, by simplices over the edges of the cells."""
    x, shares = gathered(here, block.nodes), []
    for (a, b), volume in _simplices(block, x, None if up is None else gathered(up, block.nodes)):
        shares += [(block.nodes[:, a], volume / 2), (block.nodes[:, b], volume / 2)]
    return shares


def _simplices(block: CellBlock, x: Array, up: Array | None) -> list[tuple[tuple[int, int], Array]]:
    """Edges of the cells and the signed volume between an edge, its face and the cell's mean."""
    if block.type == "polyhedron":
        fan = triple(*(x[:, i] - x[:, 0] for i in (1, 2, 3))) / 6
        return [((0, 1), fan)]
    if block.type in FACES:
        mean = x.mean(axis=1)
        turned = -1.0 if block.type == "wedge" else 1.0  # VTK's wedges look outward
        return [
            ((a, b), turned * triple(x[:, b] - face, x[:, a] - face, mean - face) / 6)
            for loop in FACES[block.type]
            for face in [x[:, loop].mean(axis=1)]
            for a, b in zip(loop, (*loop[1:], loop[0]), strict=True)
        ]
    return _plane(block, x, up)


def _plane(block: CellBlock, x: Array, up: Array | None) -> list[tuple[tuple[int, int], Array]]:
    if block.type == "polygon":
        mean, edges = x[:, 2], [(0, 1)]
    else:
        mean, count = x.mean(axis=1), x.shape[1]
        edges = [(i, (i + 1) % count) for i in range(count)]
    vectors = [(e, cross(x[:, e[0]] - mean, x[:, e[1]] - mean) / 2) for e in edges]
    if up is None:
        return [(edge, vector[2]) for edge, vector in vectors]
    normal = cross(up[:, 1] - up[:, 0], up[:, 2] - up[:, 0])
    size = np.sqrt(dot(normal, normal))
    return [(e, dot(v, normal) / np.where(size > 0, size, 1.0)) for e, v in vectors]
