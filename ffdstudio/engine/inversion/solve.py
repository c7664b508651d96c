"""Inversion of many points: closed form where there is one, else the search in cells."""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.engine.inversion.affine import AffineMap
from ffdstudio.engine.inversion.found import Inversion
from ffdstudio.engine.inversion.in_frame import invert_in_frame
from ffdstudio.engine.inversion.net import Net, along_axes
from ffdstudio.errors import InputError
from ffdstudio.threads import for_each

if TYPE_CHECKING:
    from ffdstudio.engine.inversion.pieces import Pieces
    from ffdstudio.engine.inversion.prepare import Prepared
    from ffdstudio.engine.lattice import Lattice

METHODS = ("newton", "secant", "octree", "golden")
ROUNDING = 8e-15  # of the diagonal: no method can be asked for less than this
CHUNK = 8192


def invert(lattice: Lattice, points: Array, method: str, tolerance: float) -> Inversion:
    """Parametric coordinates of (n, 3) points; see `ffdstudio.embed`."""
    if method not in METHODS:
        raise InputError(f"method must be one of {', '.join(METHODS)}, got {method!r}")
    if not (isinstance(tolerance, Real) and 0 < tolerance < np.inf):
        raise InputError(f"the tolerance must be a positive number, got {tolerance}")
    if lattice.frame is not None:
        result = Inversion.empty(len(points), lattice.dimension)
        invert_in_frame(lattice, points, tolerance, result)
        return result
    result = Inversion.unfilled(len(points), lattice.dimension)
    flat = lattice.clamped()
    net = Net.of(flat)
    affine = AffineMap.of(net)
    if affine is not None:
        _invert_affine(affine, net, points, result)
    else:
        _search(flat, net, points, METHODS.index(method), tolerance, result)
    for k, direction in enumerate(lattice.directions):
        if direction.periodic:  # both ends are one place: it has one name
            u = result.parameters[:, k]
            u[u == direction.domain[1]] = direction.domain[0]
    return result


def _invert_affine(affine: AffineMap, net: Net, points: Array, result: Inversion) -> None:
    low, high = net.domain
    slack = net.slack

    if affine.identity and np.array_equal(net.axes, np.eye(3)[: net.dimension]):
        _hold_in_box(points, low, high, slack, result)
        return

    def chunk(part: slice) -> None:
        y = along_axes(points[part], net.axes)
        u, away, residual = affine.invert(y, low, high)
        result.inside[part] = inside = away <= slack
        result.parameters[part] = np.where(inside[:, None], u, np.nan)
        result.residual[part] = np.where(inside, residual, np.inf)

    for_each(chunk, _chunks(len(points)))


def _hold_in_box(points: Array, low: Array, high: Array, slack: float, result: Inversion) -> None:
    """The same, where a parameter is a coordinate."""
    from ffdstudio.engine import sorting

    def chunk(part: slice) -> None:
        sorting.hold_in_box(
            part.start, part.stop, points, low, high, slack, result.parameters, result.inside,
            result.residual,
        )  # fmt: skip

    for_each(chunk, _chunks(len(points)))


def _search(
    lattice: Lattice, net: Net, points: Array, method: int, tolerance: float, result: Inversion
) -> None:
    from ffdstudio.engine.inversion import kernels
    from ffdstudio.engine.inversion.prepare import prepared

    ready = prepared(lattice, net)
    goal = max(tolerance, ROUNDING) * net.diagonal

    def search(x: Array, own: Inversion) -> None:
        kernels.invert_points(
            method, *ready.spline, ready.frames, ready.bins, x, ready.axes, ready.centre, goal,
            ready.slack, ready.regular, ready.longest, ready.bent, *own,
        )  # fmt: skip

    def chunk(part: slice) -> None:
        own = result.part(part)
        if METHODS[method] == "newton" and ready.pieces is not None:
            left = _in_blocks(ready, ready.pieces, points[part], goal, own)
            if len(left):
                rest = Inversion.unfilled(len(left), net.dimension)
                search(points[part][left], rest)
                own.put(left, rest)
        else:
            search(points[part], own)
        found = own.parameters
        np.clip(found + ready.start, *net.domain, out=found)  # rounded, it may pass the last knot

    for_each(chunk, _chunks(len(points)))


def _in_blocks(
    ready: Prepared, pieces: Pieces, points: Array, goal: float, own: Inversion
) -> Indices:
    """Fill what Newton finds in whole blocks of points; return the rows that are left."""
    from ffdstudio.engine.inversion import blocks

    count = len(points)
    x, t, error = np.empty((count, 3)), np.zeros((count, 3)), np.empty(count)
    span, order = np.empty(count, np.int64), np.empty(count, np.int64)
    starts = np.empty(len(pieces.origin) + 1, np.int64)
    q, r = ready.spline[2][1:]
    blocks.begin(
        points, ready.axes, ready.centre, ready.frames, ready.bins, pieces, ready.slack,
        ready.longest, x, t, span,
    )  # fmt: skip
    blocks.sort_by_span(span, starts, order)
    own.iterations[:] = 0
    blocks.newton_in_blocks(starts, order, x, t, pieces, q, r, goal, error, own.iterations)
    blocks.end(error, t, span, pieces, own.parameters, own.inside, own.residual)
    return np.flatnonzero(~own.inside & (span >= 0))


def _chunks(count: int) -> list[slice]:
    return [slice(first, min(first + CHUNK, count)) for first in range(0, count, CHUNK)]
