"""AFLR3 meshes (.ugrid), ASCII and binary of both byte orders.

1. The name tells the layout: ``.b8.ugrid`` big end first with doubles, ``.lb4.ugrid`` little
   end first with singles, ``.r8.ugrid`` and ``.lr8.ugrid`` with Fortran's record marks; a plain
   ``.ugrid`` is text.
2. Counts, coordinates, triangles, quads, their boundary numbers, tets, pyramids, prisms,
   hexahedra follow each other. Nodes count from 1; the third node of a pyramid is its apex.

Source: D. Marcum, "AFLR3 mesh and data formats" (UGRID).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells

TYPES = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
ORDER = {"pyramid": [0, 3, 4, 1, 2]}
_LAYOUT = re.compile(r"\.(l?)([br])([48])\.ugrid$", re.I)


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an AFLR3 mesh; see `read_mesh`. Boundary numbers become markers."""
    source = Source(path, data)
    layout = _LAYOUT.search(path.name)
    if layout is None:
        return _Text(source).mesh()
    order = "<" if layout[1] else ">"
    return _Binary(source, order, int(layout[3]), layout[2].lower() == "r").mesh()


class _Reader:
    """What both layouts have in common."""

    def __init__(self, source: Source) -> None:
        self.source = source

    def template(self, count: int) -> TextTemplate | BinaryTemplate:
        """Coordinates of the nodes, which come next."""
        raise NotImplementedError

    def integers(self, count: int) -> Indices:
        """Whole numbers that come next."""
        raise NotImplementedError

    def mesh(self) -> Mesh:
        """Read the file from its begin to its end."""
        counts = self.integers(7)
        if (counts < 0).any():
            raise self.source.failure("a negative count at the begin of the file")
        nodes, *many = counts.tolist()
        self.check(nodes, many)
        template = self.template(nodes)
        sizes = dict(zip(TYPES, many, strict=True))
        cells = {kind: self._cells(kind, sizes[kind], nodes) for kind in ("triangle", "quad")}
        numbers = {kind: self.integers(sizes[kind]) for kind in cells}
        for kind in ("tetra", "pyramid", "wedge", "hexahedron"):
            cells[kind] = self._cells(kind, sizes[kind], nodes)
        return Mesh(
            template.original,
            {kind: rows for kind, rows in cells.items() if len(rows)},
            _boundaries(cells, numbers),
            template=template,
        )

    def check(self, nodes: int, many: list[int]) -> None:
        """Raise if the file cannot hold as much as it announces."""
        needed = 3 * nodes + sum(n * size for n, size in zip(many, TYPES.values(), strict=True))
        if needed + many[0] + many[1] > len(self.source.data):
            raise self.source.failure("the file is too short for the counts at its begin")

    def _cells(self, kind: str, count: int, nodes: int) -> Indices:
        rows = self.integers(count * TYPES[kind]).reshape(count, TYPES[kind]) - 1
        if rows.size and not (rows.min() >= 0 and rows.max() < nodes):
            raise self.source.failure(f"a {kind} refers to a node that is not in 1 to {nodes}")
        return rows[:, ORDER[kind]] if kind in ORDER else rows


def _boundaries(cells: Cells, numbers: dict[str, Indices]) -> Markers:
    markers: Markers = {}
    for kind, labels in numbers.items():
        for label in np.unique(labels).tolist():
            markers.setdefault(f"boundary {label}", {})[kind] = cells[kind][labels == label]
    return dict(sorted(markers.items(), key=lambda item: int(item[0].split()[1])))


class _Text(_Reader):
    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.starts, self.ends = split_tokens(source.data)
        self.at = 0

    def _span(self, count: int) -> slice:
        begin, self.at = self.at, self.at + count
        if self.at > len(self.starts):
            raise self.source.failure("the file ends too early")
        return slice(begin, self.at)

    def integers(self, count: int) -> Indices:
        span = self._span(count)
        return pick_numbers(self.source, self.starts[span], self.ends[span], np.int64)

    def template(self, count: int) -> TextTemplate:
        span = self._span(3 * count)
        starts, ends = self.starts[span], self.ends[span]
        points = pick_numbers(self.source, starts, ends).reshape(-1, 3)
        return TextTemplate(self.source.data, points, starts.reshape(-1, 3), ends.reshape(-1, 3))


class _Binary(_Reader):
    """Raw numbers; with record marks the counts are one record and all the rest another."""

    def __init__(self, source: Source, order: str, real: int, marks: bool) -> None:
        super().__init__(source)
        self.int, self.real = np.dtype(f"{order}i4"), np.dtype(f"{order}f{real}")
        self.marks = marks
        self.at = 4 * marks

    def _place(self, count: int, size: int) -> int:
        begin, self.at = self.at, self.at + count * size
        if self.at > len(self.source.data):
            raise self.source.failure("the file ends too early")
        return begin

    def _numbers(self, count: int, dtype: np.dtype) -> AnyArray:
        begin = self._place(count, dtype.itemsize)
        return np.frombuffer(self.source.data, dtype, count, begin if count else 0)

    def integers(self, count: int) -> Indices:
        return self._numbers(count, self.int).astype(np.int64)

    def template(self, count: int) -> BinaryTemplate:
        if self.marks:  # end of the record of counts, begin of the next one
            ends = self._numbers(2, self.int)
            if ends[0] != 28:
                raise self.source.failure("the record marks of this file are damaged")
        begin = self.at
        with np.errstate(invalid="ignore"):
            points = self._numbers(3 * count, self.real).astype(np.float64).reshape(-1, 3)
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            raise self.source.failure(f"node {bad[0] + 1} has a coordinate that is not finite")
        places = begin + self.real.itemsize * np.arange(3 * count).reshape(-1, 3)
        return BinaryTemplate(self.source.data, points, self.real, places)
