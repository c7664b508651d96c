"""The first amplitude at which a hexahedron or wedge folds inside, its corners being good.

1. In x0 + t d the Jacobian is a polynomial of degree 2 in the cell's parameters and 3 in t. If
   all its Bezier coefficients over the cell and an interval of t are positive, the cell is
   valid throughout that interval; nearly all cells are done with after the first look.
2. Of the others the interval is halved, and the cell in space too; the earliest interval whose
   end is folded is bisected with the same test that counts inverted cells.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.measures.bezier import (
    coefficients_of,
    folded,
    halves,
    hex_edges,
)
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.vectors import gathered, length, pieces, triple

CUBIC = (
    np.array(  # values at 0, 1/3, 2/3, 1 -> Bezier coefficients
        [[6.0, 0, 0, 0], [-5, 18, -9, 2], [2, -9, 18, -5], [0, 0, 0, 6]]
    )
    / 6
)
LEVELS, DEPTH, STEPS = 7, 3, 60
FAR = 1024.0  # cell sizes a displacement is followed for if no corner sets an end


def first_fold(block: CellBlock, start: Array, move: Array, limit: float) -> float:
    """Amplitude below `limit` at which the first cell folds inside, else `limit`."""
    parts = [block[piece] for piece in pieces(len(block.nodes))]
    end = limit if np.isfinite(limit) else min(_reach(p, start, move) for p in parts)
    if not np.isfinite(end):
        return limit
    doubts = [part[~_steady(part, start, move, end)] for part in parts]
    nodes = np.concatenate([part.nodes for part in doubts])
    cells = np.concatenate([part.cells for part in doubts])
    doubt = CellBlock(block.type, nodes, cells)
    doubt = doubt[~folded(doubt, start)]  # folded from the start: nothing to lose
    found = _earliest(doubt, start, move, end)
    return limit if found >= end else float(found)


def _reach(block: CellBlock, start: Array, move: Array) -> float:
    """Amplitude that distorts the fastest cell by `FAR` times its size; infinite if none is."""
    size = np.ptp(gathered(start, block.nodes), axis=1).max(axis=0)
    speed = np.ptp(gathered(move, block.nodes), axis=1).max(axis=0)
    some = speed > np.finfo(np.float64).eps * np.abs(move).max(initial=0.0)
    return float((FAR * size[some] / speed[some]).min(initial=np.inf))


def _steady(block: CellBlock, start: Array, move: Array, end: float) -> np.ndarray:
    """Whether hexahedra are valid up to `end` by a bound of the determinant (`bezier`, 3)."""
    if block.type != "hexahedron":
        return np.zeros(len(block.nodes), dtype=bool)
    x, d = gathered(start, block.nodes), gathered(move, block.nodes) * (end / 2)
    means, bounds = [], []
    for edge, change in zip(hex_edges(x + d), hex_edges(d), strict=True):
        mean = edge.mean(axis=1)
        means.append(mean)
        away = length(edge - mean[:, None]) + length(change)
        bounds.append((length(mean), away.max(axis=0)))
    (a, da), (b, db), (c, dc) = bounds
    lost = (a + da) * (b + db) * (c + dc) - a * b * c
    result: np.ndarray = np.abs(triple(*means)) > lost
    return result


def _earliest(block: CellBlock, start: Array, move: Array, end: float) -> float:
    """Follow intervals (cell, a, b) from coarse to fine, then bisect the earliest fold."""
    cell = np.arange(len(block.nodes))
    a, b = np.zeros(len(cell)), np.full(len(cell), end)
    safe, bad = 0.0, end
    for _ in range(LEVELS):
        open_ones = np.flatnonzero(~_valid_between(block[cell], start, move, a, b))
        cell, a, b = cell[open_ones], a[open_ones], b[open_ones]
        if not len(cell):
            return bad
        lost = _folded_at(block[cell], start, move, b)
        bad = min(bad, b[lost].min(initial=np.inf))
        middle = (a + b) / 2
        cell, a, b = np.tile(cell, 2), np.append(a, middle), np.append(middle, b)
        early = a < bad
        cell, a, b = cell[early], a[early], b[early]
    cells = np.unique(cell)
    safe = a.min(initial=bad)
    for _ in range(STEPS):
        middle = (safe + bad) / 2
        lost = _folded_at(block[cells], start, move, np.full(len(cells), middle))
        safe, bad = (safe, middle) if lost.any() else (middle, bad)
    return bad


def _at(block: CellBlock, start: Array, move: Array, t: Array) -> Array:
    return gathered(start, block.nodes) + t * gathered(move, block.nodes)


def _folded_at(block: CellBlock, start: Array, move: Array, t: Array) -> np.ndarray:
    x = _at(block, start, move, t)
    own = np.arange(x[0].size).reshape(x.shape[1:]).T
    return folded(CellBlock(block.type, own, block.cells), x.reshape(3, -1).T)


def _valid_between(block: CellBlock, start: Array, move: Array, a: Array, b: Array) -> np.ndarray:
    """Whether all Bezier coefficients over the cells and the intervals [a, b] have one sign."""
    splits = 1 if block.type == "wedge" else DEPTH  # a wedge's are decided without
    of = coefficients_of(block.type)
    times = a + np.linspace(0, 1, 4)[:, None] * (b - a)
    values = np.stack([of(_at(block, start, move, t)) for t in times])
    boxes = np.moveaxis(np.tensordot(CUBIC, values, axes=(1, 0)), 0, -2)
    lead = tuple(range(boxes.ndim - 1))
    boxes = boxes * np.sign(boxes.sum(axis=lead))
    cell, valid = np.arange(len(a)), np.ones(len(a), dtype=bool)
    for depth in range(splits):
        left = np.flatnonzero((boxes <= 0).any(axis=lead))
        boxes, cell = boxes[..., left], cell[left]
        if depth < splits - 1 and len(left):
            boxes = halves(boxes)
            cell = np.tile(cell, boxes.shape[-1] // len(cell))
    valid[cell] = False
    return valid
