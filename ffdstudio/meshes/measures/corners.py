"""Corner Jacobians: the signed volume spanned by the edges at a corner of a cell.

1. The sign refers to the undeformed mesh: what starts negative may stay so (real meshes have
   wedges in the other order), what changes sign is inverted.
2. A corner that has no volume to start with (collapsed edges, a hanging node) has no sign and
   is not judged. "None" is measured against rounding of the coordinates, not against 0.
3. On a surface in space a corner has a normal instead; its sign is that of the scalar product
   with the undeformed normal.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.vectors import cross, dot, gathered, length, pieces, triple

ROUNDING = 16 * np.finfo(np.float64).eps


def edges(coordinates: Array, corner: tuple[int, ...]) -> list[Array]:
    """Edge vectors (3, k) at a corner."""
    return [coordinates[:, i] - coordinates[:, corner[0]] for i in corner[1:]]


def jacobians(block: CellBlock, points: Array, rest: Array | None = None) -> Array:
    """(corners, k) corner Jacobians of cells at extended points.

    For plane cells `rest` are the points whose normals count as up; without it up is z.
    """
    out = np.empty((len(block.corners), len(block.nodes)))
    for piece in pieces(len(block.nodes)):
        here = gathered(points, block.nodes[piece])
        ref = None if rest is None else gathered(rest, block.nodes[piece])
        for row, corner in zip(out, block.corners, strict=True):
            row[piece] = _jacobian(edges(here, corner), None if ref is None else edges(ref, corner))
    return out


def _jacobian(vectors: list[Array], rest: list[Array] | None) -> Array:
    if len(vectors) == 3:
        return triple(*vectors)
    normal = cross(*vectors)
    return normal[2] if rest is None else dot(normal, unit(cross(*rest)))


def signs(block: CellBlock, points: Array, up: Array | None) -> Array:
    """(corners, k) signs of the undeformed corner Jacobians: 1, -1, or 0 for no volume."""
    out = np.empty((len(block.corners), len(block.nodes)))
    for piece in pieces(len(block.nodes)):
        here = gathered(points, block.nodes[piece])
        ref = None if up is None else gathered(up, block.nodes[piece])
        size = ROUNDING * np.abs(here).max(axis=(0, 1))
        for row, corner in zip(out, block.corners, strict=True):
            vectors = edges(here, corner)
            value = _jacobian(vectors, None if ref is None else edges(ref, corner))
            noise = size * _surface([length(e) for e in vectors])
            row[piece] = np.where(np.abs(value) > noise, np.sign(value), 0.0)
    return out


def _surface(sizes: list[Array]) -> Array:
    """How much the Jacobian changes for a unit error of a coordinate."""
    if len(sizes) == 2:
        return sizes[0] + sizes[1]
    a, b, c = sizes
    return a * b + b * c + c * a


def unit(vectors: Array) -> Array:
    """Vectors of length 1; those without length stay."""
    size = length(vectors)
    return vectors / np.where(size > 0, size, 1.0)


def orientation(block: CellBlock, points: Array, up: Array | None) -> int:
    """1, or -1 where most cells of a type are listed in the mirrored order."""
    positive = jacobians(block, points, up).sum(axis=0) > 0
    return 1 if 2 * positive.sum() >= len(positive) else -1
