"""Compiled passes over cells: corners that changed sign, and those that could do so soon.

1. A corner is three vectors: its edges, or in a plane the normal and two edges. Its Jacobian is
   their determinant, summed in the order of `corners.jacobians`, so that the bits are the same.
2. In x + t d that is a cubic in t. Up to a time T it cannot come down further than its negative
   terms bring it: c0 + T min(c1, 0) + T^2 min(c2, 0) + T^3 min(c3, 0). With T the earliest end
   known so far nearly all cells are done with; the few that are left are solved exactly.
3. How large rounding may be takes square roots; it is asked for only where it could matter.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ffdstudio.aliases import AnyArray
from ffdstudio.compiling import compiled

bounding = partial(compiled, fastmath=True)  # for bounds, which have a margin for rounding
ROUNDING = 16 * np.finfo(np.float64).eps
FLIPPED, DOUBT, INSIDE = 1, 2, 4
SIMPLEX, HEXAHEDRON, WEDGE = 0, 1, 2


@compiled
def loaded(points: AnyArray, nodes: AnyArray, row: int, out: AnyArray) -> None:
    """Coordinates (nodes, 3) of one cell."""
    for i in range(nodes.shape[1]):
        for k in range(3):
            out[i, k] = points[nodes[row, i], k]


@compiled
def moves(nodes: AnyArray, row: int, moved: AnyArray) -> bool:
    """Whether a node of the cell moves."""
    found = False
    for i in range(nodes.shape[1]):
        found = found or moved[nodes[row, i]]
    return found


@compiled
def spanned(x: AnyArray, table: AnyArray, i: int, out: AnyArray) -> None:
    """Edges at a corner, as the last rows of `out`: in a plane the first one is the normal."""
    first = 3 - (table.shape[1] - 1)
    for j in range(1, table.shape[1]):
        for k in range(3):
            out[first + j - 1, k] = x[table[i, j], k] - x[table[i, 0], k]


@compiled
def triple(u: AnyArray, v: AnyArray, w: AnyArray) -> float:
    """Determinant of three vectors."""
    a = v[1] * w[2] - v[2] * w[1]
    b = v[2] * w[0] - v[0] * w[2]
    c = v[0] * w[1] - v[1] * w[0]
    return float(u[0] * a + u[1] * b + u[2] * c)


@compiled
def upward(e: AnyArray, out: AnyArray) -> None:
    """Unit normal of two edges at rest; of no length where they have none."""
    v, w = e[1], e[2]
    a = v[1] * w[2] - v[2] * w[1]
    b = v[2] * w[0] - v[0] * w[2]
    c = v[0] * w[1] - v[1] * w[0]
    size = np.sqrt(a * a + b * b + c * c)
    if size > 0:
        a, b, c = a / size, b / size, c / size
    out[0], out[1], out[2] = a, b, c


@compiled
def square(v: AnyArray) -> float:
    """Square of a length."""
    return float(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@compiled
def sign_of(value: float, e: AnyArray, plane: bool, x: AnyArray, count: int, largest: float) -> int:
    """Sign of a corner at rest: 0 where rounding of the coordinates may have made it.

    `largest` is the largest coordinate of all; the cell's own is looked for only in doubt.
    """
    total = square(e[1]) + square(e[2]) + (0.0 if plane else square(e[0]))
    if plane:
        total = 2 * np.sqrt(total)
    if abs(value) > 2 * ROUNDING * largest * total:  # more than any rounding of these lengths
        return 1 if value > 0 else -1
    own = 0.0
    for i in range(count):
        for k in range(3):
            own = max(own, abs(x[i, k]))
    b, c = np.sqrt(square(e[1])), np.sqrt(square(e[2]))
    if plane:
        noise = ROUNDING * own * (b + c)
    else:
        a = np.sqrt(square(e[0]))
        noise = ROUNDING * own * (a * b + b * c + c * a)
    if abs(value) <= noise:
        return 0
    return 1 if value > 0 else -1


@compiled
def raised(e: AnyArray, flat: bool, n: AnyArray) -> None:
    """Put the normal at rest before two edges."""
    if flat:
        n[0], n[1], n[2] = 0.0, 0.0, 1.0
    else:
        upward(e, n)
    for k in range(3):
        e[0, k] = n[k]


@compiled
def signed(
    begin: int,
    end: int,
    nodes: AnyArray,
    table: AnyArray,
    rest: AnyArray,
    flat: bool,
    largest: float,
    out: AnyArray,
    positive: AnyArray,
) -> None:
    """Signs (rows, corners) at rest, and whether the sum of the Jacobians of a row is positive."""
    plane = table.shape[1] == 3
    x, e, n = np.empty((nodes.shape[1], 3)), np.zeros((3, 3)), np.zeros(3)
    for row in range(begin, end):
        loaded(rest, nodes, row, x)
        total = 0.0
        for i in range(len(table)):
            spanned(x, table, i, e)
            if plane:
                raised(e, flat, n)
            value = triple(e[0], e[1], e[2])
            total += value
            out[row, i] = sign_of(value, e, plane, x, nodes.shape[1], largest)
        positive[row] = total > 0


@compiled
def crossed(v: AnyArray, w: AnyArray) -> tuple[float, ...]:
    """Vector product."""
    return v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]


@compiled
def falls(c0: float, c1: float, c2: float, c3: float, end: float) -> bool:
    """Whether the negative terms can outweigh c0 up to `end`, which may be infinite."""
    a, b, c = min(c1, 0.0), min(c2, 0.0), min(c3, 0.0)
    if end == np.inf:
        return a + b + c < 0
    # a little more than 1, or rounding could hide a root that lies at the end
    return c0 + 1.000001 * end * (a + end * (b + end * c)) <= 0


@compiled
def can_vanish(e: AnyArray, f: AnyArray, sign: int, end: float) -> bool:
    """Whether the determinant of e + t f could come down to zero for t up to `end`."""
    a, b, c = e[0], e[1], e[2]
    u, v, w = f[0], f[1], f[2]
    p0, p1, p2 = crossed(b, c)
    q0, q1, q2 = crossed(b, w)
    r0, r1, r2 = crossed(v, c)
    s0, s1, s2 = crossed(v, w)
    q0, q1, q2 = q0 + r0, q1 + r1, q2 + r2
    c0 = sign * (a[0] * p0 + a[1] * p1 + a[2] * p2)
    if c0 <= 0:
        return False  # inverted already: not counted again
    c1 = sign * (u[0] * p0 + u[1] * p1 + u[2] * p2 + a[0] * q0 + a[1] * q1 + a[2] * q2)
    c2 = sign * (u[0] * q0 + u[1] * q1 + u[2] * q2 + a[0] * s0 + a[1] * s1 + a[2] * s2)
    c3 = sign * (u[0] * s0 + u[1] * s1 + u[2] * s2)
    if not falls(c0, c1, c2, c3, end):
        return False
    d0, d1, d2 = np.sqrt(square(a)), np.sqrt(square(b)), np.sqrt(square(c))
    m0, m1, m2 = np.sqrt(square(u)), np.sqrt(square(v)), np.sqrt(square(w))
    low = ROUNDING / 4  # well below what counts as rounding, so that no doubt is lost
    c1 = 0.0 if abs(c1) <= low * (m0 * d1 * d2 + d0 * m1 * d2 + d0 * d1 * m2) else c1
    c2 = 0.0 if abs(c2) <= low * (d0 * m1 * m2 + m0 * d1 * m2 + m0 * m1 * d2) else c2
    c3 = 0.0 if abs(c3) <= low * (m0 * m1 * m2) else c3
    return bool(falls(c0, c1, c2, c3, end))


@bounding
def along(
    nodes: AnyArray, edges: AnyArray, axis: int, row: int, x: AnyArray, d: AnyArray, half: float
) -> tuple[float, ...]:
    """Mean of the four edges of a hexahedron along an axis, and how far they are from it.

    Edges are those of x + t d at the amplitude `half`; what they deviate by is never exceeded
    from 0 to twice that.
    """
    a, b = nodes[row, edges[axis, 0, 0]], nodes[row, edges[axis, 0, 1]]
    p0, p1, p2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    a, b = nodes[row, edges[axis, 1, 0]], nodes[row, edges[axis, 1, 1]]
    q0, q1, q2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    a, b = nodes[row, edges[axis, 2, 0]], nodes[row, edges[axis, 2, 1]]
    r0, r1, r2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    a, b = nodes[row, edges[axis, 3, 0]], nodes[row, edges[axis, 3, 1]]
    s0, s1, s2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    change = 0.0
    if half != 0.0:
        a, b = nodes[row, edges[axis, 0, 0]], nodes[row, edges[axis, 0, 1]]
        c0, c1, c2 = (
            half * (d[b, 0] - d[a, 0]),
            half * (d[b, 1] - d[a, 1]),
            half * (d[b, 2] - d[a, 2]),
        )
        p0, p1, p2, change = p0 + c0, p1 + c1, p2 + c2, c0 * c0 + c1 * c1 + c2 * c2
        a, b = nodes[row, edges[axis, 1, 0]], nodes[row, edges[axis, 1, 1]]
        c0, c1, c2 = (
            half * (d[b, 0] - d[a, 0]),
            half * (d[b, 1] - d[a, 1]),
            half * (d[b, 2] - d[a, 2]),
        )
        q0, q1, q2, change = q0 + c0, q1 + c1, q2 + c2, max(change, c0 * c0 + c1 * c1 + c2 * c2)
        a, b = nodes[row, edges[axis, 2, 0]], nodes[row, edges[axis, 2, 1]]
        c0, c1, c2 = (
            half * (d[b, 0] - d[a, 0]),
            half * (d[b, 1] - d[a, 1]),
            half * (d[b, 2] - d[a, 2]),
        )
        r0, r1, r2, change = r0 + c0, r1 + c1, r2 + c2, max(change, c0 * c0 + c1 * c1 + c2 * c2)
        a, b = nodes[row, edges[axis, 3, 0]], nodes[row, edges[axis, 3, 1]]
        c0, c1, c2 = (
            half * (d[b, 0] - d[a, 0]),
            half * (d[b, 1] - d[a, 1]),
            half * (d[b, 2] - d[a, 2]),
        )
        s0, s1, s2, change = s0 + c0, s1 + c1, s2 + c2, max(change, c0 * c0 + c1 * c1 + c2 * c2)
    m0, m1, m2 = (p0 + q0 + r0 + s0) / 4, (p1 + q1 + r1 + s1) / 4, (p2 + q2 + r2 + s2) / 4
    away = max(
        max(
            (p0 - m0) ** 2 + (p1 - m1) ** 2 + (p2 - m2) ** 2,
            (q0 - m0) ** 2 + (q1 - m1) ** 2 + (q2 - m2) ** 2,
        ),
        max(
            (r0 - m0) ** 2 + (r1 - m1) ** 2 + (r2 - m2) ** 2,
            (s0 - m0) ** 2 + (s1 - m1) ** 2 + (s2 - m2) ** 2,
        ),
    )
    return m0, m1, m2, np.sqrt(away) + np.sqrt(change)


@bounding
def against(
    nodes: AnyArray,
    edges: AnyArray,
    axis: int,
    row: int,
    x: AnyArray,
    d: AnyArray,
    half: float,
    n0: float,
    n1: float,
    n2: float,
    mean: float,
) -> float:
    """Most that an edge along an axis deviates from the mean one in the direction of a vector.

    `mean` is the product of the vector with the mean edge.
    """
    most = 0.0
    for k in range(4):
        a, b = nodes[row, edges[axis, k, 0]], nodes[row, edges[axis, k, 1]]
        on = (x[b, 0] - x[a, 0]) * n0 + (x[b, 1] - x[a, 1]) * n1 + (x[b, 2] - x[a, 2]) * n2
        change = 0.0
        if half != 0.0:
            change = (d[b, 0] - d[a, 0]) * n0 + (d[b, 1] - d[a, 1]) * n1 + (d[b, 2] - d[a, 2]) * n2
            change *= half
        most = max(most, abs(on + change - mean) + abs(change))
    return most


@bounding
def straight(
    nodes: AnyArray, edges: AnyArray, row: int, x: AnyArray, d: AnyArray, half: float
) -> int:
    """Sign of a hexahedron's Jacobian where the mean edges tell it for all of it, else 0.

    It is asked for all amplitudes from 0 to twice `half` of the displacement `d`; with a half of
    0 for the points alone. The determinant of the mean edges must exceed all that the largest
    deviations from these can take away (`bezier`, 3): first by their lengths alone, then with
    what is linear in them by the direction that counts.
    """
    a0, a1, a2, a = along(nodes, edges, 0, row, x, d, half)
    b0, b1, b2, b = along(nodes, edges, 1, row, x, d, half)
    c0, c1, c2, c = along(nodes, edges, 2, row, x, d, half)
    k = np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
    m = np.sqrt(b0 * b0 + b1 * b1 + b2 * b2)
    n = np.sqrt(c0 * c0 + c1 * c1 + c2 * c2)
    p0, p1, p2 = b1 * c2 - b2 * c1, b2 * c0 - b0 * c2, b0 * c1 - b1 * c0
    value = a0 * p0 + a1 * p1 + a2 * p2
    least = k * m * n
    lost = (k + a) * (m + b) * (n + c) - least
    if abs(value) <= 1.000001 * lost + 1e-9 * least:
        q0, q1, q2 = c1 * a2 - c2 * a1, c2 * a0 - c0 * a2, c0 * a1 - c1 * a0
        r0, r1, r2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
        lost = a * b * n + a * m * c + k * b * c + a * b * c
        lost += against(nodes, edges, 0, row, x, d, half, p0, p1, p2, value)
        lost += against(nodes, edges, 1, row, x, d, half, q0, q1, q2, value)
        lost += against(nodes, edges, 2, row, x, d, half, r0, r1, r2, value)
        if abs(value) <= 1.000001 * lost + 1e-9 * least:
            return 0
    return 1 if value > 0 else -1


@compiled
def wedge_terms(
    nodes: AnyArray, row: int, i: int, low: int, high: int, x: AnyArray, out: AnyArray
) -> None:
    """Three vectors whose determinant is a term of a wedge's Jacobian at the edge i up.

    The edges across are taken at the levels `low` and `high`, 0 at the bottom and 3 at the top.
    """
    for k in range(3):
        out[0, k] = x[nodes[row, i + 3], k] - x[nodes[row, i], k]
        out[1, k] = x[nodes[row, 1 + low], k] - x[nodes[row, low], k]
        out[2, k] = x[nodes[row, 2 + high], k] - x[nodes[row, high], k]


@compiled
def cubic(e: AnyArray, f: AnyArray, out: AnyArray, share: float) -> None:
    """Add the coefficients in t of the determinant of e + t f, times a share."""
    out[0] += share * triple(e[0], e[1], e[2])
    out[1] += share * (
        triple(f[0], e[1], e[2]) + triple(e[0], f[1], e[2]) + triple(e[0], e[1], f[2])
    )
    out[2] += share * (
        triple(e[0], f[1], f[2]) + triple(f[0], e[1], f[2]) + triple(f[0], f[1], e[2])
    )
    out[3] += share * triple(f[0], f[1], f[2])


@compiled
def level(
    nodes: AnyArray, row: int, x: AnyArray, d: AnyArray, far: float, e: AnyArray, f: AnyArray
) -> int:
    """Sign of a wedge's Jacobian where its Bezier coefficients tell it up to `far`, else 0."""
    found = 0
    c = np.empty(4)
    for i in range(3):
        for place in range(3):
            c[:] = 0.0
            for term in range(2):
                low = 3 if place == 2 or (place == 1 and term == 1) else 0
                high = 3 if place == 2 or (place == 1 and term == 0) else 0
                wedge_terms(nodes, row, i, low, high, x, e)
                if far > 0:
                    wedge_terms(nodes, row, i, low, high, d, f)
                cubic(e, f, c, 0.5)
            sign = 1 if c[0] > 0 else -1
            small = 1e-12 * abs(c[0])
            if c[0] == 0 or (found != 0 and sign != found):
                return 0
            if far > 0 and falls(sign * c[0] - small, sign * c[1], sign * c[2], sign * c[3], far):
                return 0
            found = sign
    return found


@compiled
def certain(
    kind: int,
    nodes: AnyArray,
    edges: AnyArray,
    row: int,
    x: AnyArray,
    d: AnyArray,
    far: float,
    e: AnyArray,
    f: AnyArray,
) -> int:
    """Sign of the Jacobian all over a cell and all the way to `far`, 0 where that is not known."""
    if kind == HEXAHEDRON and far < np.inf:
        return int(straight(nodes, edges, row, x, d, far / 2))
    if kind == WEDGE and far < np.inf:
        return int(level(nodes, row, x, d, far, e, f))
    return 0


@compiled
def volume(nodes: AnyArray, table: AnyArray, row: int, i: int, x: AnyArray) -> float:
    """Jacobian of a corner in space, written out."""
    o, p = nodes[row, table[i, 0]], nodes[row, table[i, 1]]
    q, r = nodes[row, table[i, 2]], nodes[row, table[i, 3]]
    x0, x1, x2 = x[o, 0], x[o, 1], x[o, 2]
    a0, a1, a2 = x[p, 0] - x0, x[p, 1] - x1, x[p, 2] - x2
    b0, b1, b2 = x[q, 0] - x0, x[q, 1] - x1, x[q, 2] - x2
    c0, c1, c2 = x[r, 0] - x0, x[r, 1] - x1, x[r, 2] - x2
    p0, p1, p2 = b1 * c2 - b2 * c1, b2 * c0 - b0 * c2, b0 * c1 - b1 * c0
    return float(a0 * p0 + a1 * p1 + a2 * p2)


@compiled
def flips(
    begin: int,
    end: int,
    nodes: AnyArray,
    table: AnyArray,
    rest: AnyArray,
    here: AnyArray,
    moved: AnyArray,
    flat: bool,
    largest: float,
    kind: int,
    edges: AnyArray,
    flags: AnyArray,
) -> None:
    """Flag the rows with a corner that changed sign or lost its volume, as `FLIPPED`.

    Others that are not known to be of one sign inside are flagged `INSIDE`.
    """
    plane, count = table.shape[1] == 3, nodes.shape[1]
    x, y = np.empty((count, 3)), np.empty((count, 3))
    e, f, n = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3)
    for row in range(begin, end):
        flags[row - begin] = 0
        if not moves(nodes, row, moved):
            continue
        if kind != SIMPLEX and certain(kind, nodes, edges, row, here, here, 0.0, e, f) == 0:
            flags[row - begin] = INSIDE
        if not plane:
            sure = True
            for i in range(len(table)):
                before, now = volume(nodes, table, row, i, rest), volume(nodes, table, row, i, here)
                sure = sure and before * now > 0
            if sure:
                continue
        loaded(rest, nodes, row, x)
        loaded(here, nodes, row, y)
        for i in range(len(table)):
            spanned(x, table, i, e)
            spanned(y, table, i, f)
            if plane:
                raised(e, flat, n)
                for k in range(3):
                    f[0, k] = n[k]
            before, now = triple(e[0], e[1], e[2]), triple(f[0], f[1], f[2])
            if before * now > 0 and abs(before) > 0:
                continue  # no rounding makes this a flip
            sign = sign_of(before, e, plane, x, count, largest)
            if sign != 0 and now * sign <= 0:
                flags[row - begin] = FLIPPED
                break


@compiled
def passes(
    nodes: AnyArray, table: AnyArray, row: int, i: int, x: AnyArray, d: AnyArray, end: float
) -> bool:
    """Whether a corner in space surely keeps its sign up to `end`; nearly all time goes here."""
    o, p = nodes[row, table[i, 0]], nodes[row, table[i, 1]]
    q, r = nodes[row, table[i, 2]], nodes[row, table[i, 3]]
    x0, x1, x2 = x[o, 0], x[o, 1], x[o, 2]
    y0, y1, y2 = d[o, 0], d[o, 1], d[o, 2]
    a0, a1, a2 = x[p, 0] - x0, x[p, 1] - x1, x[p, 2] - x2
    b0, b1, b2 = x[q, 0] - x0, x[q, 1] - x1, x[q, 2] - x2
    c0, c1, c2 = x[r, 0] - x0, x[r, 1] - x1, x[r, 2] - x2
    u0, u1, u2 = d[p, 0] - y0, d[p, 1] - y1, d[p, 2] - y2
    v0, v1, v2 = d[q, 0] - y0, d[q, 1] - y1, d[q, 2] - y2
    w0, w1, w2 = d[r, 0] - y0, d[r, 1] - y1, d[r, 2] - y2
    p0, p1, p2 = b1 * c2 - b2 * c1, b2 * c0 - b0 * c2, b0 * c1 - b1 * c0
    q0 = b1 * w2 - b2 * w1 + v1 * c2 - v2 * c1
    q1 = b2 * w0 - b0 * w2 + v2 * c0 - v0 * c2
    q2 = b0 * w1 - b1 * w0 + v0 * c1 - v1 * c0
    s0, s1, s2 = v1 * w2 - v2 * w1, v2 * w0 - v0 * w2, v0 * w1 - v1 * w0
    k0 = a0 * p0 + a1 * p1 + a2 * p2
    k1 = u0 * p0 + u1 * p1 + u2 * p2 + a0 * q0 + a1 * q1 + a2 * q2
    k2 = u0 * q0 + u1 * q1 + u2 * q2 + a0 * s0 + a1 * s1 + a2 * s2
    k3 = u0 * s0 + u1 * s1 + u2 * s2
    sign = 1.0 if k0 > 0 else -1.0
    lost = min(sign * k1, 0.0) + end * (min(sign * k2, 0.0) + end * min(sign * k3, 0.0))
    return bool(sign * k0 + 1.000001 * end * lost > 0)


@compiled
def doubtful(
    begin: int,
    end: int,
    nodes: AnyArray,
    table: AnyArray,
    rest: AnyArray,
    start: AnyArray,
    move: AnyArray,
    moved: AnyArray,
    flat: bool,
    same: bool,
    largest: float,
    far: float,
    kind: int,
    edges: AnyArray,
    flags: AnyArray,
) -> None:
    """Flag the rows with a corner that could lose its volume up to the amplitude `far`, `DOUBT`.

    Those that are not known to be of one sign inside all the way are flagged `INSIDE`.

    `same` says that it starts at rest, which need not be read twice then.
    """
    plane, count = table.shape[1] == 3, nodes.shape[1]
    r, x, d = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    e, f, g, n = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3)
    for row in range(begin, end):
        flags[row - begin] = 0
        if not moves(nodes, row, moved):
            continue
        if kind != SIMPLEX:
            if certain(kind, nodes, edges, row, start, move, far, f, g) != 0:
                continue
            flags[row - begin] = INSIDE
        if not plane and far < np.inf:
            sure = True
            for i in range(len(table)):
                sure = sure and passes(nodes, table, row, i, start, move, far)
            if sure:
                continue
        loaded(rest, nodes, row, r)
        if not same:
            loaded(start, nodes, row, x)
        loaded(move, nodes, row, d)
        for i in range(len(table)):
            spanned(r, table, i, e)
            spanned(r if same else x, table, i, f)
            spanned(d, table, i, g)
            if plane:
                raised(e, flat, n)
                for k in range(3):
                    f[0, k] = n[k]
            value = triple(e[0], e[1], e[2])
            if can_vanish(f, g, 1 if value > 0 else -1, far) and (
                sign_of(value, e, plane, r, count, largest) != 0
            ):
                flags[row - begin] |= DOUBT
                break
