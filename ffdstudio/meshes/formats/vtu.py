"""VTK's XML files: unstructured grids (.vtu), polygons (.vtp) and structured grids (.vts).

The array of points is changed where it stands, in the encoding that it has; the rest of the
file keeps its bytes. In compressed files the offsets behind the array move with its size.

The attributes RangeMin and RangeMax stay, too: VTK writes them for people, and takes no range
from them when it reads.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.normals import WithNormals
from ffdstudio.meshes.formats.patch import changed, put, rounded, shortest, warn_if_rounded
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import (
    POLYHEDRON,
    Collected,
    block_cells,
    offsets_of,
    streams,
)
from ffdstudio.meshes.formats.xmlarray import ArrayLayout, DataArray, Tag, parse
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.polyhedra import Loops

POLYDATA = {"Verts": 1, "Lines": 3, "Strips": 6, "Polys": 7}
Edit = tuple[int, int, bytes]


@dataclass(frozen=True, eq=False)
class XmlTemplate:
    """The file with the arrays of points of its pieces, and the offsets of all arrays."""

    data: bytes
    original: Array
    arrays: list[DataArray]
    offsets: list[tuple[int, int, str]]  # place of the array, place of the attribute, its text

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates."""
        edits: list[Edit] = []
        first = 0
        for array in self.arrays:
            count = len(array.values()) // 3
            part = slice(first, first + count)
            edits += self._edits(array, self.original[part], points[part])
            first += count
        edits += self._moved_offsets(edits)
        pieces, at = [], 0
        for begin, end, text in sorted(edits):
            pieces += [self.data[at:begin], text]
            at = end
        return b"".join([*pieces, self.data[at:]])

    def _edits(self, array: DataArray, old: Array, new: Array) -> list[Edit]:
        moved = np.flatnonzero(changed(old, new).ravel())
        if not len(moved):
            return []
        values = np.ascontiguousarray(new).ravel()[moved]
        if array.form == "ascii":
            starts, ends = array.spans()
            stored = rounded(values, array.dtype).astype(np.float64)
            texts = [text.encode() for text in shortest(stored.tolist())]
            return list(zip(starts[moved].tolist(), ends[moved].tolist(), texts, strict=True))
        plain = array.decode()
        out = bytearray(plain)
        put(out, moved * array.dtype.itemsize, values, array.dtype)
        return [(array.begin, array.end, array.encode(plain, bytes(out)))]

    def _moved_offsets(self, edits: list[Edit]) -> list[Edit]:
        """Attributes to change because appended arrays before them have another size."""
        appended = {array.begin for array in self.arrays if array.form == "appended"}
        grown = [
            (begin, len(new) - (end - begin)) for begin, end, new in edits if begin in appended
        ]
        found = []
        for place, attribute, text in self.offsets:
            shift = sum(growth for begin, growth in grown if begin < place)
            if shift:
                found.append((attribute, attribute + len(text), str(int(text) + shift).encode()))
        return found

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file; warn if it cannot hold all digits."""
        data = self.patched(points)
        for array in self.arrays[:1]:
            warn_if_rounded(self.original, points, array.dtype, path)
        write_bytes(path, data)


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a VTK XML file; see `read_mesh`."""
    source = Source(path, data)
    root = parse(source)
    layout = ArrayLayout.of(source, root)
    pieces = root.all("Piece")
    arrays = [_points_array(layout, piece) for piece in pieces]
    if not arrays:
        raise source.failure("there is no Piece in this file")
    parts = [_points(array) for array in arrays]
    first = offsets_of(np.array([len(part) for part in parts]))
    found = Collected(source)
    for piece, part, start in zip(pieces, parts, first, strict=False):
        _cells(found, layout, piece, len(part), int(start))
    points = np.concatenate(parts)
    plain = XmlTemplate(data, points, arrays, _offsets(layout, root))
    template = WithNormals(plain, "normals") if _has_normals(root) else plain
    return found.mesh(points, template)


def _points_array(layout: ArrayLayout, piece: Tag) -> DataArray:
    tag = piece.child("Points")
    array = tag and tag.child("DataArray")
    if not array:
        raise layout.source.error(piece.begin - 1, "this Piece has no array of points")
    found = DataArray(layout, array, 3 * _count(layout, piece, "NumberOfPoints"))
    if found.dtype.kind != "f":
        raise layout.source.error(array.begin - 1, "points of whole numbers cannot be deformed")
    return found


def _has_normals(root: Tag) -> bool:
    return any(
        "normals" in array.get("Name").lower()
        for name in ("PointData", "CellData")
        for tag in root.all(name)
        for array in tag.children
    )


def _count(layout: ArrayLayout, piece: Tag, name: str) -> int:
    """Number of points or cells that a piece announces; a structured one by its extent."""
    if name == "NumberOfPoints" and piece.get("Extent"):
        return int(np.prod(_shape(layout, piece), dtype=object))
    return layout.source.integer(piece.get(name).encode(), piece.begin - 1, name)


def _shape(layout: ArrayLayout, piece: Tag) -> tuple[int, ...]:
    words = piece.get("Extent").split()
    extent = [int(n) for n in words if re.fullmatch(r"-?\d{1,9}", n)]
    shape = tuple(extent[k + 1] - extent[k] + 1 for k in range(0, len(extent) - 1, 2))
    if len(words) != 6 or len(shape) != 3 or min(shape) < 1:
        raise layout.source.error(piece.begin - 1, "Extent must be three ranges")
    return shape


def _points(array: DataArray) -> Array:
    values = array.values()
    with np.errstate(invalid="ignore"):
        points = values.astype(np.float64).reshape(-1, 3)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise array.source.failure(f"point {bad[0]} (counted from 0) is not finite")
    return points


def _offsets(layout: ArrayLayout, root: Tag) -> list[tuple[int, int, str]]:
    """Where every appended array begins, and where its offset is written."""
    found = []
    for tag in [*root.all("DataArray"), *root.all("Array")]:
        text, attribute = tag.attributes.get("offset", ("", 0))
        if tag.get("format") == "appended" and text.isdecimal():
            found.append((layout.appended + int(text), attribute, text))
    return found


def _cells(found: Collected, layout: ArrayLayout, piece: Tag, count: int, first: int) -> None:
    cells = piece.child("Cells")
    if cells:
        many = _count(layout, piece, "NumberOfCells")
        types = _array(layout, cells, "types", many)
        begins, nodes = _lists(layout, cells, many)
        found.add(begins, nodes, types, count, first, _polyhedra(layout, cells, types))
    elif piece.get("Extent"):
        found.take(block_cells(_shape(layout, piece)), first)
    for name, number in POLYDATA.items():
        tag = piece.child(name)
        if tag and tag.children:
            many = _count(layout, piece, f"NumberOf{name}")
            begins, nodes = _lists(layout, tag, many)
            types = np.where(np.diff(begins) == 2, 3, 4) if number == 3 else np.full(many, number)
            found.add(begins, nodes, types, count, first)


def _polyhedra(layout: ArrayLayout, cells: Tag, types: Indices) -> Loops | None:
    """Faces of the polyhedra of a piece, as streams or, since version 2.3, in four arrays."""
    chosen = np.flatnonzero(types == POLYHEDRON)
    names = {child.get("Name") for child in cells.children}
    if not len(chosen):
        return None
    try:
        if "faceoffsets" in names:
            return _streamed(layout, cells, chosen, len(types))
        if "polyhedron_to_faces" in names:
            return _arrayed(layout, cells, chosen, len(types))
    except IndexError:
        raise layout.source.failure("the faces of a polyhedron do not add up") from None
    return None


def _streamed(layout: ArrayLayout, cells: Tag, chosen: Indices, many: int) -> Loops:
    ends = _array(layout, cells, "faceoffsets", many)
    values = _array(layout, cells, "faces", int(ends.max(initial=0)))
    before = np.concatenate([[0], np.maximum.accumulate(ends)[:-1]])
    return streams(values, np.maximum(before, 0)[chosen], chosen)


def _arrayed(layout: ArrayLayout, cells: Tag, chosen: Indices, many: int) -> Loops:
    ends = np.concatenate([[0], _array(layout, cells, "polyhedron_offsets", many)])
    count = np.diff(ends)[chosen]
    mine = _array(layout, cells, "polyhedron_to_faces", int(ends[-1]))
    faces = np.concatenate(
        [[0], _array(layout, cells, "face_offsets", int(mine.max(initial=-1)) + 1)]
    )
    nodes = _array(layout, cells, "face_connectivity", int(faces[-1]))
    if (count < 0).any() or (np.diff(faces) < 0).any() or mine.min(initial=0) < 0:
        raise IndexError
    sizes = np.diff(faces)[mine]
    step = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return Loops(nodes[np.repeat(faces[mine], sizes) + step], sizes, np.repeat(chosen, count))


def _lists(layout: ArrayLayout, tag: Tag, many: int) -> tuple[Indices, Indices]:
    """Where each of so many cells begins among the nodes, and the nodes."""
    begins = np.concatenate([[0], _array(layout, tag, "offsets", many)])
    return begins, _array(layout, tag, "connectivity", int(begins[-1]))


def _array(layout: ArrayLayout, tag: Tag, name: str, count: int) -> Indices:
    own = {child.get("Name"): child for child in tag.children if child.name == "DataArray"}
    if name not in own:
        raise layout.source.error(tag.begin - 1, f"<{tag.name}> has no array {name}")
    return DataArray(layout, own[name], count).values().astype(np.int64)
