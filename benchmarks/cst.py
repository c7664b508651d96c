"""Class-shape transformation (CST), the rival that adaptive lattices are compared with.

y(x) = sqrt(x) (1 - x) sum_i a_i B_i(x) + x times half the trailing-edge thickness, with
Bernstein polynomials B_i (B. M. Kulfan, Universal Parametric Geometry Representation Method,
Journal of Aircraft 45 (1), 2008). A re-fit is linear least squares of the vertical distances to
the target at the abscissae of the fit, each surface by itself.
"""

from __future__ import annotations

import numpy as np
from scipy.special import comb

from ffdstudio.optimize.geometry.contour import Contour, cosine_abscissae

Array = np.ndarray
FIT, DENSE = 301, 2001


def refit(target: Contour, variables: int) -> Array:
    """(2001, 3) contour of the CST with so many coefficients, half of them a surface."""
    x, upper = cosine_abscissae(FIT)
    dense, dense_upper = cosine_abscissae(DENSE)
    y = np.empty(DENSE)
    nose = float(target.spline(target.nose)[1])  # a table need not have it at y = 0
    for side, end in ((True, 0.0), (False, target.length)):
        mine, on, count = upper == side, dense_upper == side, variables // 2
        edge = float(target.spline(end)[1]) - nose
        wanted = target.at(x[mine], upper[mine])[:, 1] - nose - edge * x[mine]
        shape = np.linalg.lstsq(basis(x[mine], count), wanted, rcond=None)[0]
        y[on] = nose + basis(dense[on], count) @ shape + edge * dense[on]
    return np.column_stack([dense, y, np.zeros(DENSE)])


def basis(x: Array, count: int) -> Array:
    """(n, count) class function times Bernstein polynomials."""
    k, n = np.arange(count), count - 1
    powers = x[:, None] ** k * (1 - x[:, None]) ** (n - k)
    return (np.sqrt(x) * (1 - x))[:, None] * comb(n, k) * powers
