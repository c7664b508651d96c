"""Airfoil coordinates: a name and two columns, in the layout of Selig or of Lednicer.

1. Selig: from the trailing edge over the upper side and back along the lower one.
   Lednicer: a line with the number of points of both sides, then each side from the leading
   edge. The counts tell: they are whole numbers that fit the number of lines.
2. A point that repeats its predecessor is no point of the contour, but stays in the file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import Rows, numbers, read_rows
from ffdstudio.meshes.formats.patch import TextTemplate, shortest
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import Array, Indices


def _is_pair(line: bytes) -> bool:
    found = numbers(line, np.float64) if line.strip() else None
    return found is not None and len(found) == 2


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an airfoil file; see `read_mesh`."""
    source = Source(path, data)
    begin = source.line_end(len(data) - len(data.lstrip()))
    if _is_pair(data[:begin]):  # no name
        begin = 0
    rows = read_rows(source, begin, len(data), spans=True)
    odd = np.flatnonzero(rows.widths != 2)
    if len(odd):
        raise source.error(int(rows.places[odd[0]]), "an airfoil has two coordinates a line")
    if not np.isfinite(rows.values).all():
        bad = int(np.flatnonzero(~np.isfinite(rows.values))[0])
        raise source.error(int(rows.starts[bad]), "a coordinate is not a finite number")
    return _mesh(source, rows)


def _mesh(source: Source, rows: Rows) -> Mesh:
    table = rows.values.reshape(-1, 2)
    if not len(table):
        raise source.failure("there are no coordinates in this airfoil file")
    upper = _lednicer(table)
    first = 0 if upper is None else 1
    points = np.column_stack([table[first:], np.zeros(len(table) - first)])
    order = np.arange(len(points))
    if upper is not None:
        order = np.concatenate([order[:upper][::-1], order[upper:]])
    order = _without_repeats(points, order)
    if len(order) < 3:
        raise source.failure("an airfoil needs at least three different points")
    starts, ends = rows.starts.reshape(-1, 2)[first:], rows.ends.reshape(-1, 2)[first:]
    lines = np.stack([order[:-1], order[1:]], axis=1)
    template = TextTemplate(source.data, points, starts, ends)
    return Mesh(points, {"line": lines}, dimension=2, template=template)


def _lednicer(table: Array) -> int | None:
    """Number of points of the upper side if the first line counts both sides."""
    if len(table) < 2:
        return None
    upper, lower = table[0]
    whole = upper == int(upper) and lower == int(lower)
    fits = whole and upper > 1 and lower > 1 and upper + lower == len(table) - 1
    return int(upper) if fits else None


def _without_repeats(points: Array, order: Indices) -> Indices:
    same = (points[order[1:]] == points[order[:-1]]).all(axis=1)
    return order[np.append(True, ~same)]


def write_new(mesh: Mesh, path: Path) -> None:
    """Write a mesh that is one contour of lines in Selig's layout."""
    lines = mesh.cells.get("line", np.empty((0, 2), dtype=np.int64))
    if not len(lines) or (lines[1:, 0] != lines[:-1, 1]).any():
        raise InputError(f"{path}: only one contour of lines can be written as an airfoil")
    xy = mesh.points[np.append(lines[:, 0], lines[-1, 1]), :2]
    rows = [" ".join(shortest(row)) for row in xy.tolist()]
    name = mesh.path.stem if mesh.path else path.stem
    write_bytes(path, "\n".join([name, *rows, ""]).encode())
