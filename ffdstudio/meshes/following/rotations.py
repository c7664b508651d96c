"""The rotation of a surface at each of its nodes, and its derivative.

1. It is the rotation nearest to what the edges at a node do (Kabsch 1976): the polar factor of
   C = sum of (edge after)(edge before)^T, each by its squared length before.
2. SurfaceEdges of a surface lie nearly in a plane, so that C has rank two: a rotation, unlike a
   reflection, is unique all the same. In a plane problem the axis out of the plane is added.
3. Where no edge moves the rotation is exactly the identity.
4. A node in a mirror has the mirrored edges on its other side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices

FLAT = 1e-8  # second singular value over the first below which edges lie on one line


@dataclass(frozen=True, eq=False)
class Rotations:
    """Rotations of a surface's nodes.

    Attributes
    ----------
    matrices : numpy.ndarray
        (k, 3, 3).
    """

    edges: SurfaceEdges
    matrices: Array
    _left: Array
    _right: Array
    _gaps: Array

    def pull(self, gradient: Array) -> Array:
        """(k, 3) derivative by the nodes' places, from that by the rotations (k, 3, 3)."""
        inner = self._left.transpose(0, 2, 1) @ gradient @ self._right
        skew = (inner - inner.transpose(0, 2, 1)) * self._gaps
        by_moments = self._left @ skew @ self._right.transpose(0, 2, 1)
        return self.edges.pull(by_moments)

    @property
    def largest(self) -> float:
        """Largest angle in radians."""
        trace = np.trace(self.matrices, axis1=1, axis2=2)
        return float(np.arccos(np.clip((trace.min(initial=3.0) - 1) / 2, -1, 1)))


class SurfaceEdges:
    """SurfaceEdges of a surface, ready to tell how its nodes turn.

    Parameters
    ----------
    points : numpy.ndarray
        (k, 3) nodes at rest.
    edges : numpy.ndarray
        (m, 2) indices into them, each edge once.
    axis : numpy.ndarray, optional
        (3,) unit vector about which alone nodes may turn: the normal of a plane problem.
    mirrors : sequence of (numpy.ndarray, numpy.ndarray)
        Indices of the nodes in each mirror, and its (3, 3) reflection.

    Examples
    --------
    >>> edges = SurfaceEdges(np.eye(3), np.array([[0, 1], [1, 2], [0, 2]]))
    >>> edges.rotations(np.eye(3)[[1, 2, 0]]).matrices[0].round(3) + 0.0
    array([[0., 0., 1.],
           [1., 0., 0.],
           [0., 1., 0.]])
    """

    def __init__(
        self,
        points: Array,
        edges: Indices,
        axis: Array | None = None,
        mirrors: Sequence[tuple[Indices, Array]] = (),
    ) -> None:
        self.count, self._points, self._mirrors = len(points), points, mirrors
        both = np.concatenate([edges, edges[:, ::-1]])
        vectors = points[both[:, 1]] - points[both[:, 0]]
        squares = (vectors**2).sum(axis=1)
        both, vectors, squares = both[squares > 0], vectors[squares > 0], squares[squares > 0]
        self._from, self._to = both.T
        self._scaled = vectors / squares[:, None]
        self._axis = np.zeros((3, 3)) if axis is None else np.outer(axis, axis)

    def rotations(self, places: Array) -> Rotations:
        """Rotations of the nodes at (k, 3) places."""
        step = places - self._points
        change = step[self._to] - step[self._from]
        at_rest = np.bincount(self._from[(change != 0).any(axis=1)], minlength=self.count) == 0
        after = places[self._to] - places[self._from]
        moments = self._summed(after[:, :, None] * self._scaled[:, None, :])
        for nodes, mirror in self._mirrors:
            moments[nodes] += mirror @ moments[nodes] @ mirror
        moments += self._axis
        left, sizes, right = np.linalg.svd(moments)
        sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
        left[:, :, 2] *= sign[:, None]
        sizes[:, 2] *= sign
        unclear = at_rest | (sizes[:, 1] <= FLAT * sizes[:, 0])
        matrices = left @ right
        matrices[unclear] = np.eye(3)
        total = sizes[:, :, None] + sizes[:, None, :]
        unclear = sizes[:, 1] <= FLAT * sizes[:, 0]  # at rest they may well begin to turn
        usable = (np.abs(total) > FLAT * sizes[:, :1, None]) & ~unclear[:, None, None]
        gaps = np.where(usable, 1 / np.where(usable, total, 1.0), 0.0)
        return Rotations(self, matrices, left, right.transpose(0, 2, 1), gaps)

    def pull(self, by_moments: Array) -> Array:
        """(k, 3) derivative by the nodes' places, from that by the moments (k, 3, 3)."""
        for nodes, mirror in reversed(self._mirrors):
            by_moments[nodes] += mirror @ by_moments[nodes] @ mirror
        by_edge = np.einsum("eij,ej->ei", by_moments[self._from], self._scaled)
        return np.asarray(self._at(self._to, by_edge) - self._at(self._from, by_edge))

    def _summed(self, values: Array) -> Array:
        """(k, 3, 3) sums over the edges of each node."""
        return self._at(self._from, values.reshape(-1, 9)).reshape(-1, 3, 3)

    def _at(self, where: Indices, values: Array) -> Array:
        columns = [np.bincount(where, column, self.count) for column in values.T]
        return np.column_stack(columns)
