"""PLY surfaces, ASCII and binary of both byte orders.

1. The header names elements and their properties in the order of the file; vertices and faces
   are read, everything else is kept and not looked at.
2. Records of vertices have a fixed size. Faces are lists: read in bulk where all have the same
   number of nodes, one by one else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.normals import WithNormals
from ffdstudio.meshes.formats.number_table import Rows, read_rows
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate, shortest
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import strips
from ffdstudio.meshes.mesh import Mesh, Template
from ffdstudio.meshes.topology import Cells

STRIPS = "tristrips"
TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}


@dataclass(frozen=True)
class Property:
    """A property; `count` is the type of the number of entries if it is a list."""

    name: str
    type: str
    count: str = ""


@dataclass(frozen=True)
class Element:
    """A kind of records: its name, how many there are and what is in one."""

    name: str
    count: int
    properties: list[Property]

    def columns(self, source: Source, *names: str) -> list[int]:
        """Where the named properties stand among the element's."""
        own = [prop.name for prop in self.properties]
        for name in names:
            if name not in own:
                raise source.failure(f"element {self.name} has no property {name}")
        return [own.index(name) for name in names]


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a PLY file; see `read_mesh`."""
    source = Source(path, data)
    order, elements, begin = _header(source)
    names = [element.name for element in elements]
    if "vertex" not in names:
        raise source.failure("the header has no element vertex")
    properties = elements[names.index("vertex")].properties
    if any(prop.count for prop in properties):
        raise source.failure("lists as properties of a vertex are not supported")
    mesh = (_Binary(source, order) if order else _Ascii(source)).mesh(elements, begin)
    if {"nx", "ny", "nz"} <= {prop.name for prop in properties}:
        assert isinstance(mesh.template, TextTemplate | BinaryTemplate)
        return replace(mesh, template=WithNormals(mesh.template, "vertex normals (nx ny nz)"))
    return mesh


def _header(source: Source) -> tuple[str, list[Element], int]:
    """Byte order ("" for ASCII), elements, and where the header ends."""
    order, at = "?", 0
    elements: list[Element] = []
    orders = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
    while at < len(source.data):
        place, at = at, source.line_end(at)
        words = source.data[place:at][:400].decode("latin-1").split()
        match words:
            case ["end_header"]:
                if order == "?":
                    raise source.error(place, "the header does not say ascii or binary")
                return order, elements, at
            case ["format", kind, *_] if kind in orders:
                order = orders[kind]
            case ["element", name, count]:
                elements.append(Element(name, source.integer(count.encode(), place, name), []))
            case ["property", "list", count, kind, name] if elements and {count, kind} <= {*TYPES}:
                elements[-1].properties.append(Property(name, TYPES[kind], TYPES[count]))
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1].properties.append(Property(name, TYPES[kind]))
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case _:
                raise source.error(
                    place, f"not understood in a PLY header: {' '.join(words)[:40]!r}"
                )
    raise source.failure("the header does not end (no end_header)")


class _Ascii:
    def __init__(self, source: Source) -> None:
        self.source = source

    def mesh(self, elements: list[Element], begin: int) -> Mesh:
        rows = read_rows(self.source, begin, len(self.source.data), spans=True)
        needed = sum(element.count for element in elements)
        if len(rows) < needed:
            raise self.source.failure(f"the header announces {needed} lines, found {len(rows)}")
        at, cells, template = 0, {}, None
        for element in elements:
            part = np.arange(at, at + element.count)
            if element.name == "vertex":
                template = self._vertices(element, rows, part)
            elif element.name == "face":
                cells = self._faces(element, rows, part)
            elif element.name == STRIPS:
                cells = _with_strips(cells, self._faces(element, rows, part))
            at += element.count
        assert template is not None
        return _checked(self.source, template, cells)

    def _vertices(self, element: Element, rows: Rows, part: Indices) -> TextTemplate:
        columns = element.columns(self.source, "x", "y", "z")
        short = np.flatnonzero(rows.widths[part] < len(element.properties))
        if len(short):
            raise self.source.error(int(rows.places[part[short[0]]]), "a vertex is incomplete")
        where = rows.first[part][:, None] + np.array(columns)
        points = rows.values[where]
        kinds = {element.properties[k].type for k in columns}
        dtype = np.dtype("f4" if "f4" in kinds else "f8")
        starts, ends = rows.starts[where], rows.ends[where]
        return TextTemplate(self.source.data, points, starts, ends, dtype=dtype)

    def _faces(self, element: Element, rows: Rows, part: Indices) -> Cells:
        before = next((k for k, prop in enumerate(element.properties) if prop.count), None)
        if before is None:
            raise self.source.failure("a face has no list of nodes")
        short = np.flatnonzero(rows.widths[part] <= before)
        if len(short):
            raise self.source.error(int(rows.places[part[short[0]]]), "a face is incomplete")
        sizes = rows.values[rows.first[part] + before]
        room = rows.widths[part] - before - 1
        wrong = np.flatnonzero((sizes < 1) | (sizes % 1 != 0) | (sizes > room))
        if len(wrong):
            raise self.source.error(int(rows.places[part[wrong[0]]]), "a face is incomplete")
        cells = {}
        for size in np.unique(sizes).astype(int).tolist():
            where = rows.columns(before + size + 1, part[sizes == size])[:, before + 1 :]
            cells[_name(size)] = rows.values[where].astype(np.int64)
        return cells


class _Binary:
    def __init__(self, source: Source, order: str) -> None:
        self.source, self.order = source, order

    def mesh(self, elements: list[Element], begin: int) -> Mesh:
        at, cells, template = begin, {}, None
        for element in elements:
            if template is not None and cells and STRIPS not in [e.name for e in elements]:
                break
            if element.name == "vertex":
                template = self._vertices(element, at)
            lists = any(prop.count for prop in element.properties)
            found, at = self._lists(element, at) if lists else ({}, self._skip(element, at))
            if element.name == "face":
                cells = found
            elif element.name == STRIPS:
                cells = _with_strips(cells, found)
        assert template is not None
        return _checked(self.source, template, cells)

    def _record(self, element: Element, sizes: list[int]) -> np.dtype[Any]:
        """Type of one record whose lists have these sizes."""
        fields: list[tuple[Any, ...]] = []
        left = iter(sizes)
        for k, prop in enumerate(element.properties):
            if prop.count:
                fields += [(f"n{k}", self.order + prop.count)]
                fields += [(f"p{k}", self.order + prop.type, (next(left),))]
            else:
                fields += [(f"p{k}", self.order + prop.type)]
        return np.dtype(fields)

    def _skip(self, element: Element, at: int) -> int:
        end = at + element.count * self._record(element, []).itemsize
        if end > len(self.source.data):
            raise self.source.failure(f"the file ends within its {element.count} {element.name}s")
        return end

    def _vertices(self, element: Element, at: int) -> BinaryTemplate:
        self._skip(element, at)
        record = self._record(element, [])
        columns = [f"p{k}" for k in element.columns(self.source, "x", "y", "z")]
        assert record.fields is not None
        kinds = {record[name] for name in columns}
        if len(kinds) > 1 or record[columns[0]].kind != "f":
            raise self.source.failure("x, y and z must be of one floating-point type")
        found = np.frombuffer(self.source.data, record, element.count, at)
        with np.errstate(invalid="ignore"):
            points = np.stack([found[name].astype(np.float64) for name in columns], axis=1)
        offsets = np.array([record.fields[name][1] for name in columns])
        places = at + record.itemsize * np.arange(element.count)[:, None] + offsets
        return BinaryTemplate(self.source.data, points, record[columns[0]], places)

    def _lists(self, element: Element, at: int) -> tuple[Cells, int]:
        """Faces by type; all in one go if all have the size of the first."""
        first = self._one(element, at)
        record = self._record(element, [len(nodes) for nodes in first[0]])
        end = at + element.count * record.itemsize
        counts = [f"n{k}" for k, prop in enumerate(element.properties) if prop.count]
        nodes = [f"p{k}" for k, prop in enumerate(element.properties) if prop.count]
        if element.count and end <= len(self.source.data):
            found = np.frombuffer(self.source.data, record, element.count, at)
            if all((found[n] == len(first[0][k])).all() for k, n in enumerate(counts)):
                table = found[nodes[0]].astype(np.int64)
                return {_name(table.shape[1]): table}, end
        return self._one_by_one(element, at)

    def _one_by_one(self, element: Element, at: int) -> tuple[Cells, int]:
        parts: dict[str, list[AnyArray]] = {}
        for _ in range(element.count):
            lists, at = self._one(element, at)
            parts.setdefault(_name(len(lists[0])), []).append(lists[0].astype(np.int64))
        return {name: np.stack(nodes) for name, nodes in parts.items()}, at

    def _one(self, element: Element, at: int) -> tuple[list[AnyArray], int]:
        """Lists of the record at a place, and the place behind it."""
        lists: list[AnyArray] = []
        for prop in element.properties if element.count else ():
            size = 1
            if prop.count:
                size = int(self._numbers(prop.count, 1, at)[0])
                at += np.dtype(prop.count).itemsize
            values = self._numbers(prop.type, size, at)
            at += values.nbytes
            if prop.count:
                lists.append(values)
        return lists or [np.empty(0)], at

    def _numbers(self, kind: str, count: int, at: int) -> AnyArray:
        dtype = np.dtype(self.order + kind)
        if count < 0 or at + count * dtype.itemsize > len(self.source.data):
            raise self.source.failure("the file ends within its faces")
        return np.frombuffer(self.source.data, dtype, count, at)


def _with_strips(cells: Cells, lists: Cells) -> Cells:
    """Cells with the triangles of strips, which -1 divides within a list."""
    flat = [np.append(row, -1) for nodes in lists.values() for row in nodes]
    nodes = np.concatenate(flat) if flat else np.empty(0, dtype=np.int64)
    ends = np.flatnonzero(nodes == -1)
    begins = np.concatenate([[0], ends[:-1] + 1]) if len(ends) else ends
    found = strips(nodes, begins, ends - begins)
    known = cells.get("triangle", np.empty((0, 3), dtype=np.int64))
    return {**cells, "triangle": np.concatenate([known, found])}


def _name(size: int) -> str:
    return {1: "vertex", 2: "line", 3: "triangle", 4: "quad"}.get(size, f"polygon{size}")


def _checked(source: Source, template: Template, cells: Cells) -> Mesh:
    points = template.original
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"vertex {bad[0]} (counted from 0) is not finite")
    for name, nodes in cells.items():
        if nodes.size and not (nodes.min() >= 0 and nodes.max() < len(points)):
            raise source.failure(f"a {name} refers to a vertex not in 0 to {len(points) - 1}")
    return Mesh(
        points, {name: nodes for name, nodes in cells.items() if nodes.size}, template=template
    )


def write_new(mesh: Mesh, path: Path) -> None:
    """Write the surface of a mesh as ASCII PLY in double precision."""
    faces = [row for nodes in mesh.surface().values() for row in nodes.tolist()]
    head = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(mesh.points)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list int int vertex_indices",
        "end_header",
    ]
    nodes = [" ".join(shortest(row)) for row in mesh.points.tolist()]
    rows = [" ".join(map(str, [len(row), *row])) for row in faces]
    write_bytes(path, "\n".join([*head, *nodes, *rows, ""]).encode())
