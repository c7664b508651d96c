"""Points sorted by cell, compiled: a counting sort in each chunk of rows.

The order is that of a stable sort, so it depends on the points alone. The threads write to
parts of their own, but for the marks of cells that were seen, where all write the same.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import AnyArray, Array, Indices, Mask
from ffdstudio.compiling import compiled


@compiled
def code_rows(
    first: int, last: int, parameters: Array, inside: Mask, lines: tuple[Array, ...],
    scales: Array, sizes: Indices, codes: AnyArray, seen: NDArray[np.uint8],
) -> None:  # fmt: skip
    """Number of the cell of each row, -1 outside; marks the cells that hold rows.

    Along a direction the place 2 j is the knot j itself, 2 j + 1 the span behind it.
    """
    for i in range(first, last):
        if not inside[i]:
            codes[i] = -1
            continue
        code = 0
        for k in range(len(lines)):
            line, u = lines[k], parameters[i, k]
            last = len(line) - 1
            # the last knot that is not above u: guessed as if the spans were equal, then sought
            low = min(int((u - line[0]) * scales[k]), last)
            if line[low] > u or (low < last and line[low + 1] <= u):
                low, high = 0, last
                while high > low:
                    middle = (low + high + 1) // 2
                    if line[middle] <= u:
                        low = middle
                    else:
                        high = middle - 1
            code = code * sizes[k] + (2 * low if line[low] == u else 2 * low + 1)
        codes[i] = code
        seen[code] = 1


@compiled
def count_cells(first: int, last: int, codes: AnyArray, numbers: Indices, counts: Indices) -> None:
    """How many rows of a chunk each cell holds; `numbers` tells the cell of a code."""
    for i in range(first, last):
        if codes[i] >= 0:
            counts[numbers[codes[i]]] += 1


@compiled
def place_rows(
    first: int, last: int, codes: AnyArray, numbers: Indices, at: Indices, parameters: Array,
    u: Array, order: AnyArray,
) -> None:  # fmt: skip
    """Put the rows of a chunk and their parameters where their cells begin (`at`, used up)."""
    for i in range(first, last):
        if codes[i] < 0:
            continue
        cell = numbers[codes[i]]
        j = at[cell]
        at[cell] = j + 1
        order[j] = i - first
        for k in range(len(u)):
            u[k, j] = parameters[i, k]


@compiled
def hold_in_box(
    first: int, last: int, points: Array, low: Array, high: Array, slack: float,
    parameters: Array, inside: Mask, residual: Array,
) -> None:  # fmt: skip
    """Parameters of points in a box whose map is the identity: see `Inversion`."""
    for i in range(first, last):
        away = 0.0
        for k in range(len(low)):
            held = min(max(points[i, k], low[k]), high[k])
            away += (points[i, k] - held) ** 2
            parameters[i, k] = held
        away = np.sqrt(away)
        inside[i] = away <= slack
        if inside[i]:
            residual[i] = away
        else:
            residual[i] = np.inf
            for k in range(len(low)):
                parameters[i, k] = np.nan
