"""Matrices that carry control points from one spline space into another.

1. Both knot insertion and degree elevation write a new control point as the blossom
   (polar form) of the old spline at neighbouring new knots (Ramshaw 1987); one function
   gives the weights of the old control points in it.
2. The matrices act on homogeneous control points, so weighted lattices need nothing more.
3. Knot removal is the least-squares inverse of insertion; the caller checks the error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine.knots import find_spans

if TYPE_CHECKING:
    from ffdstudio.engine.lattice import Lattice


def insertion(knots: Array, degree: int, new_knots: ArrayLike) -> tuple[Array, Array]:
    """Finer knot vector and the matrix from old to new control points (Oslo algorithm).

    Examples
    --------
    >>> import numpy as np
    >>> insertion(np.array([0.0, 0, 1, 1]), 1, [0.25])[1]
    array([[1.  , 0.  ],
           [0.75, 0.25],
           [0.  , 1.  ]])
    """
    finer = np.sort(np.concatenate([knots, np.atleast_1d(np.asarray(new_knots, np.float64))]))
    count = len(knots) - degree - 1
    matrix = np.zeros((len(finer) - degree - 1, count))
    for i, row in enumerate(matrix):
        _add_blossom(row, knots, degree, finer[i + 1 : i + degree + 1])
    return finer, without_dust(matrix)


def elevation(knots: Array, degree: int) -> tuple[Array, Array]:
    """Knot vector of the next degree and the matrix to its control points.

    Every distinct knot gains one in multiplicity. The new blossom is the mean of the old
    one over its arguments with one left out.
    """
    values, multiplicity = np.unique(knots, return_counts=True)
    finer = np.repeat(values, multiplicity + 1)
    count = len(knots) - degree - 1
    matrix = np.zeros((len(finer) - degree - 2, count))
    for i, row in enumerate(matrix):
        window = finer[i + 1 : i + degree + 2]
        for left_out in range(degree + 1):
            _add_blossom(row, knots, degree, np.delete(window, left_out), window)
        row /= degree + 1
    return finer, without_dust(matrix)


def removal(knots: Array, degree: int, gone: ArrayLike) -> tuple[Array, Array, Array]:
    """Coarser knot vector, the matrix to its control points, and the insertion matrix back.

    The end control points are kept as they are; those between are the least-squares ones.
    `gone` must be inner knots of `knots`.
    """
    coarser = knots.copy()
    for knot in np.atleast_1d(np.asarray(gone, np.float64)):
        coarser = np.delete(coarser, np.flatnonzero(coarser == knot)[0])
    _, back = insertion(coarser, degree, gone)
    inner, ends = back[1:-1, 1:-1], back[1:-1, [0, -1]]
    matrix = np.zeros(back.T.shape)
    matrix[0, 0] = matrix[-1, -1] = 1.0
    if inner.size:
        solve = np.linalg.pinv(inner)
        matrix[1:-1, 1:-1] = solve
        matrix[1:-1, [0, -1]] -= solve @ ends
    return coarser, matrix, back


def along(matrix: Array, array: Array, axis: int) -> Array:
    """Multiply `matrix` with `array` along one of its axes.

    Summed in a fixed order from zero, so that a part of the net that two lattices share
    comes out with the same bits in both.
    """
    moved = np.moveaxis(array, axis, 0)
    out = np.zeros((len(matrix), *moved.shape[1:]))
    for i, row in enumerate(matrix):
        for j in np.flatnonzero(row):
            out[i] += row[j] * moved[j]
    return np.moveaxis(out, 0, axis).copy()


def carried(lattice: Lattice, axis: int, matrix: Array) -> tuple[Array, Array]:
    """Control points and weights that are `matrix` times those of a lattice along an axis."""
    if (lattice.weights == 1).all():  # keep exact ones: the unweighted case is the fast one
        points = along(matrix, lattice.control_points, axis)
        return points, np.ones(points.shape[:-1])
    homogeneous = along(matrix, lattice.homogeneous, axis)
    weights = homogeneous[..., 3].copy()
    return homogeneous[..., :3] / weights[..., None], weights


def blossom(knots: Array, degree: int, arguments: Array, count: int) -> Array:
    """(count,) weights of the control points in the blossom of a spline at some arguments.

    With one argument more than the degree it is that of the spline with its degree raised: the
    mean over the arguments with one left out.
    """
    row = np.zeros(count)
    if len(arguments) == degree:
        _add_blossom(row, knots, degree, arguments)
        return row
    for left_out in range(len(arguments)):
        _add_blossom(row, knots, degree, np.delete(arguments, left_out), arguments)
    return row / len(arguments)


def _add_blossom(
    row: Array, knots: Array, degree: int, arguments: Array, window: Array | None = None
) -> None:
    """Add to `row` the weights of the control points in the blossom at `arguments`."""
    window = arguments if window is None else window
    middle = np.array([0.5 * (window[0] + window[-1])])
    span = int(find_spans(knots, degree, middle)[0])
    weights = np.ones(1)
    for p, argument in enumerate(arguments, start=1):
        raised = np.zeros(p + 1)
        for r in range(p):
            left, right = knots[span - p + 1 + r], knots[span + 1 + r]
            share = weights[r] / (right - left)
            raised[r] += (right - argument) * share
            raised[r + 1] = (argument - left) * share
        weights = raised
    row[span - degree : span + 1] += weights


def without_dust(matrix: Array) -> Array:
    """Zeros for what rounding left of them: it would carry changes to where they do not reach."""
    matrix[np.abs(matrix) < 1e-14] = 0.0
    return matrix
