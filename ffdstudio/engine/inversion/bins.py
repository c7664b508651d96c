"""Bins: a uniform grid over space that lists the cells which reach into each of its boxes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.inversion.cells import SpanCells

MOST = 64  # a direction


class Bins(NamedTuple):
    """Cells of bin b: ``cells[first[b] : first[b + 1]]``."""

    lower: Array
    upper: Array
    per_length: Array
    shape: NDArray[np.int64]
    first: NDArray[np.int64]
    cells: NDArray[np.int64]


def sort_into_bins(cells: SpanCells, slack: float) -> Bins:
    """Bins of cells whose bounds are widened by `slack`."""
    lower, upper = cells.lower - slack, cells.upper + slack
    low, high = lower.min(axis=0), upper.max(axis=0)
    extent = high - low
    # about as many bins as bounds of typical size fit, so that a list stays short
    typical = np.median(upper - lower, axis=0)
    shape = np.clip(np.ceil(2 * extent / typical), 1, MOST).astype(np.int64)
    per_length = shape / extent
    start = np.clip(((lower - low) * per_length).astype(np.int64), 0, shape - 1)
    stop = np.clip(((upper - low) * per_length).astype(np.int64), 0, shape - 1) + 1
    size = stop - start
    owner = np.repeat(np.arange(len(size)), size.prod(axis=1))
    rank = np.arange(len(owner)) - np.repeat(
        np.concatenate([[0], np.cumsum(size.prod(axis=1))[:-1]]), size.prod(axis=1)
    )
    k = start[owner, 2] + rank % size[owner, 2]
    j = start[owner, 1] + rank // size[owner, 2] % size[owner, 1]
    i = start[owner, 0] + rank // (size[owner, 2] * size[owner, 1])
    place = (i * shape[1] + j) * shape[2] + k
    first = np.zeros(shape.prod() + 1, dtype=np.int64)
    np.cumsum(np.bincount(place, minlength=shape.prod()), out=first[1:])
    return Bins(low, high, per_length, shape, first, owner[np.argsort(place, kind="stable")])
