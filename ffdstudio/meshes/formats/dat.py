"""Airfoil coordinates: a name and two columns, in the layout of Selig or of Lednicer.

1. Selig: from the trailing edge over the upper side and back along the lower one.
   Lednicer: each side from the leading edge, behind a line with the number of points of both.
   The counts tell: they are whole numbers that fit the number of lines. Without them two blocks
   that both run aft from one nose do.
2. A point that repeats its predecessor is no point of the contour, but stays in the file.
3. A contour that runs the other way, or begins at the nose, is turned; the file stays.
4. Several elements (of MSES, or contours that are whole each) become one marker each.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.dat_blocks import PointBlock, blocks_of, without_decimal_commas
from ffdstudio.meshes.formats.patch import TextTemplate, shortest
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Mesh

ELEMENT = "element {}"  # name of the marker of an element, counted from 1
LEAST = 5  # points of an element beside others
NEAR = 0.2  # of the length: how near to each other the ends of a whole contour are
FAR = 3.0  # extents: a first line as far outside is no point


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an airfoil file; see `read_mesh`."""
    source = Source(path, without_decimal_commas(data))
    blocks = blocks_of(source)
    if not blocks:
        raise source.failure("there are no coordinates in this airfoil file")
    upper = _counted(blocks)
    _check(source, blocks, upper is not None)
    points, orders = _orders(source, blocks, upper)
    lines = [np.stack([order[:-1], order[1:]], axis=1) for order in orders]
    names = [ELEMENT.format(k + 1) for k in range(len(lines))]
    markers = {n: {"line": part} for n, part in zip(names, lines, strict=True)}
    xyz = np.column_stack([points, np.zeros(len(points))])
    places = np.array([place for block in blocks for place in block.places], dtype=np.int64)
    template = TextTemplate(source.data, xyz, places[..., 0], places[..., 1])
    return Mesh(
        xyz, {"line": np.concatenate(lines)}, markers=markers if len(lines) > 1 else {},
        dimension=2, template=template,
    )  # fmt: skip


def _counted(blocks: list[PointBlock]) -> int | None:
    """Number of points of the upper side if the first line counts both sides; it is taken away."""
    count = sum(len(block.values) for block in blocks)
    upper, lower = blocks[0].values[0]
    if not (1 < upper < count and 1 < lower < count and upper + lower == count - 1):
        return None
    if upper != int(upper):
        return None
    del blocks[0].values[0], blocks[0].places[0]
    return int(upper)


def _check(source: Source, blocks: list[PointBlock], counted: bool) -> None:
    for block in blocks:
        for values, places in zip(block.values, block.places, strict=True):
            if not np.isfinite(values).all():
                raise source.error(places[0][0], "a coordinate is not a finite number")
    table = np.concatenate([block.xy for block in blocks])
    if len(table) < 3 or counted:
        return
    rest = table[1:]
    middle, extent = rest.mean(axis=0), np.ptp(rest, axis=0).max()
    if np.abs(table[0] - middle).max() > FAR * extent > 0:
        raise source.error(
            blocks[0].places[0][0][0],
            f"{table[0, 0]:g} and {table[0, 1]:g} are neither a point of the airfoil nor the "
            f"numbers of points of its sides, which are {len(rest)} together",
        )


def _orders(
    source: Source, blocks: list[PointBlock], upper: int | None
) -> tuple[Array, list[Indices]]:
    """All points, and the nodes of each element in Selig's order."""
    parts = [block.xy for block in blocks]
    points = np.concatenate(parts)
    ends = np.cumsum([0, *(len(part) for part in parts)])
    groups = [np.arange(a, b) for a, b in pairwise(ends)]
    if upper is None and len(parts) == 2 and _sides(*parts):
        upper = len(parts[0])
    if upper is not None:
        order = np.arange(len(points))
        groups = [np.concatenate([order[:upper][::-1], order[upper:]])]
    elif not _apart(source, blocks, parts):
        groups = [np.arange(len(points))]
    else:
        groups = _joined(groups, blocks)
    return points, [_turned(points, _distinct(source, points, order)) for order in groups]


def _sides(first: Array, second: Array) -> bool:
    """Whether two blocks both run aft from one nose."""
    extent = max(np.ptp(first[:, 0]), np.ptp(second[:, 0]))
    aft = all(
        side[0, 0] - side[:, 0].min() < 0.02 * extent < 0.5 * (side[-1, 0] - side[0, 0])
        for side in (first, second)
    )
    return bool(aft and np.abs(first[0] - second[0]).max() < 0.02 * extent)


def _apart(source: Source, blocks: list[PointBlock], parts: list[Array]) -> bool:
    """Whether blocks are elements; raises where text parts what is none."""
    if len(blocks) == 1:
        return False
    if any(block.parted for block in blocks) or all(map(_whole, parts)):
        return True
    for block in blocks[1:]:
        if block.before is not None:
            word = source.data[slice(*block.before.words[0])][:20].decode("latin-1")
            raise source.error(block.before.place, f"expected a number, found {word!r}")
    return False


def _joined(groups: list[Indices], blocks: list[PointBlock]) -> list[Indices]:
    """Blocks that a blank line alone parts belong together where lines of 999 part elements."""
    if not any(block.parted for block in blocks):
        return groups
    found: list[Indices] = []
    for group, block in zip(groups, blocks, strict=True):
        if block.parted or not found:
            found.append(group)
        else:
            found[-1] = np.concatenate([found[-1], group])
    return found


def _whole(points: Array) -> bool:
    """Whether points go round: enough of them, and the last one near the first."""
    extent = np.ptp(points, axis=0).max()
    return len(points) >= LEAST and bool(np.abs(points[0] - points[-1]).max() < NEAR * extent)


def _distinct(source: Source, points: Array, order: Indices) -> Indices:
    same = (points[order[1:]] == points[order[:-1]]).all(axis=1)
    order = order[np.append(True, ~same)]
    if len(order) < 3:
        raise source.failure("an airfoil needs at least three different points")
    return order


def _turned(points: Array, order: Indices) -> Indices:
    """The same contour from the trailing edge over the upper side and back."""
    x, y = points[order, 0], points[order, 1]
    if x @ np.roll(y, -1) < y @ np.roll(x, -1):
        order = order[::-1]
        x, y = x[::-1], y[::-1]
    low, extent = x.min(), np.ptp(x)
    if max(x[0], x[-1]) > low + 0.5 * extent:
        return order
    if (points[order[0]] == points[order[-1]]).all():
        order, x, y = order[:-1], x[:-1], y[:-1]
    aft = int(np.argmax(x))
    order, x, y = (np.roll(part, -aft) for part in (order, x, y))
    base = [abs(x[k] - x[0]) < 0.3 * abs(y[k] - y[0]) for k in (1, -1)]
    if base[0]:  # a blunt trailing edge: the contour is open there
        return np.roll(order, -1)
    return order if base[1] else np.append(order, order[0])


def write_new(mesh: Mesh, path: Path) -> None:
    """Write a mesh that is one contour of lines in Selig's layout."""
    lines = mesh.cells.get("line", np.empty((0, 2), dtype=np.int64))
    if not len(lines) or (lines[1:, 0] != lines[:-1, 1]).any():
        raise InputError(f"{path}: only one contour of lines can be written as an airfoil")
    xy = mesh.points[np.append(lines[:, 0], lines[-1, 1]), :2]
    rows = [" ".join(shortest(row)) for row in xy.tolist()]
    name = mesh.path.stem if mesh.path else path.stem
    write_bytes(path, "\n".join([name, *rows, ""]).encode())
