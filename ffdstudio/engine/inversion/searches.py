"""Compiled searches for one point in one cell, and the judgement of what they find.

1. A solve works on the polynomial piece of one knot span, which goes on smoothly beyond
   the span: a point just outside a face converges to a parameter just outside and is
   judged by its distance to the face.
2. All methods share start, bounds and the final judgement, so they differ in the search
   alone. r = J^-1 (x - R), with the cell's own J^-1, measures the way to go in units
   of the cell.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled, whole
from ffdstudio.engine.inversion.evaluation import (
    Degrees,
    Index,
    Knots,
    distance,
    evaluate,
    invert,
    locate,
    scaled,
    times,
)

Spline = tuple[Array, Knots, Degrees]  # homogeneous net, knots, degrees
Cell = tuple[Index, Array, Array, Array, float]  # span, middle, half, inverse, bend
State = tuple[Array, ...]  # work, u, point, difference, step, jacobian, inverse

NEWTON, SECANT, OCTREE, GOLDEN = range(4)
BEYOND = 3.0  # cells that a search may leave its cell by before it is given up
GOLDEN_STEPS = 15  # to 0.15 % of the interval
ON_KNOT = 1e-12  # of a span: a parameter this little outside counts as in it


apart = whole()


@compiled
def newton(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Newton: a fresh Jacobian at every step."""
    apart()
    net, knots, degrees = lattice
    span, middle, half, _, _ = cell
    work, u, point, difference, step, jacobian, inverse = state
    for count in range(1, 41):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
        evaluate(net, knots, degrees, span, u, work, point, jacobian)
        error = distance(x, point, difference)
        if error <= goal:
            return count, error
        if not invert(jacobian, inverse):
            break
        scaled(inverse, half)
        times(inverse, difference, step)
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
    return bool(max(abs(s[0]), abs(s[1]), abs(s[2])) <= BEYOND)


@compiled
def secant(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Broyden's secant method from the cell's own Jacobian, renewed only when a step fails."""
    apart()
    net, knots, degrees = lattice
    span, middle, half, own, _ = cell
    work, u, point, difference, step, jacobian, inverse = state
    before = np.empty(3)
    change = np.empty(3)
    for r in range(3):
        for c in range(3):
            inverse[r, c] = own[r, c]
    last = np.inf
    for count in range(1, 81):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
            before[k] = difference[k]
        locate(net, knots, degrees, span, u, work, point)
        error = distance(x, point, difference)
        if error <= goal:
            return count, error
        if error > 0.5 * last:  # the step failed
            evaluate(net, knots, degrees, span, u, work, point, jacobian)
            if not invert(jacobian, inverse):
                break
            scaled(inverse, half)
        elif count > 1:
            for k in range(3):
                change[k] = before[k] - difference[k]
            _broyden(inverse, step, change)
        last = error
        times(inverse, difference, step)
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
def octree(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Octree search: the octant that holds the point, again and again.

    The cell's bend q bounds how wrong r can be: e is at most h, |r - e| <= q h, so after
    a step of h/2 by the signs of r the point is within (1/2 + q) h. Octants overlap by
    that much.
    """
    apart()
    net, knots, degrees = lattice
    span, middle, half, own, bend = cell
    work, u, point, difference, step, _, _ = state
    shrink = min(0.5 + bend, 0.95)
    size = 1.2
    for k in range(3):
        s[k] = 0.0
    for count in range(1, 1001):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
        locate(net, knots, degrees, span, u, work, point)
        error = distance(x, point, difference)
        if error <= goal:
            return count, error
        times(own, difference, step)
        for k in range(3):
            s[k] += 0.5 * size if step[k] > 0 else -0.5 * size
        size *= shrink
        if size < 1e-17:
            break
    return 1000, np.inf


@compiled
def golden(
    lattice: Spline, cell: Cell, x: Array, s: Array, state: State, goal: float
) -> tuple[int, float]:
    """Golden section along each parameter in turn, on the length of r."""
    apart()
    net, knots, degrees = lattice
    span, middle, half, own, _ = cell
    work, u, point, difference, step, _, _ = state
    golden = 0.6180339887498949
    count = 0
    for _ in range(100):
        for k in range(3):
            u[k] = middle[k] + half[k] * s[k]
        locate(net, knots, degrees, span, u, work, point)
        count += 1
        error = distance(x, point, difference)
        if error <= goal:
            return count, error
        times(own, difference, step)
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
                    locate(net, knots, degrees, span, u, work, point)
                    distance(x, point, difference)
                    times(own, difference, step)
                    fa = step[0] ** 2 + step[1] ** 2 + step[2] ** 2
                    count += 1
                if fb < 0.0:
                    u[axis] = middle[axis] + half[axis] * b
                    locate(net, knots, degrees, span, u, work, point)
                    distance(x, point, difference)
                    times(own, difference, step)
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
def judge(
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
    apart()
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
        locate(net, knots, degrees, span, u, work, point)
        error = distance(x, point, difference)
    return error if error <= max(allowed, goal) else -1.0


@compiled
def search_for(turn: int, method: int, singular: bool) -> int:
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
def search(
    lattice: Spline, cell: Cell, centre: Array, x: Array, s: Array, state: State, goal: float,
    slack: float, method: int, singular: bool,
) -> tuple[float, int]:  # fmt: skip
    """Residual of the solution in a cell, -1 if there is none, and the evaluations spent.

    The parameters are left in `state`.
    """
    apart()
    difference, spent, error = state[3], 0, np.inf
    for turn in range(4):
        chosen = search_for(turn, method, singular)
        if chosen < 0:
            break
        distance(x, centre, difference)
        times(cell[3], difference, s)
        for k in range(3):
            s[k] = min(max(s[k], -1.0), 1.0)
        if chosen == NEWTON:
            used, error = newton(lattice, cell, x, s, state, goal)
        elif chosen == SECANT:
            used, error = secant(lattice, cell, x, s, state, goal)
        elif chosen == OCTREE:
            used, error = octree(lattice, cell, x, s, state, goal)
        else:
            used, error = golden(lattice, cell, x, s, state, goal)
        spent += used
        if error < np.inf:
            return judge(lattice, cell, x, s, state, error, goal, slack), spent
    return -1.0, spent
