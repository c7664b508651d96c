"""Compiled inversion of many points: find the cells of each and search inside them.

Coordinates are relative to the net's centre, so that far-away geometry loses no digits. What
a point receives depends on the point and the net alone, never on other points: halves that were
made for one are kept for the next and change nothing but the time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.compiling import compiled
from ffdstudio.engine.inversion.descent import BUDGET, enter, new_tree, next_half
from ffdstudio.engine.inversion.evaluation import Degrees, Index, Knots
from ffdstudio.engine.inversion.searches import search


@compiled
def candidates(x: Array, bins: Any, cells: Any, slack: float, passed: Array, found: Index) -> int:
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
def invert_points(
    method: int, net: Array, knots: Knots, degrees: Degrees, cells: Any, bins: Any, points: Array,
    axes: Array, centre: Array, goal: float, slack: float, regular: float, longest: int,
    bent: Any, parameters: Array, inside: NDArray[np.bool_], residual: Array,
    iterations: NDArray[np.int16],
) -> None:  # fmt: skip
    """Fill the last four arrays for each point: see `Inversion`.

    All cells that may hold a point have their turn before one that is bent is halved.
    """
    spans, middles, halves, centres, inverses, _, _, bends = cells
    work = np.empty((6, max(degrees[0], degrees[1], degrees[2]) + 1))
    u, point, difference, step = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    state = (work, u, point, difference, step, np.empty((3, 3)), np.empty((3, 3)))
    lattice = (net, knots, degrees)
    x, s = np.empty(3), np.empty(3)
    tree = new_tree(bent)
    pool = tree.pool
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
        count = candidates(x, bins, cells, slack, order, found)
        error, spent, slot, top, budget = -1.0, 0, 0, 0, BUDGET
        while error < 0.0:
            if slot < count:
                c = found[slot]
                cell = (spans[c], middles[c], halves[c], inverses[c], bends[c])
                middle = centres[c]
            else:  # all have had their turn: halve those that are bent
                row, top, budget = next_half(tree, bent, top, budget, x, slack, regular)
                if row < 0:
                    if slot >= 2 * count or budget == 0:
                        break
                    c = found[slot - count]
                    if bent.place[c] >= 0:
                        cell = (spans[c], middles[c], halves[c], inverses[c], bends[c])
                        top = enter(tree, bent, bent.place[c], cell, top)
                    slot += 1
                    continue
                cell = (
                    pool.span[row], pool.middle[row], pool.half[row], pool.inverse[row],
                    pool.bend[row],
                )  # fmt: skip
                middle = pool.centre[row]
            singular = cell[4] > regular
            error, used = search(lattice, cell, middle, x, s, state, goal, slack, method, singular)
            spent += used
            if slot < count:
                slot += 1
        iterations[n] = min(spent, 32767)
        if error >= 0.0:
            inside[n], residual[n] = True, error
            for k in range(dimension):
                parameters[n, k] = u[k]
