"""Metrics of a surface, and the design variables that are orthonormal in them.

1. A metric is held by a factor C with K = C^T C: row sqrt(length of a point) for L2, and below
   it the slopes along the surface times sqrt(length of an edge) for H1 (adaptive steps of a
   flow cost are small and smooth in H1, whatever the number of variables).
2. Slopes are scaled by the extent of the surface, so that the metric has no units.
3. Whitening is one singular value decomposition of C S, S the surface basis; directions that
   the surface hardly feels (below 1e-6 of the largest) are dropped: the rank guard.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError

if TYPE_CHECKING:
    from ffdstudio.optimize.metrics.base import Metric

RANK_TOLERANCE = 1e-6


class Surface(NamedTuple):
    """Points of a surface with their share of it, and the slopes between them.

    Attributes
    ----------
    mass : numpy.ndarray
        (n,) lumped length or area over the total.
    slopes : scipy.sparse.csr_array
        (m, n) with ``|slopes @ f|^2`` the integral of the squared surface gradient of f,
        times the extent squared over the total length or area.
    response : numpy.ndarray or scipy.sparse array, optional
        (k, 3 n) derivative of what a flow does by the coordinates, see `Response`.
    strain : scipy.sparse.csr_array, optional
        (k, n) with ``|strain @ f|^2`` what the strain of bodies that follow costs; see
        `followers.strain`. Points of mass 0 are theirs.
    """

    mass: Array
    slopes: Any
    response: Any = None
    strain: Any = None

    @classmethod
    def curve(cls, points: ArrayLike) -> Surface:
        """Open polygon through (n, 3) points.

        Examples
        --------
        >>> Surface.curve([[0, 0, 0], [1, 0, 0], [2, 0, 0]]).mass
        array([0.25, 0.5 , 0.25])
        """
        xyz = np.asarray(points, dtype=np.float64)
        edges = np.column_stack([np.arange(len(xyz) - 1), np.arange(1, len(xyz))])
        return cls.edges(xyz, edges)

    @classmethod
    def edges(cls, points: Array, edges: NDArray[np.int64]) -> Surface:
        """Line elements, (k, 2) indices into the points."""
        from scipy.sparse import csr_array

        length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
        edges, length = edges[length > 0], length[length > 0]
        _check_extent(length)
        total, extent = length.sum(), np.ptp(points[np.unique(edges)], axis=0).max()
        mass = np.bincount(edges.ravel(), np.repeat(0.5 * length, 2), len(points)) / total
        rows = np.repeat(np.arange(len(edges)), 2)
        slope = extent / np.sqrt(length * total)
        values = np.column_stack([-slope, slope]).ravel()
        return cls(mass, csr_array((values, (rows, edges.ravel())), (len(edges), len(points))))

    @classmethod
    def triangles(cls, points: Array, triangles: NDArray[np.int64]) -> Surface:
        """Triangulated surface, (k, 3) indices into the points; linear elements."""
        from scipy.sparse import csr_array

        corner = points[triangles]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        twice = np.linalg.norm(normal, axis=1)
        keep = twice > 0
        triangles, corner, normal, twice = triangles[keep], corner[keep], normal[keep], twice[keep]
        _check_extent(twice)
        total, extent = 0.5 * twice.sum(), np.ptp(points[np.unique(triangles)], axis=0).max()
        mass = np.bincount(triangles.ravel(), np.repeat(twice / 6, 3), len(points)) / total
        # gradient of the hat function of a corner: unit normal x opposite edge / twice the area
        opposite = np.roll(corner, -2, axis=1) - np.roll(corner, -1, axis=1)
        hats = np.cross((normal / twice[:, None])[:, None], opposite) / twice[:, None, None]
        hats *= extent * np.sqrt(0.5 * twice / total)[:, None, None]
        rows = np.arange(3 * len(triangles)).reshape(-1, 1, 3)
        rows, columns = np.broadcast_arrays(rows, triangles[:, :, None])
        slopes = csr_array(
            (hats.ravel(), (rows.ravel(), columns.ravel())), (3 * len(triangles), len(points))
        )
        return cls(mass, slopes)

    @classmethod
    def cloud(cls, count: int) -> Surface:
        """Points without a connection: equal shares, no slopes (H1 is then L2)."""
        from scipy.sparse import csr_array

        return cls(np.full(count, 1 / count), csr_array((0, count)))


def _check_extent(sizes: Array) -> None:
    if not sizes.size:
        raise InputError("the surface has no extent: all its points coincide")


def with_strain(
    factor: Any, metric: Metric, surface: Surface, coordinates: NDArray[np.intp]
) -> Any:
    """Factor of a metric with the strain of bodies that follow below it.

    That is scaled to slopes of the surface; beside a flow's response it is scaled as they are.
    """
    from scipy.sparse import identity, kron, vstack

    if surface.strain is None:
        return factor
    scale = 1.0
    if metric.responds:
        from ffdstudio.optimize.metrics.flow import two_norm
        from ffdstudio.optimize.metrics.h1 import H1

        scale = two_norm(factor) / two_norm(H1().measure(surface, coordinates))
    strain = kron(scale * surface.strain, identity(len(coordinates)))
    return vstack([factor, strain]).tocsr()


class Whitening(NamedTuple):
    """Variables z with y = matrix z and unit metric; `inverse` is the way back.

    `frame` (m, r) has orthonormal columns: the whitened surface functions of the variables.
    """

    matrix: Array
    inverse: Array
    frame: Array

    @classmethod
    def of(cls, factored: Array, plain: bool = False) -> Whitening:
        """Whiten a factored surface basis C S, (m, N).

        With `plain` the variables stay what they are, and only the frame is orthonormal.

        Raises
        ------
        InputError
            If no variable moves a point of the surface.
        """
        _, sigma, vt = np.linalg.svd(_reduced(factored), full_matrices=False)
        if not sigma.size or sigma[0] == 0:
            raise InputError("the design variables move no point of the surface")
        kept = sigma > RANK_TOLERANCE * sigma[0]
        frame = factored @ (vt[kept].T / sigma[kept])
        if plain:
            eye = np.eye(factored.shape[1])
            return cls(eye, eye, frame)
        return cls(vt[kept].T / sigma[kept], sigma[kept, None] * vt[kept], frame)


def _reduced(matrix: Array) -> Array:
    """Triangular factor of a tall matrix, which has its singular values."""
    if matrix.shape[0] <= 2 * matrix.shape[1]:
        return matrix
    return np.asarray(np.linalg.qr(matrix, mode="r"))
