"""Where along a motion the first cell inverts: rotations, scalings, weights, any path.

1. Between two places of the path nodes are taken to move straight, for which `safe_amplitude`
   is exact. A straight path is one piece; a curved one is followed in steps.
2. In the piece in which a cell inverts the end is moved to where that happens, until it stays:
   both ends of a piece lie on the path, so what is found does as well.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.safety.amplitude import safe_amplitude

ROUNDS = 12
SAME = 1e-9  # of the path: an end that moves by less has been found


def first_inversion(
    mesh: Mesh,
    at: Callable[[float], Array],
    asked: float,
    safe: float = 0.0,
    step: float = np.inf,
) -> float:
    """Smallest place on a path, from 0 towards `asked`, at which a cell inverts.

    Parameters
    ----------
    mesh : Mesh
        The undeformed mesh, which tells the sign of each cell.
    at : callable
        From a place on the path to the (n, 3) nodes there.
    asked : float
        How far to look; may be negative.
    safe : float
        From where on; up to there nothing inverts.
    step : float
        Length of path that may be taken as straight; for straight ones infinity.

    Returns
    -------
    float
        With the sign of `asked`; infinite with that sign if nothing inverts up to there.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> def turned(angle):  # its third corner about the first
    ...     points = mesh.points.copy()
    ...     points[2, :2] = 2 * np.sin(-angle), 2 * np.cos(angle)
    ...     return points
    >>> round(first_inversion(mesh, turned, -4.0, step=0.3), 6) == round(-np.pi / 2, 6)
    True
    """
    sign = 1.0 if asked >= 0 else -1.0
    place, here = safe, at(safe)
    while sign * (asked - place) > 0:
        end = place + sign * min(step, sign * (asked - place))
        there = at(end)
        share = safe_amplitude(mesh, there - here, here)
        if share < 1:
            found = _narrowed(mesh, at, (place, here), place + share * (end - place))
            if sign * (found - end) <= 0:
                return found
        place, here = end, there
    return sign * np.inf


def _narrowed(
    mesh: Mesh, at: Callable[[float], Array], start: tuple[float, Array], guess: float
) -> float:
    """Place at which the straight piece from the start ends in an inversion."""
    place, here = start
    for _ in range(ROUNDS):
        share = safe_amplitude(mesh, at(guess) - here, here)
        found = place + min(share, 2.0) * (guess - place)
        if abs(found - guess) <= SAME * abs(found - place) + 1e-300:
            return found
        guess = found
    return guess
