"""Normals that make a faceted surface look as smooth as it is, and as sharp.

1. Faces that meet at less than the feature angle share a normal at their common corners; at a
   trailing edge or the rim of a tip they do not: such a point is drawn once for each side.
   Which corners belong together is found once, on the undeformed surface.
2. A normal is the sum of those of its faces, weighted by area (Gouraud 1971). It is made anew
   from where the points are, by one sparse product: nothing here can become stale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FEATURE = 30.0  # degrees between the normals of two faces


@dataclass(frozen=True, eq=False)
class Shading:
    """Points of a surface, each as often as it has normals.

    Attributes
    ----------
    rows : numpy.ndarray
        (s,) displayed point of each drawn one.
    connectivity : numpy.ndarray
        Polygons as in the surface, over drawn points.
    offsets : numpy.ndarray
        (p + 1,) beginnings of the polygons.
    """

    rows: Indices
    connectivity: Indices
    offsets: Indices
    _sums: csr_array

    def normals(self, points: Array) -> Array:
        """(s, 3) unit normals where the surface's points (m, 3) are now."""
        faces = face_vectors(points, self.rows[self.connectivity], self.offsets)
        summed = np.asarray(self._sums @ faces)
        length = np.linalg.norm(summed, axis=1, keepdims=True)
        return np.asarray(summed / np.where(length > 0, length, 1.0))


def shading_of(
    points: Array, connectivity: Indices, offsets: Indices, degrees: float = FEATURE
) -> Shading:
    """Find which corners of polygons share a normal.

    Parameters
    ----------
    points : numpy.ndarray
        (m, 3) undeformed.
    connectivity, offsets : numpy.ndarray
        Polygons: points of one after the other, and the (p + 1,) beginnings.
    degrees : float
        Feature angle: faces at more than that to each other are parted.

    Examples
    --------
    A roof of two faces at a right angle has two normals along its ridge:

    >>> roof = np.array([[0, -1, 0], [1, -1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 0], [1, 1, 0.0]])
    >>> quads = np.array([0, 1, 3, 2, 2, 3, 5, 4])
    >>> len(shading_of(roof, quads, np.array([0, 4, 8])).rows)
    8
    >>> len(shading_of(roof, quads, np.array([0, 4, 8]), degrees=100).rows)
    6
    """
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.csgraph import connected_components

    corners = len(connectivity)
    first, second = _smooth_pairs(points, connectivity, offsets, np.cos(np.radians(degrees)))
    graph = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(corners, corners))
    count, label = connected_components(graph, directed=False)
    rows = np.zeros(count, dtype=np.int64)
    rows[label] = connectivity
    face = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    shape = (count, len(offsets) - 1)
    sums = csr_array((np.ones(corners), (label, face)), shape=shape)
    return Shading(rows, np.asarray(label, dtype=np.int64), offsets, sums)


def face_vectors(points: Array, connectivity: Indices, offsets: Indices) -> Array:
    """(p, 3) normal of each polygon, as long as twice its area (Newell's method).

    Examples
    --------
    >>> square = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]])
    >>> face_vectors(square, np.arange(4), np.array([0, 4]))
    array([[0., 0., 8.]])
    """
    sizes = np.diff(offsets)
    out = np.zeros((len(sizes), 3))
    for size in np.unique(sizes):
        chosen = np.flatnonzero(sizes == size)
        ring = points[connectivity[offsets[chosen][:, None] + np.arange(size)]]
        edges = ring[:, 1:] - ring[:, :1]  # from one corner: large coordinates cancel
        for k in range(size - 2):
            out[chosen] += np.cross(edges[:, k], edges[:, k + 1])
    return out


def _smooth_pairs(
    points: Array, connectivity: Indices, offsets: Indices, cosine: float
) -> tuple[Indices, Indices]:
    """Corners of faces that meet at an edge without a feature: the same point, of both faces."""
    ahead = _next(offsets)
    a, b = connectivity, connectivity[ahead]
    low, high = np.minimum(a, b), np.maximum(a, b)
    order = np.lexsort((high, low))
    same = (low[order][1:] == low[order][:-1]) & (high[order][1:] == high[order][:-1])
    one, other = order[:-1][same], order[1:][same]
    face = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    smooth = _aligned(points, connectivity, offsets, face[one], face[other], cosine)
    smooth &= a[one] == b[other]  # faces of one orientation run along their edge in turn
    one, other = one[smooth], other[smooth]
    return np.concatenate([one, ahead[one]]), np.concatenate([ahead[other], other])


def _aligned(
    points: Array,
    connectivity: Indices,
    offsets: Indices,
    one: Indices,
    other: Indices,
    cosine: float,
) -> Mask:
    vectors = face_vectors(points, connectivity, offsets)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit = vectors / np.where(length > 0, length, 1.0)
    along = np.einsum("ij,ij->i", unit[one], unit[other])
    flat = (length[one, 0] == 0) | (length[other, 0] == 0)  # what has no area parts nothing
    return np.asarray((along >= cosine) | flat)


def _next(offsets: Indices) -> Indices:
    """Corner that follows each one around its polygon."""
    ahead = np.arange(1, offsets[-1] + 1)
    filled = np.flatnonzero(np.diff(offsets))
    ahead[offsets[1:][filled] - 1] = offsets[:-1][filled]
    return ahead
