"""Compiled cutting of Bezier volumes into cells in which the map is nearly affine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled, whole
from ffdstudio.engine.inversion.bezier import SAMPLES, best_cut, bounds, frame, halve, slopes

BEND = 0.4  # up to which a cell counts as straight; below 1 a search in it cannot go wrong
DEEPEST = 20  # halvings; only folds and singular points of the net get there


class Pool(NamedTuple):
    """Arrays with one row a cell, of which a part is in use."""

    control: Array  # (m, p+1, q+1, r+1, 4) homogeneous Bezier points
    span: NDArray[np.int64]  # (m, 3) index of the knot span in each direction
    middle: Array  # (m, 3) parameter of the centre
    half: Array  # (m, 3) half the extent in parameters
    centre: Array  # (m, 3) point of the centre
    inverse: Array  # (m, 3, 3) J^-1 by the cell's own coordinates
    box: Array  # (m, 4, 3) bounds of the points of the cell, and of y = J^-1 (x - centre)
    bend: Array  # (m,)
    axis: NDArray[np.int64]  # (m,) direction to halve the cell across
    level: NDArray[np.int64]  # (m,) halvings so far

    @classmethod
    def empty(cls, size: int, shape: tuple[int, ...]) -> Pool:
        """Room for `size` cells of (p+1, q+1, r+1) control points."""
        return cls(
            np.empty((size, *shape, 4)), np.empty((size, 3), np.int64), np.empty((size, 3)),
            np.empty((size, 3)), np.empty((size, 3)), np.empty((size, 3, 3)),
            np.empty((size, 4, 3)), np.empty(size), np.zeros(size, np.int64),
            np.zeros(size, np.int64),
        )  # fmt: skip


apart = whole()


@compiled
def measure(pool: Pool, c: int, rows: Array) -> None:
    """Fill what follows from the control points of a cell."""
    apart()
    control, box = pool.control[c], pool.box[c]
    regular = frame(control, rows, pool.centre[c], pool.inverse[c])
    bounds(control, pool.centre[c], pool.inverse[c], box)
    if regular:
        values = np.empty((SAMPLES, SAMPLES, SAMPLES, 9))
        bend = slopes(control, rows, pool.inverse[c], values)
        pool.bend[c] = bend if bend == bend else np.inf
        pool.axis[c] = best_cut(values)
    else:  # no frame of its own: any point in its bounds may be in it
        for k in range(3):
            box[2, k], box[3, k] = -np.inf, np.inf
        pool.bend[c], pool.axis[c] = np.inf, pool.level[c] % 3


@compiled
def split(pool: Pool, parent: int, left: int, right: int, rows: Array) -> None:
    """Put the halves of a cell into two rows, of which the first may be its own."""
    apart()
    axis, level = pool.axis[parent], pool.level[parent] + 1
    halve(pool.control[parent], axis, pool.control[left], pool.control[right])
    for child in (right, left):
        for k in range(3):
            pool.span[child, k] = pool.span[parent, k]
            pool.middle[child, k] = pool.middle[parent, k]
            pool.half[child, k] = pool.half[parent, k]
        pool.level[child] = level
    half = 0.5 * pool.half[right, axis]
    for child in (left, right):
        pool.half[child, axis] = half
        pool.middle[child, axis] += half if child == right else -half
        measure(pool, child, rows)


@compiled
def cut_all(pool: Pool, count: int, rows: Array) -> int:
    """Measure `count` cells and halve the bent ones, level by level, while there is room."""
    for c in range(count):
        measure(pool, c, rows)
    known = 0
    while known < count:
        known = count
        for c in range(known):
            if count < len(pool.bend) and pool.bend[c] > BEND and pool.level[c] < DEEPEST:
                split(pool, c, c, count, rows)
                count += 1
    return count
