"""Points in a lattice that follows a frame: in closed form, or by Newton from there.

At rest the map is the frame, whose inverse is known. A lattice that was deformed before it was
taken as the one at rest adds a spline to the frame; a few steps of Newton account for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.inversion.found import Inversion
from ffdstudio.engine.inversion.net import Net
from ffdstudio.threads import for_each

if TYPE_CHECKING:
    from ffdstudio.engine.lattice import Lattice

STEPS = 40
CHUNK = 16384
ROUNDING = 8e-15


def invert_in_frame(lattice: Lattice, points: Array, tolerance: float, result: Inversion) -> None:
    """Fill the parameters of (n, 3) points; see `invert`."""
    slack = Net.of(lattice).slack
    goal = max(tolerance, ROUNDING) * lattice.diagonal

    def chunk(first: int) -> None:
        part = slice(first, first + CHUNK)
        _invert(lattice, points[part], goal, slack, result.part(part))

    for_each(chunk, range(0, len(points), CHUNK))


def _invert(lattice: Lattice, x: Array, goal: float, slack: float, result: Inversion) -> None:
    frame, domain = lattice.frame, lattice.domain
    assert frame is not None
    low, high = domain.T

    u = np.clip(frame.parameters(x, domain), low, high)
    best, away = u, _away(lattice, u, x)
    count = np.zeros(len(x), np.int16)
    reference = lattice.reference
    at_rest = reference is None or (
        np.array_equal(lattice.control_points, reference.control_points)
        and np.array_equal(lattice.weights, reference.weights)
    )
    for _ in range(0 if at_rest else STEPS):
        rows = np.flatnonzero(away > goal)
        if not len(rows):
            break
        step = _newton_step(lattice, best[rows], x[rows])
        trial = _held(lattice, best[rows] + step)
        off = _away(lattice, trial, x[rows])
        count[rows] += 1
        better = off < away[rows]
        best[rows[better]], away[rows[better]] = trial[better], off[better]
        if not better.any():
            break
    inside = away <= max(slack, goal)
    result.inside[:] = inside
    result.parameters[inside] = best[inside]
    result.residual[inside] = away[inside]
    result.iterations[:] = count


def _away(lattice: Lattice, u: Array, x: Array) -> Array:
    """Distance along the lattice's axes between its point at u and x."""
    return np.asarray(np.linalg.norm((lattice.evaluate(u) - x) @ lattice.axes.T, axis=1))


def _newton_step(lattice: Lattice, u: Array, x: Array) -> Array:
    d = lattice.dimension
    slopes = [lattice.evaluate(u, row) @ lattice.axes.T for row in np.eye(d, dtype=int).tolist()]
    miss = (x - lattice.evaluate(u)) @ lattice.axes.T
    inverse = np.linalg.pinv(np.stack(slopes, axis=-1), rcond=1e-12)
    return np.asarray((inverse @ miss[..., None])[..., 0])


def _held(lattice: Lattice, u: Array) -> Array:
    """Parameters in the domain; around a periodic direction they go on at the other end."""
    out = u.copy()
    for k, direction in enumerate(lattice.directions):
        low, high = direction.domain
        if direction.periodic:
            out[:, k] = low + np.mod(u[:, k] - low, high - low)
        out[:, k] = np.clip(out[:, k], low, high)
    return out
