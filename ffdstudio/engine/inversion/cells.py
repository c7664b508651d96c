"""Cells: pieces of the parametric domain in which the map is nearly affine.

1. A knot span of the net is a (rational) Bezier volume; see `bezier` for what is known of it.
2. Spans are halved until they are straight, but only so often at first: what a few thousand
   points cost. Cells that stay bent are halved further where a point needs it (`descent`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.engine import transfer
from ffdstudio.engine.inversion.bezier import sample_rows
from ffdstudio.engine.inversion.cutting import BEND, Pool, cut_all
from ffdstudio.engine.inversion.net import Net
from ffdstudio.engine.inversion.pieces import Pieces, pieces_of

AT_FIRST = 1000  # cells beyond one a span
ROOM = 1 << 25  # bytes of control points that may be in use beyond those of the spans


class SpanCells(NamedTuple):
    """Arrays with one row a cell."""

    span: NDArray[np.int64]  # (m, 3) index of the knot span in each direction
    middle: Array  # (m, 3) parameter of the centre
    half: Array  # (m, 3) half the extent in parameters
    centre: Array  # (m, 3) point of the centre
    inverse: Array  # (m, 3, 3) J^-1 by the cell's own coordinates
    low: Array  # (m, 3) bounds of y over the cell
    high: Array
    lower: Array  # (m, 3) bounds of the points of the cell
    upper: Array
    bend: Array  # (m,)


class Bent(NamedTuple):
    """What it takes to halve the cells that are still bent."""

    place: NDArray[np.int64]  # (m,) row of a cell in the arrays below, -1 for straight ones
    control: Array  # (k, p+1, q+1, r+1, 4)
    axis: NDArray[np.int64]  # (k,) direction to halve across
    level: NDArray[np.int64]  # (k,) halvings so far
    rows: Array  # see `sample_rows`


def cut(net: Net) -> tuple[SpanCells, Bent, Pieces | None]:
    """Cut a padded net into cells; also what its spans are as polynomials."""
    rows = sample_rows(net.degrees)
    pool, count = _spans(net)
    pieces = pieces_of(pool.control[:count], pool.middle[:count], pool.half[:count])
    count = cut_all(pool, count, rows)
    lower, upper, low, high = (pool.box[:count, k].copy() for k in range(4))
    cells = SpanCells(
        pool.span[:count].copy(), pool.middle[:count].copy(), pool.half[:count].copy(),
        pool.centre[:count].copy(), pool.inverse[:count].copy(), low, high, lower, upper,
        pool.bend[:count].copy(),
    )  # fmt: skip
    bent = np.flatnonzero(cells.bend > BEND)
    place = np.full(count, -1)
    place[bent] = np.arange(len(bent))
    if pieces is not None:
        pieces = pieces._replace(of_cell=_span_numbers(net, cells.span))
    return cells, Bent(place, pool.control[bent], pool.axis[bent], pool.level[bent], rows), pieces


def _span_numbers(net: Net, spans: Indices) -> Indices:
    """Number of the span of each cell, the last direction running fastest."""
    number = np.zeros(len(spans), np.int64)
    for k, u in enumerate(net.knots):
        ends = np.unique(u)
        place = np.searchsorted(ends, u[spans[:, k]])
        number = number * (len(ends) - 1) + place
    return number


def _spans(net: Net) -> tuple[Pool, int]:
    """Knot spans with their homogeneous Bezier points, in a pool with room for their halves."""
    control = np.concatenate([net.points * net.weights[..., None], net.weights[..., None]], -1)
    ends = []
    for axis, (u, p) in enumerate(zip(net.knots, net.degrees, strict=True)):
        values, counts = np.unique(u, return_counts=True)
        missing = np.repeat(values[1:-1], p - counts[1:-1])
        if missing.size:
            control = transfer.along(transfer.insertion(u, p, missing)[1], control, axis)
        ends.append(values)
    numbers = [len(v) - 1 for v in ends]
    shape = tuple(p + 1 for p in net.degrees)
    windows = np.lib.stride_tricks.sliding_window_view(control, shape, axis=(0, 1, 2))
    p, q, r = net.degrees
    pieces = np.moveaxis(windows[::p, ::q, ::r], 3, -1).reshape(-1, *shape, 4)
    index = np.stack(np.meshgrid(*map(np.arange, numbers), indexing="ij"), -1).reshape(-1, 3)
    low = np.stack([ends[k][index[:, k]] for k in range(3)], axis=1)
    high = np.stack([ends[k][index[:, k] + 1] for k in range(3)], axis=1)
    more = max(16, min(AT_FIRST, ROOM // pieces[0].nbytes))
    pool = Pool.empty(len(index) + more, shape)
    m = len(index)
    pool.control[:m], pool.middle[:m], pool.half[:m] = pieces, (low + high) / 2, (high - low) / 2
    for k in range(3):
        pool.span[:m, k] = np.searchsorted(net.knots[k], low[:, k], side="right") - 1
    return pool, m
