"""Newton's method for many points of a knot span side by side, compiled.

1. Most points lie in the first cell that can hold them, and a few steps from its affine map
   find them there. The points of a span share its polynomials and are taken in blocks, one
   loop over the points innermost, so that whole vectors work; what is not found inside its span
   in a few steps is left to the search of `kernels`.
2. A point that has converged stays as it is while others of its block go on, and multiply-adds
   are fused by name: what a point receives does not depend on its neighbours.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.compiling import compiled
from ffdstudio.engine.inversion.kernels import candidates
from ffdstudio.engine.inversion.pieces import Pieces
from ffdstudio.engine.kernels import _fma

BLOCK = 64  # points
STEPS = 8  # of Newton; the search does better with what needs more


@compiled
def begin(
    points: Array, axes: Array, centre: Array, cells: Any, bins: Any, pieces: Pieces, slack: float,
    longest: int, x: Array, t: Array, span: Indices,
) -> None:  # fmt: skip
    """Points from the net's centre, the span to look in (-1: none) and where to begin there."""
    _, middles, halves, centres, inverses, _, _, _ = cells
    passed, found = np.empty(longest), np.empty(longest, np.int64)
    here = np.empty(3)
    for n in range(len(points)):
        for k in range(3):
            here[k] = (
                axes[k, 0] * points[n, 0] + axes[k, 1] * points[n, 1] + axes[k, 2] * points[n, 2]
            ) - centre[k]
            x[n, k] = here[k]
        span[n] = -1
        if candidates(here, bins, cells, slack, passed, found) == 0:
            continue
        c = found[0]
        piece = pieces.of_cell[c]
        span[n] = piece
        for k in range(3):
            s = 0.0
            for d in range(3):
                s += inverses[c, k, d] * (here[d] - centres[c, d])
            u = middles[c, k] + halves[c, k] * min(max(s, -1.0), 1.0)
            t[n, k] = (u - pieces.middle[piece, k]) / pieces.half[piece, k]


@compiled
def sort_by_span(span: Indices, starts: Indices, order: Indices) -> None:
    """Rows with a span in the order of their spans; `starts` has one entry more than spans."""
    for i in range(len(starts)):
        starts[i] = 0
    for n in range(len(span)):
        if span[n] >= 0:
            starts[span[n] + 1] += 1
    for i in range(1, len(starts)):
        starts[i] += starts[i - 1]
    for n in range(len(span)):
        if span[n] >= 0:
            order[starts[span[n]]] = n
            starts[span[n]] += 1
    for i in range(len(starts) - 1, 0, -1):
        starts[i] = starts[i - 1]
    starts[0] = 0


@compiled
def newton_in_blocks(
    starts: Indices, order: Indices, x: Array, t: Array, pieces: Pieces, q: int, r: int,
    goal: float, error: Array, spent: NDArray[np.int16],
) -> None:  # fmt: skip
    """Solutions t of the rows in `order`, with the distance that is left (infinite: not found)."""
    coefficients = pieces.coefficients
    fields, p1 = coefficients.shape[1], coefficients.shape[2]
    local, offset = np.zeros((3, BLOCK)), np.zeros((3, BLOCK))
    t0, t1, t2 = local[0], local[1], local[2]
    value = np.zeros((4, 4, BLOCK))  # by field: value, and slopes by t0, t1, t2
    inner, slope = np.zeros(BLOCK), np.zeros(BLOCK)
    y, y1, y2 = np.zeros(BLOCK), np.zeros(BLOCK), np.zeros(BLOCK)
    open_ones, best = np.zeros(BLOCK), np.zeros(BLOCK)
    for piece in range(len(starts) - 1):
        for start in range(starts[piece], starts[piece + 1], BLOCK):
            size = min(BLOCK, starts[piece + 1] - start)
            for i in range(size):
                n = order[start + i]
                for k in range(3):
                    local[k, i] = t[n, k]
                    offset[k, i] = x[n, k] - pieces.origin[piece, k]
                open_ones[i] = 1.0
                best[i] = np.inf
                spent[n] = 0
            for i in range(size, BLOCK):
                local[0, i], local[1, i], local[2, i], open_ones[i] = 0.0, 0.0, 0.0, 0.0
                offset[0, i], offset[1, i], offset[2, i] = 0.0, 0.0, 0.0
            for _ in range(STEPS):
                for f in range(fields):
                    w, w0, w1, w2 = value[f, 0], value[f, 1], value[f, 2], value[f, 3]
                    for i in range(BLOCK):
                        w[i], w0[i], w1[i], w2[i] = 0.0, 0.0, 0.0, 0.0
                    for a in range(p1 - 1, -1, -1):
                        c = coefficients[piece, f, a]
                        for i in range(BLOCK):
                            y[i], y1[i], y2[i] = 0.0, 0.0, 0.0
                        for b in range(q, -1, -1):
                            at = b * (r + 1)
                            last = c[at + r]
                            for i in range(BLOCK):
                                inner[i], slope[i] = last, 0.0
                            for g in range(r - 1, -1, -1):
                                next_one = c[at + g]
                                for i in range(BLOCK):
                                    slope[i] = _fma(slope[i], t2[i], inner[i])
                                    inner[i] = _fma(inner[i], t2[i], next_one)
                            for i in range(BLOCK):
                                y1[i] = _fma(y1[i], t1[i], y[i])
                                y[i] = _fma(y[i], t1[i], inner[i])
                                y2[i] = _fma(y2[i], t1[i], slope[i])
                        for i in range(BLOCK):
                            w0[i] = _fma(w0[i], t0[i], w[i])
                            w[i] = _fma(w[i], t0[i], y[i])
                            w1[i] = _fma(w1[i], t0[i], y1[i])
                            w2[i] = _fma(w2[i], t0[i], y2[i])
                if fields == 4:
                    for f in range(3):
                        for i in range(BLOCK):
                            share = 1.0 / value[3, 0, i]
                            point = value[f, 0, i] * share
                            value[f, 0, i] = point
                            value[f, 1, i] = (value[f, 1, i] - value[3, 1, i] * point) * share
                            value[f, 2, i] = (value[f, 2, i] - value[3, 2, i] * point) * share
                            value[f, 3, i] = (value[f, 3, i] - value[3, 3, i] * point) * share
                for i in range(BLOCK):
                    d0 = offset[0, i] - value[0, 0, i]
                    d1 = offset[1, i] - value[1, 0, i]
                    d2 = offset[2, i] - value[2, 0, i]
                    off = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                    m00, m01, m02 = value[0, 1, i], value[0, 2, i], value[0, 3, i]
                    m10, m11, m12 = value[1, 1, i], value[1, 2, i], value[1, 3, i]
                    m20, m21, m22 = value[2, 1, i], value[2, 2, i], value[2, 3, i]
                    c0 = m11 * m22 - m12 * m21
                    c1 = m12 * m20 - m10 * m22
                    c2 = m10 * m21 - m11 * m20
                    share = 1.0 / (m00 * c0 + m01 * c1 + m02 * c2)
                    s0 = d0 * c0 + d1 * (m02 * m21 - m01 * m22) + d2 * (m01 * m12 - m02 * m11)
                    s1 = d0 * c1 + d1 * (m00 * m22 - m02 * m20) + d2 * (m02 * m10 - m00 * m12)
                    s2 = d0 * c2 + d1 * (m01 * m20 - m00 * m21) + d2 * (m00 * m11 - m01 * m10)
                    going = open_ones[i] > 0.0
                    done = off <= goal
                    best[i] = off if going else best[i]
                    t0[i] = t0[i] + share * s0 if going and not done else t0[i]
                    t1[i] = t1[i] + share * s1 if going and not done else t1[i]
                    t2[i] = t2[i] + share * s2 if going and not done else t2[i]
                    open_ones[i] = 1.0 if going and not done else 0.0
                    y[i] = 1.0 if going else 0.0
                left = 0
                for i in range(size):
                    if y[i] > 0.0:
                        spent[order[start + i]] += 1
                    if open_ones[i] > 0.0:
                        if abs(t0[i]) <= 3.0 and abs(t1[i]) <= 3.0 and abs(t2[i]) <= 3.0:
                            left += 1
                        else:  # it has left its span for good, or is no number
                            open_ones[i], best[i] = 0.0, np.inf
                if left == 0:
                    break
            for i in range(size):
                n = order[start + i]
                inside = abs(t0[i]) <= 1.0 and abs(t1[i]) <= 1.0 and abs(t2[i]) <= 1.0
                error[n] = best[i] if best[i] <= goal and inside else np.inf
                for k in range(3):
                    t[n, k] = local[k, i]


@compiled
def end(
    error: Array, t: Array, span: Indices, pieces: Pieces, parameters: Array,
    inside: NDArray[np.bool_], residual: Array,
) -> None:  # fmt: skip
    """Write what was found into the arrays of an `Inversion`, and the rest as outside."""
    for n in range(len(span)):
        inside[n] = span[n] >= 0 and error[n] < np.inf
        residual[n] = error[n] if inside[n] else np.inf
        for k in range(parameters.shape[1]):
            parameters[n, k] = np.nan
            if inside[n]:
                middle, half = pieces.middle[span[n], k], pieces.half[span[n], k]
                u = middle + half * t[n, k]
                parameters[n, k] = min(max(u, middle - half), middle + half)
