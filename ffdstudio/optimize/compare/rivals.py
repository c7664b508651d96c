"""Static parameterizations of a section: lattices with columns by a rule, CST, and modes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.optimize.build.lattice import MARGIN, section_box
from ffdstudio.optimize.geometry.contour import upper_side

Spacing = Callable[[Array], Array]


def _cosine(t: Array) -> Array:
    return np.asarray(0.5 * (1 - np.cos(np.pi * t)))


# where the inner knots lie between the ends, from even ones
SPACINGS: dict[str, Spacing] = {
    "cosine": _cosine,
    "mean": lambda t: 0.5 * (t + _cosine(t)),
    "squares": lambda t: t**2,
}
LATTICES = ("greville", "uniform", *SPACINGS)
RIVALS = (*LATTICES, "cst", "modes")
TITLES = {
    "greville": "Greville columns, even knots",
    "uniform": "equally spaced columns",
    "cosine": "cosine-spaced knots",
    "mean": "mean of even and cosine knots",
    "squares": "knots as x^2",
    "cst": "CST",
    "modes": "modes of a library (SVD)",
}


def lattice(points: Array, columns: int, spacing: str, rows: int = 2) -> Lattice:
    """Static lattice around a section.

    Examples
    --------
    >>> from ffdstudio.optimize.geometry.sections import sampled
    >>> lattice(sampled("naca0012", 41), 9, "squares").shape
    (9, 2)
    """
    if spacing not in SPACINGS:
        return section_box(points, (columns, rows), spacing)
    count = columns - 3
    low, high = points[:, 0].min() - MARGIN, points[:, 0].max() + MARGIN
    knots = low + (high - low) * SPACINGS[spacing](np.arange(1, count) / count)
    return section_box(points, (4, rows)).insert_knots(0, knots)


def cst_fields(points: Array, variables: int) -> Array:
    """(n, variables + 1) vertical displacements: class function times Bernstein polynomials.

    ``sqrt(x) (1 - x) B_i(x)`` for each surface (B. M. Kulfan, Universal Parametric Geometry
    Representation Method, Journal of Aircraft 45 (1), 2008); the upper one has one more where
    the number is odd. The trailing edge moves up and down as well: one variable more than
    counted, since lattices move it too and a re-fit by CST is told where it is.
    """
    from scipy.special import comb

    low, extent = points[:, 0].min(), np.ptp(points[:, 0])
    x, upper = np.clip((points[:, 0] - low) / extent, 0, 1), upper_side(points)
    parts = [x[:, None]]
    for side, count in ((upper, variables - variables // 2), (~upper, variables // 2)):
        k = np.arange(count)
        bernstein = comb(count - 1, k) * x[:, None] ** k * (1 - x[:, None]) ** (count - 1 - k)
        parts.append((side * np.sqrt(x) * (1 - x))[:, None] * bernstein)
    return np.hstack(parts)


class Modes:
    """Principal vertical displacements of a library of sections.

    Parameters
    ----------
    ordinates : numpy.ndarray
        (sections, m) ordinates of contours of m cosine-spaced points, trailing edges closed.
    """

    def __init__(self, ordinates: Array) -> None:
        mean = ordinates.mean(axis=0)
        self.vectors = np.linalg.svd(ordinates - mean, full_matrices=False)[2]

    def fields(self, points: Array, variables: int) -> Array:
        """(n, variables) vertical displacements at the points of a section.

        Between the points of the library they are cubic in the angle of the cosine spacing.
        """
        from scipy.interpolate import CubicSpline

        count = self.vectors.shape[1]
        way = np.linspace(0, 2 * np.pi, count)
        low, extent = points[:, 0].min(), np.ptp(points[:, 0])
        turn = np.arccos(np.clip(2 * (points[:, 0] - low) / extent - 1, -1, 1))
        where = np.where(upper_side(points), turn, 2 * np.pi - turn)
        return np.asarray(CubicSpline(way, self.vectors[:variables].T)(where))
