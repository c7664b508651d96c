"""Compiled search in the halves of a bent cell, made as far as a point needs them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled, whole
from ffdstudio.engine.inversion.cells import Bent
from ffdstudio.engine.inversion.cutting import DEEPEST, Pool, split
from ffdstudio.engine.inversion.searches import Cell

BUDGET = 256  # cells that are halved for one point; a fold would ask for ever more
ROOM = 1 << 22  # bytes of control points that are kept; what is thrown away can be made again
ONE_TO_ONE = 1.0  # bend below which a search is worth it


class Tree(NamedTuple):
    """Halves that are known, by the cell they come from."""

    pool: Pool
    children: NDArray[np.int64]  # (room, 2) rows in the pool, -1 if not made
    first: NDArray[np.int64]  # (bent cells,) their rows in the pool, -1 if not there
    used: NDArray[np.int64]  # (1,) rows in use
    stack: NDArray[np.int64]  # see `next_half`


apart = whole()


@compiled
def new_tree(bent: Bent) -> Tree:
    """No halves known yet; takes memory as it grows."""
    n0, n1, n2 = bent.control.shape[1:4]
    room = max(ROOM // (32 * n0 * n1 * n2), 2 * BUDGET + 2) if len(bent.control) else 1
    pool = Pool(
        np.empty((room, n0, n1, n2, 4)), np.empty((room, 3), np.int64), np.empty((room, 3)),
        np.empty((room, 3)), np.empty((room, 3)), np.empty((room, 3, 3)),
        np.empty((room, 4, 3)), np.empty(room), np.empty(room, np.int64),
        np.empty(room, np.int64),
    )  # fmt: skip
    return Tree(
        pool, np.empty((room, 2), np.int64), np.full(len(bent.control), -1),
        np.zeros(1, np.int64), np.empty(2 * DEEPEST + 4, np.int64),
    )  # fmt: skip


@compiled
def _root(tree: Tree, bent: Bent, place: int, cell: Cell) -> int:
    """Row of a bent cell in the pool."""
    row = int(tree.first[place])
    if row >= 0:
        return row
    row = int(tree.used[0])
    tree.used[0] += 1
    pool = tree.pool
    there, here = pool.control[row].ravel(), bent.control[place].ravel()  # views
    for i in range(len(here)):
        there[i] = here[i]
    for k in range(3):
        pool.span[row, k], pool.middle[row, k] = cell[0][k], cell[1][k]
        pool.half[row, k] = cell[2][k]
    pool.axis[row], pool.level[row] = bent.axis[place], bent.level[place]
    tree.children[row, 0] = -1
    tree.first[place] = row
    return row


@compiled
def _away(pool: Pool, row: int, x: Array, slack: float) -> float:
    """How far from the centre x is in the cell's own coordinates; infinite if not in its bounds."""
    box, inverse, largest = pool.box[row], pool.inverse[row], 0.0
    for r in range(3):
        if x[r] < box[0, r] - slack or x[r] > box[1, r] + slack:
            return np.inf
        y, reach = 0.0, 0.0
        for c in range(3):
            y += inverse[r, c] * (x[c] - pool.centre[row, c])
            reach += abs(inverse[r, c])
        if y < box[2, r] - reach * slack or y > box[3, r] + reach * slack:
            return np.inf
        largest = max(largest, abs(y))
    return largest


@compiled
def enter(tree: Tree, bent: Bent, place: int, cell: Cell, top: int) -> int:
    """Put a bent cell on the stack, to be halved; return the stack's height."""
    if tree.used[0] + 2 * BUDGET + 1 > len(tree.pool.bend):
        tree.used[0] = 0
        for i in range(len(tree.first)):
            tree.first[i] = -1
    tree.stack[top] = 2 * _root(tree, bent, place, cell) + 1
    return top + 1


@compiled
def next_half(
    tree: Tree, bent: Bent, top: int, budget: int, x: Array, slack: float, regular: float
) -> tuple[int, int, int]:
    """Row in the pool of the next cell to search in, -1 if there is none; stack, budget left.

    A number on the stack is twice the row, plus 1 if the cell was searched and is to be halved.
    """
    apart()
    pool, children, stack = tree.pool, tree.children, tree.stack
    while top > 0 and budget > 0:
        top -= 1
        row, searched = stack[top] // 2, stack[top] % 2
        if not searched:
            bend = pool.bend[row]
            last = bend <= regular or pool.level[row] >= DEEPEST
            if not last:
                stack[top] = 2 * row + 1
                top += 1
            if last or bend < ONE_TO_ONE:
                return row, top, budget
            continue
        budget -= 1
        if children[row, 0] < 0:
            left = tree.used[0]
            tree.used[0] += 2
            split(pool, row, left, left + 1, bent.rows)
            children[row, 0], children[row, 1] = left, left + 1
            children[left, 0], children[left + 1, 0] = -1, -1
        near, far = children[row, 0], children[row, 1]
        d_near, d_far = _away(pool, near, x, slack), _away(pool, far, x, slack)
        if d_far < d_near:
            near, far, d_near, d_far = far, near, d_far, d_near
        if d_far < np.inf:
            stack[top] = 2 * far
            top += 1
        if d_near < np.inf:
            stack[top] = 2 * near
            top += 1
    return -1, top, budget
