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
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import AnyArray, Array, Indices
from ffdstudio.files import read_bytes, together, write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells

TYPES = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
ORDER = {"pyramid": [0, 3, 4, 1, 2]}
_LAYOUT = re.compile(r"\.(l?)([br])([48])(l?)\.ugrid$", re.I)
MOST_NAMES = 1 << 20  # bytes of a file of names
KINDS = {3000: "wall", 4000: "wall", 5000: "farfield", 5050: "farfield", 6661: "symmetry"}
KINDS |= {6662: "symmetry", 6663: "symmetry", 6100: "periodic", 7011: "inflow", 7012: "outflow"}


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an AFLR3 mesh; see `read_mesh`. Boundary numbers become markers."""
    source = Source(path, data)
    layout = _LAYOUT.search(path.name)
    if layout is None:
        return _Text(source).mesh()
    order = "<" if layout[1] else ">"
    wide = 8 if layout[4] else 4
    return _Binary(source, order, int(layout[3]), layout[2].lower() == "r", wide).mesh()


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
        file = _mapbc_path(self.source.path)
        listed = read_bytes(file)[:MOST_NAMES] if file.is_file() else None
        names, kinds = _mapbc(listed or b"")
        return Mesh(
            template.original,
            {kind: rows for kind, rows in cells.items() if len(rows)},
            _boundaries(cells, numbers, names),
            kinds={name: kind for name, kind in kinds.items() if name in names.values()},
            template=template if listed is None else WithMapbc(template, listed),
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


def _boundaries(cells: Cells, numbers: dict[str, Indices], names: dict[int, str]) -> Markers:
    found: dict[int, Cells] = {}
    for kind, labels in numbers.items():
        for label in np.unique(labels).tolist():
            found.setdefault(label, {})[kind] = cells[kind][labels == label]
    markers: Markers = {}
    for label, part in sorted(found.items()):
        name = names.get(label, f"boundary {label}")
        markers[f"{name} ({label})" if name in markers else name] = part
    return markers


def _mapbc_path(path: Path) -> Path:
    """File of the names of boundaries that belongs to a mesh."""
    stem = re.sub(r"(\.l?[br][48]l?)?\.ugrid$", "", path.name, flags=re.I)
    return path.with_name(f"{stem}.mapbc")


def _mapbc(data: bytes) -> tuple[dict[int, str], dict[str, str]]:
    """Names of the boundary numbers, and their kinds."""
    names: dict[int, str] = {}
    kinds: dict[str, str] = {}
    for line in data.splitlines()[1:]:
        words = line.split(None, 2)
        if len(words) == 3 and words[0].isdigit() and words[1].lstrip(b"-").isdigit():
            name = decoded(words[2]).strip()
            names[int(words[0])] = name
            kinds[name] = KINDS.get(abs(int(words[1])), "patch")
    return names, kinds


@dataclass(frozen=True, eq=False)
class WithMapbc:
    """A mesh with the names of its boundaries, which are written beside it if nobody did."""

    template: TextTemplate | BinaryTemplate
    names: bytes

    @property
    def original(self) -> Array:
        """(n, 3) coordinates as in the file."""
        return self.template.original

    def patched(self, points: Array) -> bytes:
        """Content of the mesh itself with these (n, 3) coordinates."""
        return self.template.patched(points)

    def write(self, path: Path, points: Array) -> None:
        """Write the mesh and, where there is none, the file of names."""
        with together():
            self.template.write(path, points)
            if not _mapbc_path(path).exists():
                write_bytes(_mapbc_path(path), self.names)


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

    def __init__(self, source: Source, order: str, real: int, marks: bool, wide: int) -> None:
        super().__init__(source)
        self.int, self.real = np.dtype(f"{order}i{wide}"), np.dtype(f"{order}f{real}")
        self.mark = np.dtype(f"{order}i4")
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
            ends = self._numbers(2, self.mark)
            if ends[0] != 7 * self.int.itemsize:
                raise self.source.failure("the record marks of this file are damaged")
        begin = self.at
        with np.errstate(invalid="ignore"):
            points = self._numbers(3 * count, self.real).astype(np.float64).reshape(-1, 3)
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            raise self.source.failure(f"node {bad[0] + 1} has a coordinate that is not finite")
        places = begin + self.real.itemsize * np.arange(3 * count).reshape(-1, 3)
        return BinaryTemplate(self.source.data, points, self.real, places)
