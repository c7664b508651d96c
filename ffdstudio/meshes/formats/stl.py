"""STL surfaces, ASCII and binary.

1. A file repeats every vertex for each facet. Equal coordinates are one node here, so that a
   surface stays closed, and every place of a node is rewritten when it moves.
2. Facets with a moved node get a new normal; the others keep theirs, right or wrong.
3. A binary file often begins with "solid", too: its size tells. A few bytes behind the last
   facet are kept.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import line_firsts, pick_numbers, split_tokens
from ffdstudio.meshes.formats.patch import BinaryTemplate, Edits, TextTemplate, changed, put
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh

HEADER, RECORD = 84, 50
FACET = b"fovvvee"  # first letters of the seven lines of a facet


@dataclass(frozen=True, eq=False)
class AsciiTemplate(TextTemplate):
    """ASCII STL; `normals` are the places of the normals' components, begin and end, (2, k, 3)."""

    normals: Indices = None  # type: ignore[assignment]

    def edits(self, points: Array) -> Edits:
        """Find the coordinates that change, and the normals with them."""
        coordinates = super().edits(points)
        facets, normals = _new_normals(self.original, points, self.slots)
        return Edits(
            np.concatenate([coordinates.starts, self.normals[0][facets].ravel()]),
            np.concatenate([coordinates.ends, self.normals[1][facets].ravel()]),
            np.concatenate([coordinates.values, normals.ravel()]),
        )


@dataclass(frozen=True, eq=False)
class StlTemplate(BinaryTemplate):
    """Binary STL."""

    def patched(self, points: Array) -> bytes:
        """File content with these coordinates and the normals that they give."""
        facets, normals = _new_normals(self.original, points, self.slots)
        out = bytearray(super().patched(points))
        places = HEADER + RECORD * facets[:, None] + 4 * np.arange(3)
        put(out, places.ravel(), normals.ravel(), self.dtype)
        return bytes(out)


def _new_normals(original: Array, points: Array, slots: Indices | None) -> tuple[Indices, Array]:
    """Facets with a moved node, and their unit normals (zero for a facet without area)."""
    assert slots is not None
    triangles = slots.reshape(-1, 3)
    moved = np.flatnonzero(changed(original, points).any(axis=1))
    facets = np.flatnonzero(np.isin(triangles, moved).any(axis=1))
    return facets, unit_normals(points, triangles[facets])


def unit_normals(points: Array, triangles: Indices) -> Array:
    """(k, 3) unit normals of triangles, zero where there is no area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    result: Array = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    return result


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an STL file; see `read_mesh`."""
    source = Source(path, data)
    if len(data) >= HEADER:
        count = struct.unpack_from("<I", data, 80)[0]
        behind = behind_of(data, count)
        if behind == 0 or (0 < behind < RECORD and count and b"\0" in data[HEADER:]):
            return _read_binary(source, count)
        many = (len(data) - HEADER) // RECORD
        if count in (0, 2**32 - 1) and many and behind_of(data, many) == 0:  # writers of streams
            return _read_binary(source, many)
    if not data.lstrip()[:5].lower() == b"solid":
        raise source.failure("neither an ASCII STL nor a binary one of the size that it states")
    return _read_ascii(source)


def behind_of(data: bytes, count: int) -> int:
    """Bytes that follow so many facets."""
    return len(data) - HEADER - RECORD * count


def _read_binary(source: Source, count: int) -> Mesh:
    places = HEADER + RECORD * np.arange(count)[:, None] + 12 + 4 * np.arange(9)
    kind = np.dtype([("normal", "<f4", 3), ("vertices", "<f4", (3, 3)), ("attribute", "<u2")])
    vertices = np.frombuffer(source.data, kind, count, HEADER)["vertices"].reshape(-1, 3)
    if not np.isfinite(vertices).all():
        bad = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0]) // 3
        raise source.failure(f"facet {bad} (counted from 0) has a coordinate that is not finite")
    points, slots = merged(vertices.astype(np.float64))
    template = StlTemplate(source.data, points, np.dtype("<f4"), places.reshape(-1, 3), slots)
    return Mesh(points, {"triangle": slots.reshape(-1, 3)}, template=template)


def _read_ascii(source: Source) -> Mesh:
    starts, ends = split_tokens(source.data)
    first = line_firsts(source.data, starts)
    letters = np.frombuffer(source.data, dtype=np.uint8)
    line = letters[starts[first]] | 32
    is_solid = (line == ord("s")) | (
        (line == ord("e")) & _spells_endsolid(source.data, starts[first])
    )
    facets, solids = first[~is_solid], first[is_solid]
    _check(source, line[~is_solid], facets, starts, len(starts))
    rows = facets.reshape(-1, 7)
    vertex = (rows[:, 2:5].ravel()[:, None] + np.arange(1, 4)).astype(np.int64)
    normal = rows[:, :1] + np.arange(2, 5)
    found = pick_numbers(source, starts[vertex].ravel(), ends[vertex].ravel())
    points, slots = merged(found.reshape(-1, 3))
    triangles = slots.reshape(-1, 3)
    template = AsciiTemplate(
        source.data,
        points,
        starts[vertex],
        ends[vertex],
        slots,
        normals=np.stack([starts[normal], ends[normal]]),
    )
    markers = _solids(source, starts[solids], np.searchsorted(rows[:, 0], solids), triangles)
    return Mesh(points, {"triangle": triangles}, markers, template=template)


def _spells_endsolid(data: bytes, places: Indices) -> np.ndarray:
    """Whether the word there has the s of "endsolid" at its fourth letter."""
    letters = np.frombuffer(data + bytes(4), dtype=np.uint8)
    result: np.ndarray = (letters[places + 3] | 32) == ord("s")
    return result


def _check(source: Source, line: np.ndarray, facets: Indices, starts: Indices, total: int) -> None:
    """Raise unless the lines are whole facets, each line with its number of words."""
    expected = np.resize(np.frombuffer(FACET, dtype=np.uint8), len(line))
    words = np.resize([5, 2, 4, 4, 4, 1, 1], len(line))
    follows = np.append(facets[1:], total) - facets
    wide = (words == 4) & (follows > 4)  # which of its numbers are the coordinates?
    wrong = np.flatnonzero((line != expected) | (follows < words) | wide)
    if len(wrong):
        place = int(starts[facets[wrong[0]]])
        raise source.error(place, "this is not the line of a facet that belongs here")
    if len(line) % 7:
        raise source.failure("the file ends within a facet")


def _solids(source: Source, places: Indices, facets: Indices, triangles: Indices) -> Markers:
    """Named solids as markers; a solid begins at a place of the text and with a facet."""
    markers: Markers = {}
    begins = [
        (source.data[place : source.line_end(place)].split(None, 1), int(facet))
        for place, facet in zip(places.tolist(), facets, strict=True)
    ]
    for k, (words, facet) in enumerate(begins):
        end = begins[k + 1][1] if k + 1 < len(begins) else len(triangles)
        if words[0].lower() == b"solid" and len(words) > 1 and end > facet:
            name = decoded(words[1].strip())
            markers[name] = {"triangle": triangles[facet:end]}
    return markers


def merged(vertices: Array) -> tuple[Array, Indices]:
    """Nodes with different coordinates in the order of their first use, and each row's node."""
    order = np.lexsort(vertices.T)
    new = np.ones(len(vertices), dtype=bool)
    new[1:] = (vertices[order[1:]] != vertices[order[:-1]]).any(axis=1)
    group = np.cumsum(new) - 1
    first = np.full(int(new.sum()), len(vertices))
    np.minimum.at(first, group, order)
    rank = np.empty_like(first)
    by_use = np.argsort(first)
    rank[by_use] = np.arange(len(first))
    slots = np.empty(len(vertices), dtype=np.int64)
    slots[order] = rank[group]
    return vertices[first[by_use]], slots


def write_new(mesh: Mesh, path: Path) -> None:
    """Write the surface of a mesh as binary STL, quads cut into triangles."""
    triangles = triangulated(mesh)
    record = np.zeros(
        len(triangles), dtype=[("normal", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]
    )
    record["normal"] = unit_normals(mesh.points, triangles)
    record["v"] = mesh.points[triangles]
    head = b"FFD Studio".ljust(80) + struct.pack("<I", len(triangles))
    write_bytes(path, head + record.tobytes())


def triangulated(mesh: Mesh) -> Indices:
    """(k, 3) triangles of the surface of a mesh: polygons as fans."""
    fans = [
        np.stack([nodes[:, 0], nodes[:, k], nodes[:, k + 1]], axis=1)
        for nodes in mesh.surface().values()
        for k in range(1, nodes.shape[1] - 1)
    ]
    return np.concatenate(fans) if fans else np.empty((0, 3), dtype=np.int64)
