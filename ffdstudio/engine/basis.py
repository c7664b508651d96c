"""B-spline basis functions of one direction; a tensor product is built from these."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.knots import find_spans


def basis(
    knots: Array, degree: int, u: Array, derivative: int = 0
) -> tuple[NDArray[np.intp], Array]:
    """Values or derivatives of the ``degree + 1`` basis functions that live at each parameter.

    Parameters
    ----------
    knots : numpy.ndarray
        Clamped knot vector.
    degree : int
        Degree ``p`` of the functions.
    u : numpy.ndarray
        (n,) parameters inside the range of the knots.
    derivative : int
        Order of the derivative; 0 gives the values.

    Returns
    -------
    first : numpy.ndarray
        (n,) index of the first basis function of each row.
    values : numpy.ndarray
        (n, p + 1) values; rows of the 0th derivative sum to 1.

    Notes
    -----
    Cox-de Boor recursion by rising degree (The NURBS Book, algorithm A2.2) and the
    derivative formula (2.9) of the same book, over all parameters at once.

    Examples
    --------
    >>> import numpy as np
    >>> basis(np.array([0.0, 0, 0, 1, 1, 1]), 2, np.array([0.5]))[1]
    array([[0.25, 0.5 , 0.25]])
    """
    u = np.asarray(u, dtype=np.float64)
    span = find_spans(knots, degree, u)
    low = max(degree - derivative, 0)
    values = np.ones((len(u), 1))
    for p in range(1, low + 1):
        values = _raise_degree(knots, p, span, u, values)
    for p in range(low + 1, degree + 1):
        values = _differentiate(knots, p, span, values)
    if derivative > degree:
        values = np.zeros_like(values)
    return span - degree, values


def _raise_degree(knots: Array, p: int, span: NDArray[np.intp], u: Array, lower: Array) -> Array:
    """Functions of degree p from those of degree p - 1 (columns: span - p ... span)."""
    values = np.zeros((len(u), p + 1))
    for r in range(p):
        left, right = knots[span - p + 1 + r], knots[span + 1 + r]
        share = lower[:, r] / (right - left)
        values[:, r] += (right - u) * share
        values[:, r + 1] = (u - left) * share
    return values


def _differentiate(knots: Array, p: int, span: NDArray[np.intp], lower: Array) -> Array:
    """Derivatives at degree p from (derivatives of) functions of degree p - 1."""
    values = np.zeros((len(lower), p + 1))
    for r in range(p):
        left, right = knots[span - p + 1 + r], knots[span + 1 + r]
        share = p * lower[:, r] / (right - left)
        values[:, r] -= share
        values[:, r + 1] = share
    return values
