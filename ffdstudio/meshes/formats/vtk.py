"""Legacy VTK files: unstructured and structured grids and polygons, ASCII and binary.

1. A file is keywords with blocks of numbers behind them. Up to version 4.2 a block of cells is
   "size, nodes" cell by cell; from 5.1 on it is two arrays, OFFSETS and CONNECTIVITY.
2. Binary numbers have the big end first. Data of points and cells is kept, not looked at.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.normals import WithNormals
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate, shortest
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import (
    POLYHEDRON,
    SIZED,
    Collected,
    block_cells,
    offsets_of,
    streams,
)
from ffdstudio.meshes.mesh import Mesh, Template
from ffdstudio.meshes.polyhedra import Loops

TYPES = {
    "float": ">f4",
    "double": ">f8",
    "int": ">i4",
    "unsigned_int": ">u4",
    "long": ">i8",
    "vtkidtype": ">i8",
    "vtktypeint64": ">i8",
    "vtktypeint32": ">i4",
    "char": ">i1",
    "unsigned_char": ">u1",
    "short": ">i2",
    "unsigned_short": ">u2",
    "unsigned_long": ">u8",
    "bit": "",
    "string": "",
}
DATASETS = ("UNSTRUCTURED_GRID", "POLYDATA", "STRUCTURED_GRID")
_NORMALS = re.compile(rb"^[ \t]*NORMALS[ \t]", re.I | re.M)
POLYDATA = {"VERTICES": 1, "LINES": 3, "POLYGONS": 7, "TRIANGLE_STRIPS": 6}


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a legacy VTK file; see `read_mesh`."""
    return _Reader(Source(path, data)).mesh()


class _Reader:
    """Goes through the file from keyword to keyword."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.at = 0
        if not self._line().startswith("# vtk DataFile"):
            raise source.error(0, "a legacy VTK file begins with '# vtk DataFile'")
        self._line()  # title
        kind = " ".join(self._words()).upper()
        if kind not in ("ASCII", "BINARY"):
            raise source.error(self.at - 1, f"expected ASCII or BINARY, found {kind[:20]!r}")
        self.is_text = kind == "ASCII"
        if self.is_text:
            self.starts, self.ends = split_tokens(source.data)
        self.template: TextTemplate | BinaryTemplate | None = None
        self.cells: list[tuple[int, Indices, Indices]] = []
        self.types: Indices | None = None
        self.shape: tuple[int, ...] = ()

    def _line(self) -> str:
        begin, self.at = self.at, self.source.line_end(self.at)
        return self.source.data[begin : self.at][:400].decode("latin-1").strip()

    def _words(self) -> list[str]:
        """Words of the next line that has any."""
        words = self._line().split()
        while not words and self.at < len(self.source.data):
            words = self._line().split()
        return words

    def mesh(self) -> Mesh:
        while self.at < len(self.source.data):
            begin = self.at
            words = self._line().split()
            if words and words[0].upper() in ("POINT_DATA", "CELL_DATA"):
                break
            if words:
                self._section([words[0].upper(), *words[1:]], begin)
        if self.template is None:
            raise self.source.failure("there are no POINTS in this file")
        points = self.template.original
        template: Template = self.template
        if _NORMALS.search(self.source.data, self.at):
            template = WithNormals(self.template, "normals")
        return self._cells(len(points)).mesh(points, template)

    def _section(self, words: list[str], begin: int) -> None:
        match words:
            case ["DATASET", kind] if kind.upper() in DATASETS:
                pass
            case ["DATASET", kind, *_]:
                raise self.source.error(begin, f"a {kind[:30]} does not store its points")
            case ["DIMENSIONS", *numbers] if len(numbers) == 3:
                self.shape = tuple(self._count(n, begin) for n in numbers)
            case ["POINTS", count, kind]:
                self._points(self._count(count, begin), kind.lower(), begin)
            case [
                "CELLS" | "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" as key,
                count,
                size,
            ]:
                self._lists(key, self._count(count, begin), self._count(size, begin), begin)
            case ["CELL_TYPES", count]:
                self.types = self._numbers(self._count(count, begin), ">i4", begin).astype(np.int64)
            case ["FIELD", _, count]:
                for _ in range(self._count(count, begin)):
                    self._skip_array()
            case ["METADATA"]:
                while self.at < len(self.source.data) and self._line():
                    pass
            case _:
                raise self.source.error(begin, f"not understood: {' '.join(words)[:40]!r}")

    def _count(self, word: str, place: int) -> int:
        return self.source.integer(word.encode("latin-1", "replace"), place, "a count")

    def _type(self, kind: str, place: int) -> str:
        if not TYPES.get(kind.lower()):
            raise self.source.error(place, f"numbers of type {kind[:20]!r} are not supported")
        return TYPES[kind.lower()]

    def _span(self, count: int, place: int) -> slice:
        """Next tokens of a text."""
        first = int(np.searchsorted(self.starts, self.at))
        if first + count > len(self.starts):
            raise self.source.error(
                place, f"the file ends before the {count} numbers of this block"
            )
        if count:
            self.at = int(self.ends[first + count - 1])
        return slice(first, first + count)

    def _bytes(self, size: int, place: int) -> int:
        begin = self.at
        if begin + size > len(self.source.data):
            raise self.source.error(place, f"the file ends before the {size} bytes of this block")
        self.at = begin + size
        return begin

    def _numbers(self, count: int, dtype: str, place: int) -> AnyArray:
        if self.is_text:
            span = self._span(count, place)
            kind = np.float64 if "f" in dtype else np.int64
            return pick_numbers(self.source, self.starts[span], self.ends[span], kind)
        begin = self._bytes(count * np.dtype(dtype).itemsize, place)
        return np.frombuffer(self.source.data, dtype, count, begin)

    def _skip_array(self) -> None:
        begin, words = self.at, self._words()
        if len(words) != 4:
            raise self.source.error(
                begin, "an array of a FIELD needs a name, two counts and a type"
            )
        count = self._count(words[1], begin) * self._count(words[2], begin)
        if self.is_text:
            self._span(count, begin)
        else:
            self._bytes(count * np.dtype(self._type(words[3], begin)).itemsize, begin)

    def _points(self, count: int, kind: str, place: int) -> None:
        dtype = np.dtype(self._type(kind, place))
        if dtype.kind != "f":
            raise self.source.error(place, f"points of type {kind} cannot hold a deformed shape")
        if self.is_text:
            span = self._span(3 * count, place)
            starts, ends = self.starts[span], self.ends[span]
            points = pick_numbers(self.source, starts, ends).reshape(-1, 3)
            starts, ends = starts.reshape(-1, 3), ends.reshape(-1, 3)
            self.template = TextTemplate(self.source.data, points, starts, ends, dtype=dtype)
            return
        begin = self._bytes(3 * count * dtype.itemsize, place)
        with np.errstate(invalid="ignore"):
            found = np.frombuffer(self.source.data, dtype, 3 * count, begin).astype(np.float64)
        places = begin + dtype.itemsize * np.arange(3 * count).reshape(-1, 3)
        self.template = BinaryTemplate(self.source.data, found.reshape(-1, 3), dtype, places)

    def _lists(self, key: str, count: int, size: int, place: int) -> None:
        begin, words = self.at, self._line().split()
        if words[:1] == ["OFFSETS"] and len(words) == 2:
            offsets = self._numbers(count, self._type(words[1], place), place)
            words = self._words()
            if words[:1] != ["CONNECTIVITY"] or len(words) != 2:
                raise self.source.error(self.at - 1, "expected CONNECTIVITY")
            nodes = self._numbers(size, self._type(words[1], place), place)
            offsets, nodes = offsets.astype(np.int64), nodes.astype(np.int64)
        else:
            self.at = begin
            flat = self._numbers(size, ">i4", place).astype(np.int64)
            offsets, nodes = self._split(flat, count, place)
        self.cells.append((POLYDATA.get(key, 0), offsets, nodes))

    def _split(self, flat: Indices, count: int, place: int) -> tuple[Indices, Indices]:
        """Offsets and nodes from "size, nodes, size, nodes, ..."."""
        begins, at, numbers = [], 0, flat.tolist()
        for _ in range(count):
            if at >= len(numbers) or not 0 <= numbers[at] < len(numbers) - at:
                raise self.source.error(place, "the sizes of the cells do not add up")
            begins.append(at)
            at += 1 + numbers[at]
        return offsets_of(flat[begins]), np.delete(flat[:at], begins)

    def _cells(self, count: int) -> Collected:
        found = Collected(self.source)
        if self.shape:
            if int(np.prod(self.shape)) != count:
                raise self.source.failure(f"DIMENSIONS {self.shape} do not fit {count} points")
            found.take(block_cells(self.shape))
            return found
        for number, offsets, nodes in self.cells:
            types = np.full(len(offsets) - 1, number)
            if number == 0:
                types = self.types if self.types is not None else np.empty(0, dtype=np.int64)
            if number == 3:  # a line may run through many points
                pairs = np.setdiff1d(np.arange(len(nodes) - 1), offsets[1:-1] - 1)
                nodes = np.stack([nodes[pairs], nodes[pairs + 1]], axis=1).ravel()
                offsets, types = 2 * np.arange(len(pairs) + 1), np.full(len(pairs), 3)
            nodes, loops = self._polyhedra(offsets, nodes, types)
            found.add(offsets, nodes, types, count, 0, loops)
        return found

    def _polyhedra(
        self, offsets: Indices, nodes: Indices, types: Indices
    ) -> tuple[Indices, Loops | None]:
        """Faces of the polyhedra, whose "nodes" are streams of faces, and nodes without these."""
        chosen = np.flatnonzero(types == POLYHEDRON)
        if not len(chosen) or len(types) != len(offsets) - 1:
            return nodes, None
        try:
            loops = streams(nodes, offsets[chosen], chosen)
        except IndexError:
            raise self.source.failure("the faces of a polyhedron do not add up") from None
        plain = nodes.copy()
        size = np.diff(offsets)[chosen]
        step = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
        plain[np.repeat(offsets[chosen], size) + step] = 0
        return plain, loops


def write_new(mesh: Mesh, path: Path) -> None:
    """Write a mesh as a legacy VTK file, version 4.2, ASCII in double precision."""
    if mesh.faces is not None:
        raise InputError(f"{path}: a mesh of faces cannot be written in this format yet")
    numbers = {name: number for number, (name, _) in SIZED.items()}
    blocks = [(numbers.get(name, 7), nodes) for name, nodes in mesh.cells.items()]
    rows = [[len(row), *row] for _, nodes in blocks for row in nodes.tolist()]
    text = [
        "# vtk DataFile Version 4.2",
        "FFD Studio",
        "ASCII",
        "DATASET UNSTRUCTURED_GRID",
        f"POINTS {len(mesh.points)} double",
        *(" ".join(shortest(row)) for row in mesh.points.tolist()),
        f"CELLS {len(rows)} {sum(map(len, rows))}",
        *(" ".join(map(str, row)) for row in rows),
        f"CELL_TYPES {len(rows)}",
        *(str(number) for number, nodes in blocks for _ in range(len(nodes))),
        "",
    ]
    write_bytes(path, "\n".join(text).encode())
