"""Cells: pieces of the parametric domain in which the map is nearly affine.

1. A knot span of the net is a (rational) Bezier volume. With positive weights it lies in
   the convex hull of its control points, so bounds taken from these are safe: a point
   outside the bounds of every cell is outside the lattice.
2. In a cell's own coordinates s in [-1, 1], y = J^-1 (x - centre) is nearly s. `bend`
   says how far dy/ds is from the identity: the largest row sum of the difference over a
   grid of samples, with a margin for what lies between them. Below 1 the map is one-to-one
   in the cell and a search from anywhere in it ends at the only solution; cells are halved
   until bend <= 0.4.
3. A cell is halved across the direction that makes it straightest (`_best_cut`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import transfer
from ffdstudio.engine.inversion.net import Net

BEND = 0.4
SAMPLES = np.linspace(0.0, 1.0, 4)  # in each direction of a cell
MARGIN = 1.25
MOST_CELLS = 20_000
DEEPEST = 20  # halvings; only folds and singular points of the net get there


class Cells(NamedTuple):
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


def cut(net: Net) -> Cells:
    """Cut a padded net into cells."""
    cells, control = _spans(net)
    done: list[Cells] = []
    finished = level = 0
    while len(control):
        cells, worst = _measured(cells, control)
        split = cells.bend > BEND
        if level == DEEPEST or finished + len(control) + split.sum() > MOST_CELLS:
            split[:] = False
        finished, level = finished + int((~split).sum()), level + 1
        done.append(_rows(cells, ~split))
        cells, control = _halved(_rows(cells, split), control[split], worst[split])
    return Cells(*(np.concatenate(parts) for parts in zip(*done, strict=True)))


def _rows(cells: Cells, chosen: NDArray[np.bool_]) -> Cells:
    return Cells(*(part[chosen] for part in cells))  # type: ignore[arg-type]


def _spans(net: Net) -> tuple[Cells, Array]:
    """Knot spans with their homogeneous Bezier points, (m, p+1, q+1, r+1, 4)."""
    control = np.concatenate([net.points * net.weights[..., None], net.weights[..., None]], -1)
    ends = []
    for axis, (u, p) in enumerate(zip(net.knots, net.degrees, strict=True)):
        values, counts = np.unique(u, return_counts=True)
        missing = np.repeat(values[1:-1], p - counts[1:-1])
        if missing.size:
            control = transfer.along(transfer.insertion(u, p, missing)[1], control, axis)
        ends.append(values)
    numbers = [len(v) - 1 for v in ends]
    index = np.stack(np.meshgrid(*map(np.arange, numbers), indexing="ij"), -1).reshape(-1, 3)
    pieces = np.stack([_piece(control, at, net.degrees) for at in index])
    low = np.stack([ends[k][index[:, k]] for k in range(3)], axis=1)
    high = np.stack([ends[k][index[:, k] + 1] for k in range(3)], axis=1)
    span = np.stack(
        [np.searchsorted(net.knots[k], low[:, k], side="right") - 1 for k in range(3)], axis=1
    )
    m = len(index)
    none = np.empty((m, 3))
    cells = Cells(
        span, (low + high) / 2, (high - low) / 2, none, np.empty((m, 3, 3)), none, none, none, none,
        np.empty(m),
    )  # fmt: skip
    return cells, pieces


def _piece(control: Array, at: NDArray[np.int64], degrees: tuple[int, ...]) -> Array:
    return control[tuple(slice(i * p, i * p + p + 1) for i, p in zip(at, degrees, strict=True))]


def _measured(cells: Cells, control: Array) -> tuple[Cells, NDArray[np.intp]]:
    """Cells with centre, frame, bounds and bend; and the direction to halve each across."""
    flat = (control[..., :3] / control[..., 3:]).reshape(len(control), -1, 3)
    centre, jacobian = (part[:, 0, 0, 0] for part in _sampled(control, np.array([0.5])))
    inverse = _inverse(jacobian)
    local = np.einsum("mrc,mnc->mnr", inverse, flat - centre[:, None])
    slopes = np.einsum("mrc,mijkcd->mijkrd", inverse, _sampled(control, SAMPLES)[1])
    bend = MARGIN * np.abs(slopes - np.eye(3)).sum(axis=5).max(axis=(1, 2, 3, 4))
    bend[np.isnan(bend)] = np.inf
    # a singular cell has no frame of its own: any point in its bounds may be in it
    low = np.where(np.isnan(local), -np.inf, local).min(axis=1)
    high = np.where(np.isnan(local), np.inf, local).max(axis=1)
    cells = cells._replace(
        centre=centre, inverse=np.nan_to_num(inverse), low=low, high=high,
        lower=flat.min(axis=1), upper=flat.max(axis=1), bend=bend,
    )  # fmt: skip
    return cells, _best_cut(slopes)


def _best_cut(slopes: Array) -> NDArray[np.intp]:
    """Direction across which to halve each cell.

    Change along k of the slope of y_r by s_d goes with h_d h_k / h_r, h being the extents of
    the cell: halving it in one direction makes some of that smaller and some larger.
    """
    along = [np.ptp(slopes, axis=k + 1).max(axis=(1, 2)) for k in range(3)]
    change = np.nan_to_num(np.stack(along, axis=-1))
    halved = np.where(np.eye(3, dtype=bool), 0.5, 1.0)
    after = np.einsum("mrdk,ar,ad,ak->ma", change, 1 / halved, halved, halved)
    result: NDArray[np.intp] = np.argmin(after, axis=1)
    return result


def _sampled(control: Array, at: Array) -> tuple[Array, Array]:
    """Points (m, g, g, g, 3) and Jacobians by s (m, g, g, g, 3, 3) of Bezier volumes."""
    value = _combined(control, at, -1)
    n, w = value[..., :3], value[..., 3:]
    point = n / w
    slopes = [_combined(control, at, axis) for axis in range(3)]
    columns = [(d[..., :3] - d[..., 3:] * point) / w for d in slopes]
    return point, np.stack(columns, axis=-1)


def _combined(control: Array, at: Array, derivative: int) -> Array:
    """Values, or derivatives by s in one direction, on the grid of `at` in each direction."""
    for axis in range(3):
        degree = control.shape[axis + 1] - 1
        if axis == derivative:
            control = np.diff(control, axis=axis + 1) * (degree / 2)
            degree -= 1
        rows = np.stack([_bernstein(degree, t) for t in at])
        control = np.moveaxis(np.tensordot(control, rows, axes=(axis + 1, 1)), -1, axis + 1)
    return control


def _bernstein(degree: int, t: float) -> Array:
    row = np.array([1.0])
    for _ in range(degree):
        row = np.convolve(row, [1 - t, t])
    return row


def _inverse(jacobian: Array) -> Array:
    """Inverse; of a singular matrix NaN, which makes the bend infinite."""
    scale = np.linalg.norm(jacobian, axis=(1, 2))
    regular = np.abs(np.linalg.det(jacobian)) > 1e-30 * scale**3
    out = np.full(jacobian.shape, np.nan)
    out[regular] = np.linalg.inv(jacobian[regular])
    return out


def _halved(cells: Cells, control: Array, worst: NDArray[np.intp]) -> tuple[Cells, Array]:
    """Both halves of every cell, cut across its own worst direction."""
    parts, nets = [], []
    for axis in range(3):
        chosen = worst == axis
        mine = _rows(cells, chosen)
        for side, net in zip((-1, 1), _casteljau(control[chosen], axis), strict=True):
            step = np.zeros(3)
            step[axis] = 0.5
            parts.append(
                mine._replace(
                    middle=mine.middle + side * step * mine.half, half=mine.half * (1 - step)
                )
            )
            nets.append(net)
    return Cells(*(np.concatenate(p) for p in zip(*parts, strict=True))), np.concatenate(nets)


def _casteljau(control: Array, axis: int) -> tuple[Array, Array]:
    """Bezier points of both halves in one direction."""
    rows = np.moveaxis(control, axis + 1, 0)
    left, right = [rows[0]], [rows[-1]]
    while len(rows) > 1:
        rows = 0.5 * (rows[1:] + rows[:-1])
        left.append(rows[0])
        right.append(rows[-1])
    return tuple(np.moveaxis(np.stack(half), 0, axis + 1) for half in (left, right[::-1]))  # type: ignore[return-value]
