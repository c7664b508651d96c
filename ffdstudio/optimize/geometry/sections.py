"""Airfoil sections as sources and targets of fits, and how a fit is judged.

1. A fit moves 301 cosine-spaced points, or four a variable if that is more; it is judged on
   2001 others, never on its own.
2. A closed trailing edge cannot be opened by a lattice, for both of its points share one
   parameter: the source is given the target's gap first. Where the base is slanted, one surface
   of the target ends before x = 1; the source ends there as well, for it only moves in y.
3. Kulfan's tolerance: 4e-4 of the chord for x < 0.2, 8e-4 aft of it (B. M. Kulfan, Universal
   Parametric Geometry Representation Method, Journal of Aircraft 45 (1), 2008).
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np

from ffdstudio.aliases import Array, Mask
from ffdstudio.errors import InputError
from ffdstudio.meshes.airfoil import naca4, read_airfoil
from ffdstudio.optimize.geometry.contour import Contour, cosine_abscissae, upper_side

FIT_POINTS, DENSE_POINTS = 301, 2001
POINTS_PER_VARIABLE = 4  # fewer, and a fit oscillates between its points
BASE, TURN = 0.05, 0.5  # half a base at most, of the chord; cosine of the turn at its corner
LEAST_POINTS = 5
NACA = re.compile(r"(?:naca[ -]?)?\d{4}", re.IGNORECASE)


@dataclass(frozen=True)
class Section:
    """A section to be deformed.

    Attributes
    ----------
    points, dense : numpy.ndarray
        (301, 3) and (2001, 3) cosine-spaced contours.
    upper, dense_upper : numpy.ndarray
        Which of them belong to the upper surface.
    """

    points: Array
    dense: Array
    upper: Mask
    dense_upper: Mask

    @classmethod
    def of(
        cls,
        source: str | os.PathLike[str] | Array,
        gap: float = 0.0,
        count: int = FIT_POINTS,
        ends: tuple[float, float] = (1.0, 1.0),
    ) -> Self:
        """Section from a file, the name of a NACA four-digit section, or a contour.

        Parameters
        ----------
        gap : float
            Thickness to add at the trailing edge, growing with x.
        ends : tuple of float
            Factors of x on the upper and the lower surface.
        """
        points, dense = sampled(source, count), sampled(source, DENSE_POINTS)
        sides = upper_side(points), upper_side(dense)
        return cls(opened(points, gap, ends), opened(dense, gap, ends), *sides)


def points_for(variables: int) -> int:
    """Odd number of points of a fit with so many variables.

    Raises
    ------
    InputError
        If they are more than the dense contour can judge.

    Examples
    --------
    >>> points_for(70), points_for(100)
    (301, 401)
    """
    count = max(FIT_POINTS, POINTS_PER_VARIABLE * variables // 2 * 2 + 1)
    if count > DENSE_POINTS:
        most = DENSE_POINTS // POINTS_PER_VARIABLE
        raise InputError(f"a section is fitted with at most {most} variables, not {variables}")
    return count


def opened(points: Array, gap: float, ends: tuple[float, float] = (1.0, 1.0)) -> Array:
    """(n, 3) contour of chord 1 with a thickness added at the trailing edge, growing with x.

    `ends` are factors of x on the upper and the lower surface, for a slanted base.

    Examples
    --------
    >>> opened(np.array([[1.0, 0, 0], [0.5, 0.1, 0], [0, 0, 0], [1, 0, 0]]), 0.01)[:, 1]
    array([ 0.005 ,  0.1025,  0.    , -0.005 ])
    """
    upper, new = upper_side(points), points.copy()
    new[:, 1] += gap * np.where(upper, 0.5, -0.5) * points[:, 0]
    new[:, 0] *= np.where(upper, *ends)
    return new


def sampled(source: str | os.PathLike[str] | Array, count: int) -> Array:
    """(count, 3) cosine-spaced contour of a source, chord 1."""
    if is_naca(source):
        exact = naca4(str(source), points=count // 2 + 1)
        if exact[:, 0].min() >= 0 and np.allclose(exact[:, 0], cosine_abscissae(count)[0]):
            return np.column_stack([exact, np.zeros(count)])
    return target_contour(source).sample(count)


def target_contour(source: str | os.PathLike[str] | Array) -> Contour:
    """Normalised C2 contour of a file, a NACA section or an array of points."""
    if is_naca(source):
        return Contour(naca4(str(source), points=201))
    return Contour(without_base(source if isinstance(source, np.ndarray) else read_airfoil(source)))


def without_base(points: Array) -> Array:
    """Contour without points between the corners of a blunt trailing edge.

    Some files begin and end in the middle of the base. A spline through its corners would
    overshoot, and the corners are where the two surfaces end.

    Examples
    --------
    >>> nose = [[1, 0.02], [0.5, 0.2], [0, 0], [0.5, -0.2], [1, -0.02]]
    >>> len(without_base(np.array([[1, 0], *nose, [1, 0]])))
    5
    """
    first, last = _corner(points), len(points) - _corner(points[::-1])
    return points[first:last] if last - first >= LEAST_POINTS else points


def _corner(points: Array) -> int:
    """Number of points on the base: those before a sharp turn that comes soon."""
    steps = np.diff(points[:, :2], axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    here = np.flatnonzero(sizes > 0)
    travelled = np.cumsum(sizes)
    for before, after in pairwise(here):
        if travelled[before] > BASE * np.ptp(points[:, 0]):
            break
        if steps[before] @ steps[after] < TURN * sizes[before] * sizes[after]:
            return int(after)
    return 0


def is_naca(source: object) -> bool:
    """Whether a source is the name of a NACA four-digit section."""
    return isinstance(source, str) and NACA.fullmatch(source.strip()) is not None


def trailing_gap(contour: Contour) -> float:
    """Vertical thickness at the trailing edge."""
    ends = contour.spline([0.0, contour.length])
    return float(ends[0, 1] - ends[1, 1])


def trailing_ends(contour: Contour) -> Array:
    """(2,) abscissae of the ends of the upper and the lower surface, chord 1."""
    return np.asarray(contour.spline([0.0, contour.length])[:, 0])


def kulfan_tolerance(x: Array) -> Array:
    """Tolerance by abscissa, chord 1.

    Examples
    --------
    >>> kulfan_tolerance(np.array([0.1, 0.5]))
    array([0.0004, 0.0008])
    """
    return np.where(x < 0.2, 4e-4, 8e-4)
