"""numba kernels of the inversion: find the cells of each point and solve inside them.

1. Coordinates are relative to the net's centre, so that far-away geometry loses no digits.
2. A solve works on the polynomial piece of one knot span, which goes on smoothly beyond
   the span: a point just outside a face converges to a parameter just outside and is
   judged by its distance to the face.
3. All methods share start, bounds and the final judgement, so they differ in the search
   alone. r = J^-1 (x - R), with the cell's own J^-1, measures the way to go in units
   of the cell.
4. All in one file: numba's disk cache watches the file of a kernel, not those of the
   functions it calls.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled

Index = NDArray[np.int64]
Knots = tuple[Array, ...]
Degrees = tuple[int, ...]
Spline = tuple[Array, Knots, Degrees]  # homogeneous net, knots, degrees
Cell = tuple[Index, Array, Array, Array, float]  # span, middle, half, inverse, bend
State = tuple[Array, ...]  # work, u, point, difference, step, jacobian, inverse

NEWTON, SECANT, OCTREE, GOLDEN = range(4)
BEYOND = 3.0  # cells that a search may leave its cell by before it is given up
GOLDEN_STEPS = 15  # to 0.15 % of the interval
ON_KNOT = 1e-12  # of a span: a parameter this little outside counts as in it


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
def _evaluate(
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
def _locate(
    net: Array, knots: Knots, degrees: Degrees, span: Index, u: Array, work: Array, point: Array
) -> None:
    """R(u) alone: what the methods without derivatives pay for."""
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
def _times(matrix: Array, v: Array, out: Array) -> None:
    for r in range(3):
        out[r] = matrix[r, 0] * v[0] + matrix[r, 1] * v[1] + matrix[r, 2] * v[2]


@compiled
def _distance(x: Array, point: Array, difference: Array) -> float:
    """Length of x - point, and the difference itself."""
    for k in range(3):
        difference[k] = x[k] - point[k]
    result: float = np.sqrt(difference[0] ** 2 + difference[1] ** 2 + difference[2] ** 2)
    return result


@compiled
def _invert(m: Array, out: Array) -> bool:
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
def _scaled(inverse: Array, half: Array) -> None:
    """d(parameters) by d(point) to d(cell coordinates) by d(point), in place."""
    for r in range(3):
        for c in range(3):
            inverse[r, c] /= half[r]


@compiled
def _newton(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Newton: a fresh Jacobian at every step."""
    net, knots, degrees = lattice
    span, middle, half, _, _ = cell
    work, u, point, difference, step, jacobian, inverse = state
    for count in range(1, 41):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
        _evaluate(net, knots, degrees, span, u, work, point, jacobian)
        error = _distance(x, point, difference)
        if error <= goal:
            return count, error
        if not _invert(jacobian, inverse):
            break
        _scaled(inverse, half)
        _times(inverse, difference, step)
        if not _advance(s, step):
            break
    return 40, np.inf


@compiled
def _advance(s: Array, step: Array) -> bool:
    """Take a step of at most one cell; False when the search has left for good."""
    largest = max(abs(step[0]), abs(step[1]), abs(step[2]))
    scale = 1.0 if largest <= 1.0 else 1.0 / largest
    for k in range(3):
        s[k] += scale * step[k]
    result: bool = max(abs(s[0]), abs(s[1]), abs(s[2])) <= BEYOND
    return result


@compiled
def _secant(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Broyden's secant method from the cell's own Jacobian, renewed only when a step fails."""
    net, knots, degrees = lattice
    span, middle, half, own, _ = cell
    work, u, point, difference, step, jacobian, inverse = state
    before = np.empty(3)
    change = np.empty(3)
    inverse[:] = own
    last = np.inf
    for count in range(1, 81):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
            before[k] = difference[k]
        _locate(net, knots, degrees, span, u, work, point)
        error = _distance(x, point, difference)
        if error <= goal:
            return count, error
        if error > 0.5 * last:  # the step failed
            _evaluate(net, knots, degrees, span, u, work, point, jacobian)
            if not _invert(jacobian, inverse):
                break
            _scaled(inverse, half)
        elif count > 1:
            for k in range(3):
                change[k] = before[k] - difference[k]
            _broyden(inverse, step, change)
        last = error
        _times(inverse, difference, step)
        if not _advance(s, step):
            break
        largest = max(abs(step[0]), abs(step[1]), abs(step[2]))
        if largest > 1.0:  # shortened: it proves nothing about the Jacobian
            last = 0.0
    return 80, np.inf


@compiled
def _broyden(inverse: Array, step: Array, change: Array) -> None:
    """Good Broyden update of an inverse Jacobian (Sherman-Morrison): inverse @ change = step."""
    h0 = inverse[0, 0] * change[0] + inverse[0, 1] * change[1] + inverse[0, 2] * change[2]
    h1 = inverse[1, 0] * change[0] + inverse[1, 1] * change[1] + inverse[1, 2] * change[2]
    h2 = inverse[2, 0] * change[0] + inverse[2, 1] * change[1] + inverse[2, 2] * change[2]
    below = step[0] * h0 + step[1] * h1 + step[2] * h2
    if below == 0.0:
        return
    d0, d1, d2 = (step[0] - h0) / below, (step[1] - h1) / below, (step[2] - h2) / below
    for c in range(3):
        row = step[0] * inverse[0, c] + step[1] * inverse[1, c] + step[2] * inverse[2, c]
        inverse[0, c] += d0 * row
        inverse[1, c] += d1 * row
        inverse[2, c] += d2 * row


@compiled
def _octree(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Octree search: the octant that holds the point, again and again.

    The cell's bend q bounds how wrong r can be: e is at most h, |r - e| <= q h, so after
    a step of h/2 by the signs of r the point is within (1/2 + q) h. Octants overlap by
    that much.
    """
    net, knots, degrees = lattice
    span, middle, half, own, bend = cell
    work, u, point, difference, step, _, _ = state
    shrink = min(0.5 + bend, 0.95)
    size = 1.2
    s[:] = 0.0
    for count in range(1, 1001):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
        _locate(net, knots, degrees, span, u, work, point)
        error = _distance(x, point, difference)
        if error <= goal:
            return count, error
        _times(own, difference, step)
        for k in range(3):
            s[k] += 0.5 * size if step[k] > 0 else -0.5 * size
        size *= shrink
        if size < 1e-17:
            break
    return 1000, np.inf


@compiled
def _golden(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Golden section along each parameter in turn, on the length of r."""
    net, knots, degrees = lattice
    span, middle, half, own, _ = cell
    work, u, point, difference, step, _, _ = state
    golden = 0.6180339887498949
    count = 0
    for _ in range(100):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
        _locate(net, knots, degrees, span, u, work, point)
        count += 1
        error = _distance(x, point, difference)
        if error <= goal:
            return count, error
        _times(own, difference, step)
        size = 2.0 * np.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
        if max(abs(s[0]), abs(s[1]), abs(s[2])) > BEYOND:
            break
        for axis in range(3):
            low, high = s[axis] - size, s[axis] + size
            a, b = high - golden * (high - low), low + golden * (high - low)
            fa = fb = -1.0
            for _step in range(GOLDEN_STEPS):  # a count: rounding may stop the interval's shrinking
                if fa < 0.0:
                    u[axis] = middle[axis] + half[axis] * a
                    _locate(net, knots, degrees, span, u, work, point)
                    _distance(x, point, difference)
                    _times(own, difference, step)
                    fa = step[0] ** 2 + step[1] ** 2 + step[2] ** 2
                    count += 1
                if fb < 0.0:
                    u[axis] = middle[axis] + half[axis] * b
                    _locate(net, knots, degrees, span, u, work, point)
                    _distance(x, point, difference)
                    _times(own, difference, step)
                    fb = step[0] ** 2 + step[1] ** 2 + step[2] ** 2
                    count += 1
                if fa <= fb:
                    high, b, fb = b, a, fa
                    a, fa = high - golden * (high - low), -1.0
                else:
                    low, a, fa = a, b, fb
                    b, fb = low + golden * (high - low), -1.0
            s[axis] = 0.5 * (low + high)
            u[axis] = middle[axis] + half[axis] * s[axis]
    return count, np.inf


@compiled
def _judge(
    lattice: Spline,
    cell: Cell,
    x: Array,
    s: Array,
    state: State,
    error: float,
    goal: float,
    slack: float,
) -> float:
    """Hold a solution in its knot span if it is as good there; residual, or -1 for "not here".

    Beyond a face of the lattice a point may be off by `slack`. Beyond an inner knot it
    belongs to the next span, unless the search itself is no finer than that.
    """
    net, knots, degrees = lattice
    span, middle, half, _, _ = cell
    work, u, point, difference = state[0], state[1], state[2], state[3]
    moved, allowed = False, slack
    for k in range(3):
        low, high = knots[k][span[k]], knots[k][span[k] + 1]
        u[k] = middle[k] + half[k] * s[k]
        over = max(low - u[k], u[k] - high)
        if over > 0.0:
            moved = True
            face = low == knots[k][0] if u[k] < low else high == knots[k][len(knots[k]) - 1]
            if not face and over > ON_KNOT * (high - low):
                allowed = 2.0 * goal
            u[k] = min(max(u[k], low), high)
    if moved:
        _locate(net, knots, degrees, span, u, work, point)
        error = _distance(x, point, difference)
    return error if error <= max(allowed, goal) else -1.0


@compiled
def _candidates(x: Array, bins: Any, cells: Any, slack: float, passed: Array, found: Index) -> int:
    """Cells whose bounds hold x, those that should hold it by their frame first."""
    lower, upper, per_length, shape, first, listed = bins
    _, _, _, centres, inverses, lows, highs, _ = cells
    place = 0
    for k in range(3):
        if not (lower[k] <= x[k] <= upper[k]):
            return 0
        at = min(int((x[k] - lower[k]) * per_length[k]), shape[k] - 1)
        place = place * shape[k] + at
    count = 0
    for slot in range(first[place], first[place + 1]):
        cell = listed[slot]
        largest = 0.0
        within = True
        for r in range(3):
            y = 0.0
            reach = 0.0
            for c in range(3):
                y += inverses[cell, r, c] * (x[c] - centres[cell, c])
                reach += abs(inverses[cell, r, c])
            if y < lows[cell, r] - reach * slack or y > highs[cell, r] + reach * slack:
                within = False
                break
            largest = max(largest, abs(y))
        if within and count < len(found):
            at = count
            while at > 0 and passed[at - 1] > largest:
                passed[at], found[at] = passed[at - 1], found[at - 1]
                at -= 1
            passed[at], found[at] = largest, cell
            count += 1
    return count


@compiled
def _search_for(turn: int, method: int, singular: bool) -> int:
    """Which method has its turn in a cell; -1 when none is left.

    In a regular cell Newton is the last word where another search got lost. Where the map
    is singular (the axis of a polar net) Newton itself may get lost, and others do not.
    """
    if turn == 0:
        return method
    if turn == 1:
        if method != NEWTON:
            return NEWTON
        return SECANT if singular else -1
    if not singular:
        return -1
    if turn == 2:
        return OCTREE if method <= SECANT else SECANT
    if method <= SECANT:
        return -1
    return OCTREE if method == GOLDEN else -1


@compiled
def invert_points(
    method: int, net: Array, knots: Knots, degrees: Degrees, cells: Any, bins: Any, points: Array,
    axes: Array, centre: Array, goal: float, slack: float, regular: float, longest: int,
    parameters: Array, inside: NDArray[np.bool_], residual: Array, iterations: NDArray[np.int16],
) -> None:  # fmt: skip
    """Fill the last four arrays for each point: see `Inversion`."""
    spans, middles, halves, centres, inverses, _, _, bends = cells
    work = np.empty((6, max(degrees[0], degrees[1], degrees[2]) + 1))
    u, point, difference, step = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    state = (work, u, point, difference, step, np.empty((3, 3)), np.empty((3, 3)))
    lattice = (net, knots, degrees)
    x, s = np.empty(3), np.empty(3)
    order, found = np.empty(longest), np.empty(longest, np.int64)
    dimension = parameters.shape[1]
    for n in range(len(points)):
        for k in range(3):
            x[k] = (
                axes[k, 0] * points[n, 0] + axes[k, 1] * points[n, 1] + axes[k, 2] * points[n, 2]
            ) - centre[k]
        inside[n], residual[n], iterations[n] = False, np.inf, 0
        for k in range(dimension):
            parameters[n, k] = np.nan
        for slot in range(_candidates(x, bins, cells, slack, order, found)):
            c = found[slot]
            cell = (spans[c], middles[c], halves[c], inverses[c], bends[c])
            count, error = 0, np.inf
            for turn in range(4):
                search = _search_for(turn, method, bends[c] > regular)
                if search < 0:
                    break
                _distance(x, centres[c], difference)
                _times(inverses[c], difference, s)
                for k in range(3):
                    s[k] = min(max(s[k], -1.0), 1.0)
                if search == NEWTON:
                    spent, error = _newton(lattice, cell, x, s, state, goal)
                elif search == SECANT:
                    spent, error = _secant(lattice, cell, x, s, state, goal)
                elif search == OCTREE:
                    spent, error = _octree(lattice, cell, x, s, state, goal)
                else:
                    spent, error = _golden(lattice, cell, x, s, state, goal)
                count += spent
                if error < np.inf:
                    break
            iterations[n] = min(iterations[n] + count, 32767)
            if error == np.inf:
                continue
            error = _judge(lattice, cell, x, s, state, error, goal, slack)
            if error >= 0.0:
                inside[n], residual[n] = True, error
                for k in range(dimension):
                    parameters[n, k] = u[k]
                break
