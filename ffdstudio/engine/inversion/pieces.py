"""The map of a net as polynomials, one set for each knot span, for Newton in blocks."""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices

ROOM = 1 << 26  # bytes; larger nets are left to the search point by point
HIGHEST = 10  # degree; above it monomials lose digits


class Pieces(NamedTuple):
    """Polynomials in coordinates t from -1 to 1 of each knot span."""

    coefficients: Array  # (spans, 3 or 4, p + 1, (q + 1) (r + 1)): N from the origin, and W
    origin: Array  # (spans, 3)
    middle: Array  # (spans, 3) parameters of the centre
    half: Array  # (spans, 3) half the extent in parameters
    of_cell: Indices  # (cells,) span of each cell


def pieces_of(control: Array, middle: Array, half: Array) -> Pieces | None:
    """Polynomials of Bezier volumes, (spans, p + 1, q + 1, r + 1, 4); None if not worth it."""
    shape = control.shape[1:4]
    if control.nbytes > ROOM or max(shape) > HIGHEST + 1:
        return None
    weights = control[..., 3:]
    origin = control[:, 0, 0, 0, :3] / control[:, 0, 0, 0, 3:]
    fields = control.copy()
    fields[..., :3] -= origin[:, None, None, None] * weights
    if (weights == 1).all():
        fields = fields[..., :3]
    for k, count in enumerate(shape):
        fields = np.moveaxis(np.tensordot(fields, _monomials(count - 1), (k + 1, 0)), -1, k + 1)
    table = np.moveaxis(fields, -1, 1).reshape(len(control), fields.shape[-1], shape[0], -1)
    return Pieces(
        np.ascontiguousarray(table), origin, middle.copy(), half.copy(), np.empty(0, np.int64)
    )


def _monomials(degree: int) -> Array:
    """(function, power) Bernstein polynomials by powers of t in [-1, 1]."""
    rows = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        row = np.array([comb(degree, i) / 2.0**degree])
        for factor in i * [[1.0, 1.0]] + (degree - i) * [[1.0, -1.0]]:
            row = np.convolve(row, factor)
        rows[i] = row
    return rows
