"""Nearest points on a triangulated surface.

1. The triangles near a point are found from the centres: a triangle whose centre is farther
   than (best distance so far + its radius) cannot hold the nearest point. Candidates come in
   rounds of growing number from a search tree until that bound says that none is left.
2. The sign is that of the angle-free choice: the side of the triangle that holds the nearest
   point. Where a nearest point lies on an edge the distance is taken along the gap itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError


class Triangles:
    """A triangulated surface to project points on.

    Examples
    --------
    >>> square = Triangles([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> square.nearest(np.array([[0.5, 0.25, 2.0]]))[0]
    array([2.])
    """

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        from scipy.spatial import cKDTree

        xyz, cells = np.asarray(points, dtype=np.float64), np.asarray(triangles, dtype=np.int64)
        if cells.ndim != 2 or cells.shape[1] != 3 or not len(cells):
            raise InputError("the target surface has no triangles")
        corner = xyz[cells]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        area = np.linalg.norm(normal, axis=1)
        keep = area > 0
        self.corner, self.normal = corner[keep], normal[keep] / area[keep, None]
        centre = self.corner.mean(axis=1)
        self.radius = float(np.linalg.norm(self.corner - centre[:, None], axis=2).max())
        self.size = float(np.ptp(xyz, axis=0).max())
        self.tree = cKDTree(centre)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """(n,) signed distances and (n, 3) derivatives of them by the points."""
        foot, triangle = self.project(points)
        gap = points - foot
        length = np.linalg.norm(gap, axis=1)
        normal = self.normal[triangle]
        along = np.einsum("ij,ij->i", gap, normal)
        sign = np.where(along < 0, -1.0, 1.0)
        beside = length > (1 + 1e-6) * np.abs(along) + 1e-13 * self.size
        slanted = sign[:, None] * gap / np.where(beside, length, 1.0)[:, None]
        return np.where(beside, sign * length, along), np.where(beside[:, None], slanted, normal)

    def project(self, points: Array) -> tuple[Array, NDArray[np.intp]]:
        """(n, 3) nearest points of the surface and the triangles that hold them."""
        foot, triangle = np.empty((len(points), 3)), np.zeros(len(points), dtype=np.intp)
        todo, width = np.arange(len(points)), min(8, len(self.corner))
        while todo.size:
            reach, near = self.tree.query(points[todo], width)
            reach, near = (
                np.reshape(reach, (len(todo), width)),
                np.reshape(near, (len(todo), width)),
            )
            feet = closest(points[todo][:, None], self.corner[near])
            distance = np.linalg.norm(feet - points[todo][:, None], axis=2)
            best, row = distance.argmin(axis=1), np.arange(len(todo))
            foot[todo], triangle[todo] = feet[row, best], near[row, best]
            open_ = distance[row, best] + self.radius > reach[:, -1]
            if width == len(self.corner):
                break
            todo, width = todo[open_], min(4 * width, len(self.corner))
        return foot, triangle


def closest(p: Array, corner: Array) -> Array:
    """Nearest points to p (..., 3) of triangles (..., 3, 3).

    Barycentric regions as in Ericson, Real-Time Collision Detection, section 5.1.5.
    """
    a, b, c = corner[..., 0, :], corner[..., 1, :], corner[..., 2, :]
    ab, ac = b - a, c - a
    d1, d2 = _dot(ab, p - a), _dot(ac, p - a)
    d3, d4 = _dot(ab, p - b), _dot(ac, p - b)
    d5, d6 = _dot(ab, p - c), _dot(ac, p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    total = va + vb + vc
    v, w = vb / total, vc / total
    edge = d4 - d3, d5 - d6
    both = edge[0] + edge[1]
    for inside, first, second in (  # later regions win: edges, then corners
        (
            (va <= 0) & (edge[0] >= 0) & (edge[1] >= 0),
            1 - _ratio(edge[0], both),
            _ratio(edge[0], both),
        ),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), 0.0, _ratio(d2, d2 - d6)),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), _ratio(d1, d1 - d3), 0.0),
        ((d6 >= 0) & (d5 <= d6), 0.0, 1.0),
        ((d3 >= 0) & (d4 <= d3), 1.0, 0.0),
        ((d1 <= 0) & (d2 <= 0), 0.0, 0.0),
    ):
        v, w = np.where(inside, first, v), np.where(inside, second, w)
    return a + v[..., None] * ab + w[..., None] * ac


def _dot(a: Array, b: Array) -> Array:
    result: Array = np.einsum("...i,...i->...", a, b)
    return result


def _ratio(a: Array, b: Array) -> Array:
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0)
