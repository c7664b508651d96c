"""Boxes: orthonormal frames, bounds, and the control net that fills a box."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine import knots as kv
from ffdstudio.errors import InputError
from ffdstudio.limits import check_control_points


class Frame(NamedTuple):
    """Orthonormal axes, (d, 3); coordinates in it are ``points @ axes.T``."""

    axes: Array

    @classmethod
    def of(cls, axes: ArrayLike | None, dimension: int) -> Frame:
        """Frame of `dimension` directions; raises `InputError` if it is not orthonormal."""
        if not 1 <= dimension <= 3:
            raise InputError(f"a lattice has 1, 2 or 3 directions, not {dimension}")
        if axes is None:
            return cls(np.eye(3)[:dimension].copy())
        vectors = kv.numbers(axes, "the axes of a lattice")
        if vectors.shape != (dimension, 3):
            raise InputError(
                f"a lattice of {dimension} directions needs axes of shape ({dimension}, 3), "
                f"got {vectors.shape}"
            )
        if not np.allclose(vectors @ vectors.T, np.eye(dimension), rtol=0, atol=1e-9):
            raise InputError("the axes of a lattice must be unit vectors at right angles")
        return cls(vectors)

    def bounds(self, points: ArrayLike, margin: ArrayLike) -> tuple[Array, Array]:
        """Lower and upper corner, (3,) each, of the points with a margin around them.

        The margin is a fraction of the extent, one for all directions or one for each.
        """
        array = kv.numbers(points, "points")
        if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
            raise InputError(f"points must be an array (n, 3) with n >= 1, got {array.shape}")
        if not np.isfinite(array).all():
            raise InputError("the points to put a lattice around must be finite numbers")
        room = kv.numbers(margin, "the margin")
        if not (np.isfinite(room).all() and (room >= 0).all()):
            raise InputError(f"the margin must be a finite fraction of at least 0, got {margin!r}")
        if room.shape not in ((), (len(self.axes),)):
            raise InputError(f"{len(self.axes)} directions need 1 or {len(self.axes)} margins")
        flat = array @ self.axes.T
        lower, upper = flat.min(axis=0), flat.max(axis=0)
        extent = upper - lower
        extent[extent <= 1e-12 * extent.max()] = extent.max()
        corners = np.zeros((2, 3))
        corners[:, : len(self.axes)] = lower - room * extent, upper + room * extent
        return corners[0], corners[1]


def complete_axes(axes: ArrayLike | None, shape: tuple[int, ...]) -> Array:
    """Checked axes of a lattice of that shape, the coordinate axes by default."""
    return Frame.of(axes, len(shape)).axes


def box_net(
    lower: ArrayLike,
    upper: ArrayLike,
    shape: Sequence[int],
    degrees: Sequence[int] | None,
    axes: ArrayLike | None,
    spacing: str,
) -> tuple[list[Array], Array, Array, list[int]]:
    """Knots, control points, axes and degrees of a box lattice."""
    counts = [_count(n) for n in _listed(shape, "shape")]
    check_control_points(counts)
    frame = Frame.of(axes, len(counts))
    given = degrees if degrees is None else _listed(degrees, "degrees")
    degrees = [min(3, n - 1) for n in counts] if given is None else given
    if len(degrees) != len(counts):
        raise InputError(f"{len(counts)} directions need as many degrees, got {len(degrees)}")
    lo, hi = _corners(lower, upper, len(counts))
    knots = [kv.clamped_uniform(*item) for item in zip(counts, degrees, lo, hi, strict=True)]
    lines = [_line(spacing, u, p, n) for u, p, n in zip(knots, degrees, counts, strict=True)]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    return knots, in_world(grid, frame.axes), frame.axes, [int(p) for p in degrees]


def in_world(coordinates: Array, axes: Array) -> Array:
    """World points of (..., d) coordinates along `axes`."""
    if np.array_equal(axes, np.eye(3)[: len(axes)]):  # keep the bits of an unrotated box
        out = np.zeros((*coordinates.shape[:-1], 3))
        out[..., : len(axes)] = coordinates
        return out
    return coordinates @ axes


def _listed(values: Sequence[int], what: str) -> list[int]:
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise InputError(f"{what} must have a number for each direction, got {values!r}")
    return list(values)


def _count(number: int) -> int:
    count = kv.whole(number)
    if count is None or count < 2:
        raise InputError(f"a direction needs at least 2 control points, got {number}")
    return count


def _corners(lower: ArrayLike, upper: ArrayLike, dimension: int) -> tuple[Array, Array]:
    lo = kv.numbers(lower, "the corners of the box").ravel()[:dimension]
    hi = kv.numbers(upper, "the corners of the box").ravel()[:dimension]
    if lo.size < dimension or hi.size < dimension:
        raise InputError(f"the corners of the box need {dimension} coordinates each")
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        raise InputError("the corners of the box must be finite numbers")
    for k in range(dimension):
        # below this the knots would no longer be distinct numbers
        if not hi[k] - lo[k] > 1e-12 * max(abs(lo[k]), abs(hi[k])):
            raise InputError(
                f"the box has no extent in direction {'ijk'[k]}: {lo[k]:g} to {hi[k]:g}"
            )
    return lo, hi


def _line(spacing: str, knots: Array, degree: int, count: int) -> Array:
    if spacing == "greville":
        return kv.greville(knots, degree)
    if spacing == "uniform":
        return np.linspace(knots[0], knots[-1], count)
    raise InputError(f'spacing must be "greville" or "uniform", got {spacing!r}')
