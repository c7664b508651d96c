"""The way of a surface from rest to where it goes, in steps that turn no more than allowed.

Each connected piece goes by its nearest rigid motion, turned evenly, with what it is deformed
besides growing evenly in its own frame: a rotation by half a turn has no shrunken middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices


@dataclass(frozen=True, eq=False)
class SurfacePath:
    """Pieces of a surface with their rigid motions.

    Attributes
    ----------
    rest, goal : numpy.ndarray
        (k, 3) places.
    piece : numpy.ndarray
        (k,) number of the piece of each.
    axes : numpy.ndarray
        (pieces, 3) rotation vectors.
    """

    rest: Array
    goal: Array
    piece: Indices
    axes: Array

    @classmethod
    def of(cls, rest: Array, goal: Array, piece: Indices) -> SurfacePath:
        """SurfacePath of pieces from rest (k, 3) to the goal.

        Examples
        --------
        >>> square = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
        >>> path = SurfacePath.of(square, square[[1, 2, 3, 0]], np.zeros(4, dtype=int))
        >>> path.axes.round(3) + 0.0
        array([[0.   , 0.   , 1.571]])
        """
        from scipy.spatial.transform import Rotation

        many = int(piece.max(initial=-1)) + 1
        a, b = rest - _means(rest, piece)[piece], goal - _means(goal, piece)[piece]
        moments = np.zeros((many, 3, 3))
        for i in range(3):
            for j in range(3):
                moments[:, i, j] = np.bincount(piece, b[:, i] * a[:, j], many)
        left, sizes, right = np.linalg.svd(moments)
        left[:, :, 2] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[:, None]
        turns = left @ right
        turns[sizes[:, 1] <= 1e-9 * sizes[:, 0]] = np.eye(3)
        return cls(rest, goal, piece, Rotation.from_matrix(turns).as_rotvec() if many else sizes)

    def at(self, t: float) -> Array:
        """(k, 3) places at t from 0 to 1; at 1 the goal, to the bit."""
        from scipy.spatial.transform import Rotation

        if t >= 1:
            return self.goal
        c, d = _means(self.rest, self.piece), _means(self.goal, self.piece)
        whole = Rotation.from_rotvec(self.axes).as_matrix()[self.piece]
        part = Rotation.from_rotvec(t * self.axes).as_matrix()[self.piece]
        a, b = self.rest - c[self.piece], self.goal - d[self.piece]
        own = np.einsum("kji,kj->ki", whole, b) - a  # how it is deformed, in its frame at rest
        centre = ((1 - t) * c + t * d)[self.piece]
        return np.asarray(np.einsum("kij,kj->ki", part, a + t * own) + centre)

    def steps(self, count: int) -> Iterator[Array]:
        """Places after each of a number of steps."""
        for k in range(1, count + 1):
            yield self.at(k / count)


def count_of(angle: float, most: float) -> int:
    """Number of steps for an angle with at most so much in each.

    Examples
    --------
    >>> count_of(0.0, 0.5), count_of(1.2, 0.5)
    (1, 3)
    """
    return max(math.ceil(angle / most), 1)


def _means(points: Array, piece: Indices) -> Array:
    many = np.maximum(np.bincount(piece), 1)
    return np.column_stack([np.bincount(piece, column) / many for column in points.T])
