"""Rotation and scaling as functions from (n, 3) points to (n, 3) points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array

Transform = Callable[[Array], Array]


def rotation(axis: ArrayLike, degrees: float, pivot: ArrayLike) -> Transform:
    """Turn about an axis through a pivot, by the right-hand rule (Rodrigues' formula).

    Examples
    --------
    >>> rotation([0, 0, 1], 90, [1, 0, 0])(np.array([[2.0, 0, 0]])).round(12) + 0.0
    array([[1., 1., 0.]])
    """
    direction: Array = np.asarray(axis, dtype=np.float64)
    x, y, z = direction / float(np.linalg.norm(direction))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle, centre = np.radians(degrees), np.asarray(pivot, dtype=np.float64)
    # minus the identity: what does not turn keeps its bits
    change = np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return lambda points: points + (points - centre) @ change.T


def scaling(factors: ArrayLike, pivot: ArrayLike) -> Transform:
    """Stretch along the coordinate axes by (3,) factors, or one, about a pivot.

    Examples
    --------
    >>> scaling([2, 1, 1], [1, 0, 0])(np.array([[2.0, 3, 4]]))
    array([[3., 3., 4.]])
    """
    change = np.asarray(factors, dtype=np.float64) - 1
    centre = np.asarray(pivot, dtype=np.float64)
    return lambda points: points + (points - centre) * change
