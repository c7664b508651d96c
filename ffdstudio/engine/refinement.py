"""Refinement of a lattice: checks what is asked for and finds the matrix that does it.

Each function returns what `Lattice` needs to carry its control points over: which direction,
what becomes of it, and the matrix from old to new homogeneous control points.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine import transfer
from ffdstudio.engine.direction import Direction
from ffdstudio.engine.knots import DIRECTIONS, check_gaps, numbers, whole
from ffdstudio.errors import InputError

if TYPE_CHECKING:
    from ffdstudio.engine.lattice import Lattice


class Change(NamedTuple):
    """Control points of one direction become `matrix` times the old ones."""

    axis: int
    direction: Direction
    matrix: Array


def insertion(lattice: Lattice, axis: int, knots: ArrayLike) -> Change:
    """See `Lattice.insert_knots`."""
    axis = _checked_axis(lattice, axis)
    old = lattice.directions[axis]
    new = numbers(knots, "knots to insert").ravel()
    (low, high), bracket = old.domain, "[" if old.periodic else "("
    if not ((new >= low if old.periodic else new > low) & (new < high)).all():
        raise InputError(
            f"knots to insert in direction {DIRECTIONS[axis]} must lie inside "
            f"{bracket}{low:g}, {high:g}), got {new}"
        )
    for knot, count in zip(*np.unique(new, return_counts=True), strict=True):
        if old.most(knot) + count > old.degree:
            raise InputError(
                f"knot {knot:g} in direction {DIRECTIONS[axis]} "
                f"would occur more than {old.degree} times"
            )
    check_gaps(np.sort(np.concatenate([old.breaks, new])), DIRECTIONS[axis])
    return Change(axis, *old.inserted(new))


def checked_times(times: int) -> int:
    """How often to raise a degree, or `InputError`."""
    count = whole(times)
    if count is None or count < 0:
        raise InputError(f"a degree can be raised by 0, 1, 2, ... times, not {times}")
    return count


def elevation(lattice: Lattice, axis: int) -> Change:
    """See `Lattice.elevate_degree`; one degree at a time."""
    axis = _checked_axis(lattice, axis)
    return Change(axis, *lattice.directions[axis].elevated())


def removal(lattice: Lattice, axis: int, knots: ArrayLike, tolerance: float) -> Change:
    """See `Lattice.remove_knots`."""
    axis = _checked_axis(lattice, axis)
    old = lattice.directions[axis]
    gone = numbers(knots, "knots to remove").ravel()
    for knot, count in zip(*np.unique(gone, return_counts=True), strict=True):
        if (not old.periodic and knot in old.domain) or old.most(knot) < count:
            raise InputError(f"{knot:g} is no inner knot of direction {DIRECTIONS[axis]}")
    if old.periodic and old.count - len(gone) <= old.degree:
        raise InputError(
            f"direction {DIRECTIONS[axis]} is periodic and needs more than {old.degree} knots"
        )
    coarser, matrix, back = old.removed(gone)
    moved = _motion(lattice, axis, back @ matrix)
    if not moved <= tolerance + _rounding(lattice):
        raise InputError(
            f"removing knots {gone} from direction {DIRECTIONS[axis]} would move the "
            f"shape by up to {moved:.3g}, more than the tolerance {tolerance:.3g}"
        )
    return Change(axis, coarser, matrix)


def _rounding(lattice: Lattice) -> float:
    """Motion that rounding alone explains: of the sums, and of the coordinates as stored."""
    flat = _flat(lattice)
    stored = 32 * np.finfo(float).eps * float(np.abs(flat).max())
    return max(1e-13 * float(np.linalg.norm(np.ptp(flat, axis=0))), stored)


def _motion(lattice: Lattice, axis: int, matrix: Array) -> float:
    """Bound of the motion when homogeneous points are replaced by `matrix` times them.

    |N'/W' - N/W| <= (|N' - N| + |R| |W' - W|) / W', measured from the net's centre.
    """
    centred = lattice.homogeneous
    centre = _flat(lattice).mean(axis=0)
    centred[..., :3] -= centre * centred[..., 3:]
    new = transfer.along(matrix, centred, axis)
    least = new[..., 3].min()
    if least <= 0:
        return np.inf
    off = np.linalg.norm((new - centred)[..., :3], axis=-1).max()
    radius = np.linalg.norm(_flat(lattice) - centre, axis=1).max()
    return float((off + radius * np.abs(new - centred)[..., 3].max()) / least)


def _flat(lattice: Lattice) -> Array:
    return lattice.control_points.reshape(-1, 3)


def _checked_axis(lattice: Lattice, axis: int) -> int:
    if axis not in range(lattice.dimension):
        raise InputError(f"this lattice has directions 0 to {lattice.dimension - 1}, not {axis}")
    return int(axis)
