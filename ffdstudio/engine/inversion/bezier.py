"""Compiled work on one Bezier volume: halve it, and measure how nearly affine its map is.

1. In a cell's own coordinates s in [-1, 1], y = J^-1 (x - centre) is nearly s. `bend`
   says how far dy/ds is from the identity: the largest row sum of the difference over a
   grid of samples, with a margin for what lies between them. Below 1 the map is one-to-one
   in the cell and a search from anywhere in it ends at the only solution.
2. With positive weights a volume lies in the convex hull of its control points, so bounds
   taken from these are safe: a point outside them is outside the cell.
3. A cell is halved across the direction that makes it straightest: change along k of the slope
   of y_r by s_d goes with h_d h_k / h_r, h being the extents of the cell, so halving it in one
   direction makes some of that smaller and some larger.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled, whole

SAMPLES = 4  # in each direction of a cell, the ends among them
MARGIN = 1.25


def sample_rows(degrees: tuple[int, ...]) -> Array:
    """Table (3, 2, SAMPLES + 1, p + 1) of Bernstein functions and slopes by s, the centre last."""
    places = [*np.linspace(0.0, 1.0, SAMPLES), 0.5]
    table = np.zeros((3, 2, len(places), max(degrees) + 1))
    for k, p in enumerate(degrees):
        for i, t in enumerate(places):
            table[k, 0, i, : p + 1] = _bernstein(p, t)
            low = np.concatenate([[0.0], _bernstein(p - 1, t), [0.0]])
            table[k, 1, i, : p + 1] = 0.5 * p * (low[:-1] - low[1:])
    return table


def _bernstein(degree: int, t: float) -> Array:
    row = np.array([1.0])
    for _ in range(degree):
        row = np.convolve(row, [1 - t, t])
    return row


apart = whole()


@compiled
def halve(control: Array, axis: int, left: Array, right: Array) -> None:
    """Bezier points (p + 1, q + 1, r + 1, 4) of both halves (de Casteljau)."""
    apart()
    n, before, behind = control.shape[axis], 1, 4
    for k in range(3):
        before *= control.shape[k] if k < axis else 1
        behind *= control.shape[k] if k > axis else 1
    whole_one = control.reshape(before, n, behind)
    first, rest = left.reshape(before, n, behind), right.reshape(before, n, behind)
    for i in range(before):
        for j in range(behind):
            for m in range(n):
                rest[i, m, j] = whole_one[i, m, j]
            for step in range(n):
                first[i, step, j] = rest[i, 0, j]
                for m in range(n - 1 - step):
                    rest[i, m, j] = 0.5 * (rest[i, m, j] + rest[i, m + 1, j])


@compiled
def frame(control: Array, rows: Array, centre: Array, inverse: Array) -> bool:
    """Centre and inverse Jacobian by s there; False, and zeros, where the map is singular."""
    apart()
    n0, n1, n2, _ = control.shape
    sums = np.zeros((4, 4))
    c = rows.shape[2] - 1
    for i in range(n0):
        for j in range(n1):
            for k in range(n2):
                b0, b1, b2 = rows[0, 0, c, i], rows[1, 0, c, j], rows[2, 0, c, k]
                for f in range(4):
                    value = control[i, j, k, f]
                    sums[0, f] += b0 * b1 * b2 * value
                    sums[1, f] += rows[0, 1, c, i] * b1 * b2 * value
                    sums[2, f] += b0 * rows[1, 1, c, j] * b2 * value
                    sums[3, f] += b0 * b1 * rows[2, 1, c, k] * value
    w = sums[0, 3]
    m = np.empty((3, 3))
    scale = 0.0
    for r in range(3):
        centre[r] = sums[0, r] / w
        for d in range(3):
            m[r, d] = (sums[d + 1, r] - sums[d + 1, 3] * centre[r]) / w
            scale += m[r, d] ** 2
    inverse[0, 0] = m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    inverse[1, 0] = m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2]
    inverse[2, 0] = m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0]
    inverse[0, 1] = m[0, 2] * m[2, 1] - m[0, 1] * m[2, 2]
    inverse[1, 1] = m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0]
    inverse[2, 1] = m[0, 1] * m[2, 0] - m[0, 0] * m[2, 1]
    inverse[0, 2] = m[0, 1] * m[1, 2] - m[0, 2] * m[1, 1]
    inverse[1, 2] = m[0, 2] * m[1, 0] - m[0, 0] * m[1, 2]
    inverse[2, 2] = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    det = m[0, 0] * inverse[0, 0] + m[0, 1] * inverse[1, 0] + m[0, 2] * inverse[2, 0]
    regular = bool(abs(det) > 1e-30 * scale**1.5)
    for r in range(3):
        for d in range(3):
            inverse[r, d] = inverse[r, d] / det if regular else 0.0
    return regular


@compiled
def bounds(control: Array, centre: Array, inverse: Array, box: Array) -> None:
    """Least and largest x, y = J^-1 (x - centre) over the control points into box (4, 3)."""
    apart()
    n0, n1, n2, _ = control.shape
    for r in range(3):
        box[0, r] = box[2, r] = np.inf
        box[1, r] = box[3, r] = -np.inf
    x = np.empty(3)
    for i in range(n0):
        for j in range(n1):
            for k in range(n2):
                for r in range(3):
                    x[r] = control[i, j, k, r] / control[i, j, k, 3]
                    box[0, r] = min(box[0, r], x[r])
                    box[1, r] = max(box[1, r], x[r])
                for r in range(3):
                    y = 0.0
                    for d in range(3):
                        y += inverse[r, d] * (x[d] - centre[d])
                    box[2, r] = min(box[2, r], y)
                    box[3, r] = max(box[3, r], y)


@compiled
def slopes(control: Array, rows: Array, inverse: Array, out: Array) -> float:
    """Bend; fills out (SAMPLES, SAMPLES, SAMPLES, 9) with dy/ds, its rows one after the other."""
    apart()
    n0, n1, n2, _ = control.shape
    g = SAMPLES
    last = np.zeros((2, n0, n1, g, 4))
    for v in range(2):
        for i in range(n0):
            for j in range(n1):
                for c in range(g):
                    for k in range(n2):
                        b = rows[2, v, c, k]
                        for f in range(4):
                            last[v, i, j, c, f] += b * control[i, j, k, f]
    two = np.zeros((3, n0, g, g, 4))  # value, slope in the second, slope in the third
    for v in range(3):
        for i in range(n0):
            for b in range(g):
                for j in range(n1):
                    weight = rows[1, 1 if v == 1 else 0, b, j]
                    for c in range(g):
                        for f in range(4):
                            two[v, i, b, c, f] += weight * last[1 if v == 2 else 0, i, j, c, f]
    worst = 0.0
    sums = np.empty((4, 4))
    for a in range(g):
        for b in range(g):
            for c in range(g):
                for e in range(4):
                    for f in range(4):
                        sums[e, f] = 0.0
                for i in range(n0):
                    value, slope = rows[0, 0, a, i], rows[0, 1, a, i]
                    for f in range(4):
                        sums[0, f] += value * two[0, i, b, c, f]
                        sums[1, f] += slope * two[0, i, b, c, f]
                        sums[2, f] += value * two[1, i, b, c, f]
                        sums[3, f] += value * two[2, i, b, c, f]
                w = sums[0, 3]
                for r in range(3):
                    off = 0.0
                    for d in range(3):
                        y = 0.0
                        for e in range(3):
                            y += inverse[r, e] * (sums[d + 1, e] - sums[d + 1, 3] * sums[0, e] / w)
                        y /= w
                        out[a, b, c, 3 * r + d] = y
                        off += abs(y - (1.0 if r == d else 0.0))
                    worst = max(worst, off)
    return MARGIN * worst


@compiled
def best_cut(values: Array) -> int:
    """Direction across which to halve a cell, from its slopes."""
    apart()
    g = SAMPLES
    best, least = 0, np.inf
    change = np.zeros((9, 3))
    low, high = np.empty(3), np.empty(3)
    for rd in range(9):
        for a in range(g):
            for b in range(g):
                for axis in range(3):
                    low[axis], high[axis] = np.inf, -np.inf
                for c in range(g):
                    for axis in range(3):
                        if axis == 0:
                            y = values[c, a, b, rd]
                        elif axis == 1:
                            y = values[a, c, b, rd]
                        else:
                            y = values[a, b, c, rd]
                        low[axis], high[axis] = min(low[axis], y), max(high[axis], y)
                for axis in range(3):
                    change[rd, axis] = max(change[rd, axis], high[axis] - low[axis])
    for cut in range(3):
        after = 0.0
        for rd in range(9):
            r, d = rd // 3, rd % 3
            for k in range(3):
                factor = (2.0 if r == cut else 1.0) * (0.5 if d == cut else 1.0)
                after += change[rd, k] * factor * (0.5 if k == cut else 1.0)
        if after < least:
            best, least = cut, after
    return best
