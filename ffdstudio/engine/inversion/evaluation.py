"""Compiled evaluation of a net and of its derivatives at one point, and 3x3 algebra.

The polynomial piece of one knot span is evaluated, which goes on smoothly beyond the span.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled, whole

Index = NDArray[np.int64]
Knots = tuple[Array, ...]
Degrees = tuple[int, ...]


apart = whole()


@compiled
def _functions(
    knots: Array, degree: int, span: int, u: float, values: Array, slopes: Array
) -> None:
    """Basis functions of one direction and their derivatives at u (the piece of `span`)."""
    values[0] = 1.0
    for p in range(1, degree + 1):
        if p == degree:
            for r in range(degree + 1):
                slopes[r] = 0.0
        carried = 0.0
        for r in range(p):
            left = knots[span - p + 1 + r]
            right = knots[span + 1 + r]
            share = values[r] / (right - left)
            if p == degree:
                slopes[r] -= p * share
                slopes[r + 1] = p * share
            values[r] = carried + (right - u) * share
            carried = (u - left) * share
        values[p] = carried


@compiled
def evaluate(
    net: Array,
    knots: Knots,
    degrees: Degrees,
    span: Index,
    u: Array,
    work: Array,
    point: Array,
    jacobian: Array,
) -> None:
    """R(u) into `point` and dR/du into `jacobian` (column by direction)."""
    apart()
    for k in range(3):
        _functions(knots[k], degrees[k], span[k], u[k], work[2 * k], work[2 * k + 1])
    i0, j0, k0 = span[0] - degrees[0], span[1] - degrees[1], span[2] - degrees[2]
    n0 = n1 = n2 = n3 = 0.0
    a0 = a1 = a2 = a3 = 0.0
    b0 = b1 = b2 = b3 = 0.0
    c0 = c1 = c2 = c3 = 0.0
    for i in range(degrees[0] + 1):
        fi, di = work[0, i], work[1, i]
        for j in range(degrees[1] + 1):
            fj, dj = work[2, j], work[3, j]
            s0 = s1 = s2 = s3 = 0.0
            t0 = t1 = t2 = t3 = 0.0
            for k in range(degrees[2] + 1):
                fk, dk = work[4, k], work[5, k]
                p0 = net[i0 + i, j0 + j, k0 + k, 0]
                p1 = net[i0 + i, j0 + j, k0 + k, 1]
                p2 = net[i0 + i, j0 + j, k0 + k, 2]
                p3 = net[i0 + i, j0 + j, k0 + k, 3]
                s0 += fk * p0
                s1 += fk * p1
                s2 += fk * p2
                s3 += fk * p3
                t0 += dk * p0
                t1 += dk * p1
                t2 += dk * p2
                t3 += dk * p3
            ff, df, fd = fi * fj, di * fj, fi * dj
            n0 += ff * s0
            n1 += ff * s1
            n2 += ff * s2
            n3 += ff * s3
            a0 += df * s0
            a1 += df * s1
            a2 += df * s2
            a3 += df * s3
            b0 += fd * s0
            b1 += fd * s1
            b2 += fd * s2
            b3 += fd * s3
            c0 += ff * t0
            c1 += ff * t1
            c2 += ff * t2
            c3 += ff * t3
    w = 1.0 / n3
    point[0], point[1], point[2] = n0 * w, n1 * w, n2 * w
    jacobian[0, 0] = (a0 - a3 * point[0]) * w
    jacobian[1, 0] = (a1 - a3 * point[1]) * w
    jacobian[2, 0] = (a2 - a3 * point[2]) * w
    jacobian[0, 1] = (b0 - b3 * point[0]) * w
    jacobian[1, 1] = (b1 - b3 * point[1]) * w
    jacobian[2, 1] = (b2 - b3 * point[2]) * w
    jacobian[0, 2] = (c0 - c3 * point[0]) * w
    jacobian[1, 2] = (c1 - c3 * point[1]) * w
    jacobian[2, 2] = (c2 - c3 * point[2]) * w


@compiled
def _values(knots: Array, degree: int, span: int, u: float, values: Array) -> None:
    """Basis functions of one direction without derivatives."""
    values[0] = 1.0
    for p in range(1, degree + 1):
        carried = 0.0
        for r in range(p):
            left = knots[span - p + 1 + r]
            right = knots[span + 1 + r]
            share = values[r] / (right - left)
            values[r] = carried + (right - u) * share
            carried = (u - left) * share
        values[p] = carried


@compiled
def locate(
    net: Array, knots: Knots, degrees: Degrees, span: Index, u: Array, work: Array, point: Array
) -> None:
    """R(u) alone: what the methods without derivatives pay for."""
    apart()
    for k in range(3):
        _values(knots[k], degrees[k], span[k], u[k], work[2 * k])
    i0, j0, k0 = span[0] - degrees[0], span[1] - degrees[1], span[2] - degrees[2]
    n0 = n1 = n2 = n3 = 0.0
    for i in range(degrees[0] + 1):
        for j in range(degrees[1] + 1):
            s0 = s1 = s2 = s3 = 0.0
            for k in range(degrees[2] + 1):
                f = work[4, k]
                s0 += f * net[i0 + i, j0 + j, k0 + k, 0]
                s1 += f * net[i0 + i, j0 + j, k0 + k, 1]
                s2 += f * net[i0 + i, j0 + j, k0 + k, 2]
                s3 += f * net[i0 + i, j0 + j, k0 + k, 3]
            f = work[0, i] * work[2, j]
            n0 += f * s0
            n1 += f * s1
            n2 += f * s2
            n3 += f * s3
    point[0], point[1], point[2] = n0 / n3, n1 / n3, n2 / n3


@compiled
def times(matrix: Array, v: Array, out: Array) -> None:
    """Product of a 3x3 matrix with a vector."""
    for r in range(3):
        out[r] = matrix[r, 0] * v[0] + matrix[r, 1] * v[1] + matrix[r, 2] * v[2]


@compiled
def distance(x: Array, point: Array, difference: Array) -> float:
    """Length of x - point, and the difference itself."""
    for k in range(3):
        difference[k] = x[k] - point[k]
    return float(np.sqrt(difference[0] ** 2 + difference[1] ** 2 + difference[2] ** 2))


@compiled
def invert(m: Array, out: Array) -> bool:
    """Inverse of a 3x3 matrix; False if it is singular."""
    c00 = m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    c01 = m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2]
    c02 = m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0]
    determinant = m[0, 0] * c00 + m[0, 1] * c01 + m[0, 2] * c02
    if determinant == 0.0 or not np.isfinite(determinant):
        return False
    d = 1.0 / determinant
    out[0, 0], out[1, 0], out[2, 0] = c00 * d, c01 * d, c02 * d
    out[0, 1] = (m[0, 2] * m[2, 1] - m[0, 1] * m[2, 2]) * d
    out[1, 1] = (m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0]) * d
    out[2, 1] = (m[0, 1] * m[2, 0] - m[0, 0] * m[2, 1]) * d
    out[0, 2] = (m[0, 1] * m[1, 2] - m[0, 2] * m[1, 1]) * d
    out[1, 2] = (m[0, 2] * m[1, 0] - m[0, 0] * m[1, 2]) * d
    out[2, 2] = (m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]) * d
    return True


@compiled
def scaled(inverse: Array, half: Array) -> None:
    """d(parameters) by d(point) to d(cell coordinates) by d(point), in place."""
    for r in range(3):
        for c in range(3):
            inverse[r, c] /= half[r]
