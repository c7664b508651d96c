"""Vectors by component: arrays (3, ...) whose first axis is x, y, z.

Each component is contiguous, so that NumPy runs at the speed of memory; long arrays are
taken in pieces that stay in the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ffdstudio.aliases import Array, Indices

PIECE = 4096


def dot(a: Array, b: Array) -> Array:
    """Scalar product."""
    result: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result


def cross(a: Array, b: Array) -> Array:
    """Vector product."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    np.subtract(a[1] * b[2], a[2] * b[1], out=out[0])
    np.subtract(a[2] * b[0], a[0] * b[2], out=out[1])
    np.subtract(a[0] * b[1], a[1] * b[0], out=out[2])
    return out


def triple(a: Array, b: Array, c: Array) -> Array:
    """Return the determinant of three vectors."""
    return dot(a, cross(b, c))


def length(a: Array) -> Array:
    """Euclidean length."""
    return np.sqrt(dot(a, a))


def gathered(points: Array, nodes: Indices) -> Array:
    """(3, nodes of a cell, cells) coordinates of cells given as (cells, nodes)."""
    return np.ascontiguousarray(points[nodes].transpose(2, 1, 0))


def pieces(count: int, size: int = PIECE) -> Iterator[slice]:
    """Slices that cover 0 to `count`."""
    return (slice(i, min(i + size, count)) for i in range(0, count, size))
