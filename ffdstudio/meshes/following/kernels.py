"""The loops over targets and sources, compiled by numba.

1. Items are clusters first and single sources behind them, in the order of the tree. A row of
   an item's field is a (3, 3) matrix and a (3,) vector about the item's place.
2. A box of targets gathers what it sees into rows of its own, so that the innermost loop runs
   over memory in order and its sums are vectorised.
3. A target belongs to one box and a box to one thread: bits do not depend on the cores. What is
   summed over boxes is summed in parts of a fixed number.
4. w(d) = area * (d^-3 + near^2 d^-5): Luke, Collins and Blades (2012), equation 8.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ffdstudio import compiling

compiled = partial(compiling.compiled, fastmath={"contract", "reassoc", "nsz", "arcp"})
FIELD = 12


@compiled
def gather(
    begin: np.ndarray,
    end: np.ndarray,
    children: np.ndarray,
    places: np.ndarray,
    areas: np.ndarray,
    items: np.ndarray,
    radii: np.ndarray,
) -> None:
    """Areas, places and radii of clusters, bottom up, from those of the sources."""
    for c in range(len(begin) - 1, -1, -1):
        total, x, y, z = 0.0, 0.0, 0.0, 0.0
        for i in range(begin[c], end[c]):
            total += areas[i]
            x += areas[i] * places[i, 0]
            y += areas[i] * places[i, 1]
            z += areas[i] * places[i, 2]
        items[c, 0], items[c, 1], items[c, 2], items[c, 3] = x / total, y / total, z / total, total
        far = 0.0
        for i in range(begin[c], end[c]):
            dx, dy, dz = (
                places[i, 0] - items[c, 0], places[i, 1] - items[c, 1], places[i, 2] - items[c, 2],
            )  # fmt: skip
            far = max(far, dx * dx + dy * dy + dz * dz)
        radii[c] = np.sqrt(far)


@compiled
def collect(
    children: np.ndarray, begin: np.ndarray, end: np.ndarray, items: np.ndarray, fields: np.ndarray
) -> None:
    """Fields of clusters, bottom up, from those of the sources: means by area."""
    clusters = len(begin)
    for c in range(clusters - 1, -1, -1):
        for k in range(12):
            fields[c, k] = 0.0
        leaf = children[c, 0] < 0
        count = end[c] - begin[c] if leaf else 2
        for i in range(count):
            child = clusters + begin[c] + i if leaf else children[c, i]
            share = items[child, 3] / items[c, 3]
            dx, dy, dz = (
                items[c, 0] - items[child, 0],
                items[c, 1] - items[child, 1],
                items[c, 2] - items[child, 2],
            )
            for k in range(3):
                a, b, d = fields[child, 3 * k], fields[child, 3 * k + 1], fields[child, 3 * k + 2]
                fields[c, 3 * k] += share * a
                fields[c, 3 * k + 1] += share * b
                fields[c, 3 * k + 2] += share * d
                fields[c, 9 + k] += share * (fields[child, 9 + k] + a * dx + b * dy + d * dz)


@compiled
def spread(
    children: np.ndarray, begin: np.ndarray, end: np.ndarray, items: np.ndarray, fields: np.ndarray
) -> None:
    """Transpose of `collect`: from derivatives by clusters' fields to those by the sources'."""
    clusters = len(begin)
    for c in range(clusters):
        leaf = children[c, 0] < 0
        count = end[c] - begin[c] if leaf else 2
        for i in range(count):
            child = clusters + begin[c] + i if leaf else children[c, i]
            share = items[child, 3] / items[c, 3]
            for k in range(3):
                g = fields[c, 9 + k]
                for j in range(3):
                    lever = items[c, j] - items[child, j]
                    fields[child, 3 * k + j] += share * (fields[c, 3 * k + j] + g * lever)
                fields[child, 9 + k] += share * g


@compiled
def seen(
    boxes: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    targets: np.ndarray,
    children: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    items: np.ndarray,
    radii: np.ndarray,
    near: float,
    opening: float,
    least: np.ndarray,
    counts: np.ndarray,
    out: np.ndarray,
) -> int:
    """Items that boxes see; returns their number, or -1 where `out` is too short.

    A cluster is opened if its radius is more than `opening` of its distance, or its weight by
    that share is more than `least` of the box.
    """
    clusters, found = len(children), 0
    stack = np.empty(256, dtype=np.int64)
    for number in range(len(boxes)):
        box = boxes[number]
        lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
        for t in range(begin[box], end[box]):
            for k in range(3):
                lo[k], hi[k] = min(lo[k], targets[t, k]), max(hi[k], targets[t, k])
        before, top = found, 1
        stack[0] = 0
        while top > 0:
            top -= 1
            c = stack[top]
            square = 0.0
            for k in range(3):
                off = max(lo[k] - items[c, k], items[c, k] - hi[k], 0.0)
                square += off * off
            distance = np.sqrt(square)
            ratio = radii[c] / distance if distance > 0 else np.inf
            if ratio <= opening:
                weight = items[c, 3] / (square * distance) * (1 + near / square)
                if weight * ratio <= least[box]:
                    if found == len(out):
                        return -1
                    out[found] = c
                    found += 1
                    continue
            if children[c, 0] >= 0:
                stack[top], stack[top + 1] = children[c, 0], children[c, 1]
                top += 2
                continue
            if found + last[c] - first[c] > len(out):
                return -1
            for i in range(first[c], last[c]):
                out[found] = clusters + i
                found += 1
        counts[number] = found - before
    return found


@compiled
def weights(
    boxes: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    targets: np.ndarray,
    starts: np.ndarray,
    seen: np.ndarray,
    items: np.ndarray,
    near: float,
    out: np.ndarray,
) -> None:
    """Sums of weights at the targets of boxes."""
    for box in boxes:
        for t in range(begin[box], end[box]):
            total = 0.0
            for i in range(starts[box], starts[box + 1]):
                c = seen[i]
                dx, dy, dz = (
                    targets[t, 0] - items[c, 0],
                    targets[t, 1] - items[c, 1],
                    targets[t, 2] - items[c, 2],
                )
                one = 1 / (dx * dx + dy * dy + dz * dz)
                total += items[c, 3] * one * np.sqrt(one) * (1 + near * one)
            out[t] = total


@compiled
def displace(
    boxes: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    targets: np.ndarray,
    starts: np.ndarray,
    seen: np.ndarray,
    items: np.ndarray,
    fields: np.ndarray,
    near: float,
    out: np.ndarray,
) -> None:
    """Displacements of the targets of boxes."""
    most = 0
    for box in boxes:
        most = max(most, starts[box + 1] - starts[box])
    rows = np.empty((16, most))
    for box in boxes:
        many = starts[box + 1] - starts[box]
        for i in range(many):
            c = seen[starts[box] + i]
            for k in range(4):
                rows[k, i] = items[c, k]
            for k in range(12):
                rows[4 + k, i] = fields[c, k]
        for t in range(begin[box], end[box]):
            x, y, z = targets[t, 0], targets[t, 1], targets[t, 2]
            total, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
            for i in range(many):
                dx, dy, dz = x - rows[0, i], y - rows[1, i], z - rows[2, i]
                one = 1 / (dx * dx + dy * dy + dz * dz)
                w = rows[3, i] * one * np.sqrt(one) * (1 + near * one)
                total += w
                sx += w * (rows[4, i] * dx + rows[5, i] * dy + rows[6, i] * dz + rows[13, i])
                sy += w * (rows[7, i] * dx + rows[8, i] * dy + rows[9, i] * dz + rows[14, i])
                sz += w * (rows[10, i] * dx + rows[11, i] * dy + rows[12, i] * dz + rows[15, i])
            out[t, 0], out[t, 1], out[t, 2] = sx / total, sy / total, sz / total


@compiled
def pull(
    boxes: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    targets: np.ndarray,
    starts: np.ndarray,
    seen: np.ndarray,
    items: np.ndarray,
    gradient: np.ndarray,
    near: float,
    out: np.ndarray,
) -> None:
    """Transpose of `displace`: adds the derivatives by the fields of items to `out`."""
    most = 0
    for box in boxes:
        most = max(most, starts[box + 1] - starts[box])
    w = np.empty(most)
    for box in boxes:
        many = starts[box + 1] - starts[box]
        for t in range(begin[box], end[box]):
            total = 0.0
            for i in range(many):
                c = seen[starts[box] + i]
                dx, dy, dz = (
                    targets[t, 0] - items[c, 0],
                    targets[t, 1] - items[c, 1],
                    targets[t, 2] - items[c, 2],
                )
                one = 1 / (dx * dx + dy * dy + dz * dz)
                w[i] = items[c, 3] * one * np.sqrt(one) * (1 + near * one)
                total += w[i]
            for i in range(many):
                c = seen[starts[box] + i]
                share = w[i] / total
                for k in range(3):
                    g = share * gradient[t, k]
                    out[c, 9 + k] += g
                    for j in range(3):
                        out[c, 3 * k + j] += g * (targets[t, j] - items[c, j])
