"""Knot vectors: the paper's formula, Greville abscissae, knot spans."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio import limits
from ffdstudio.aliases import Array
from ffdstudio.errors import InputError

DIRECTIONS = "ijk"  # names of the parametric directions


CLOSEST = 1e-12  # of the range: distinct knots nearer than this are a mistake of rounding


def numbers(values: ArrayLike, what: str) -> Array:
    """Return a new float64 array, or raise `InputError` if these are no numbers.

    Examples
    --------
    >>> numbers([1, 2], "the weights")
    array([1., 2.])
    """
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be an array of numbers") from None


def whole(value: object) -> int | None:
    """Return a number that is whole as an int, else None.

    Examples
    --------
    >>> whole(3.0), whole(3.5), whole(float("nan")), whole("3")
    (3, None, None, None)
    """
    try:
        number = int(value)  # type: ignore[call-overload]
    except (TypeError, ValueError, OverflowError):
        return None
    return number if number == value else None


def clamped_uniform(count: int, degree: int, lower: float = 0.0, upper: float = 1.0) -> Array:
    """Clamped knot vector with equally long knot spans over ``[lower, upper]``.

    The formula of the paper (section 2.1, a), scaled to the range of the coordinates so
    that a parameter is a coordinate.

    Parameters
    ----------
    count : int
        Number of control points, ``a + 1``.
    degree : int
        Degree ``p``, ``1 <= p <= a``.
    lower, upper : float
        Range of the parameter.

    Returns
    -------
    numpy.ndarray
        ``count + degree + 1`` knots.

    Raises
    ------
    InputError
        If the degree does not fit the number of control points.

    Examples
    --------
    >>> clamped_uniform(5, 3)
    array([0. , 0. , 0. , 0. , 0.5, 1. , 1. , 1. , 1. ])
    """
    limits.check_control_points((count,))
    check_degree(count, degree)
    breaks = np.linspace(lower, upper, count - degree + 1)
    return np.concatenate([np.full(degree, breaks[0]), breaks, np.full(degree, breaks[-1])])


def greville(knots: ArrayLike, degree: int) -> Array:
    """Greville abscissae: the means of `degree` neighbouring knots.

    Control points placed there make the map of a box the identity, x(u) = u.

    Examples
    --------
    >>> greville([0, 0, 0, 0.5, 1, 1, 1], 2)
    array([0.  , 0.25, 0.75, 1.  ])
    """
    knots = np.asarray(knots, dtype=np.float64)
    windows = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree)
    # measured from the first knot of each window, so that equal knots keep their bits
    first = windows[:, 0]
    result: Array = first + (windows - first[:, None]).sum(axis=1) / degree
    return result


def breaks(knots: Array) -> Array:
    """Distinct knots in ascending order: the ends of the knot spans."""
    return np.unique(knots)


def find_spans(knots: Array, degree: int, u: Array) -> NDArray[np.intp]:
    """Index ``s`` of the knot span of each parameter: ``knots[s] <= u < knots[s + 1]``.

    The last span is closed; a parameter outside the range gets the nearest span.
    """
    last = len(knots) - degree - 2
    # a knot of high multiplicity at the end leaves empty spans: step back over them
    while last > degree and knots[last] == knots[last + 1]:
        last -= 1
    return np.clip(np.searchsorted(knots, u, side="right") - 1, degree, last)


def check_degree(count: int, degree: int, direction: str = "") -> None:
    """Raise `InputError` unless ``1 <= degree <= count - 1``."""
    where = f" in direction {direction}" if direction else ""
    if (whole(degree) or 0) < 1:
        raise InputError(f"degree {degree}{where} must be a whole number of at least 1")
    if degree > count - 1:
        raise InputError(
            f"degree {degree}{where} needs at least {degree + 1} control points, got {count}"
        )
    limits.check_degree(degree, where)


def checked(knots: ArrayLike, degree: int, count: int, direction: str = "") -> Array:
    """Return a knot vector as float64, or raise `InputError` saying what is wrong with it."""
    where = f" in direction {direction}" if direction else ""
    values = numbers(knots, f"the knots{where}")
    check_degree(count, degree, direction)
    if values.shape != (count + degree + 1,):
        raise InputError(
            f"{count} control points of degree {degree}{where} need "
            f"{count + degree + 1} knots, got {values.size}"
        )
    if not np.isfinite(values).all():
        raise InputError(f"the knots{where} must be finite numbers")
    if (np.diff(values) < 0).any():
        raise InputError(f"the knots{where} must not decrease")
    if values[0] != values[degree] or values[-1] != values[-degree - 1]:
        raise InputError(f"the knots{where} must be clamped: {degree + 1} equal ones at each end")
    if (values[degree + 1 :] == values[: -degree - 1]).any():
        raise InputError(f"an inner knot{where} may occur at most {degree} times")
    check_gaps(values, direction)
    return values


def check_gaps(knots: Array, direction: str = "") -> None:
    """Raise `InputError` if ascending knots differ by so little that no knot span fits between."""
    gaps = np.diff(knots)
    near = np.flatnonzero((gaps > 0) & (gaps < CLOSEST * (knots[-1] - knots[0])))
    if near.size:
        where = f" in direction {direction}" if direction else ""
        a, b = (float(knot) for knot in knots[near[0] : near[0] + 2])
        raise InputError(f"the knots {a!r} and {b!r}{where} nearly coincide: make them equal")
