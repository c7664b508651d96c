"""Wavefront OBJ surfaces.

1. A line counts by its first word: ``v`` a vertex, ``f`` a face, ``l`` a line, ``g`` and ``o``
   begin a group or object; everything else is kept and not looked at.
2. A face's vertex may be ``7``, ``7/2``, ``7//3`` or ``-1``, counted back from the last vertex.
3. Vertex normals (``vn``) do not follow a morph; writing a moved mesh that has some says so.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.normals import WithNormals
from ffdstudio.meshes.formats.number_table import line_firsts, pick_numbers, split_tokens
from ffdstudio.meshes.formats.patch import TextTemplate, shortest
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells

_COMMENT = re.compile(rb"(?<!\S)#[^\n]*")


class Lines(NamedTuple):
    """Words of a file: begin and end of each, the first one of each line, words in each line."""

    source: Source
    starts: Indices
    ends: Indices
    first: Indices
    widths: Indices

    @classmethod
    def of(cls, source: Source) -> Lines:
        """Split a file into lines and words, comments left out."""
        text = source.data
        if b"#" in text:
            text = _COMMENT.sub(lambda match: b" " * len(match[0]), text)
        if b"\\" in text:  # a line goes on behind a backslash
            text = re.sub(rb"\\\r?\n", lambda match: b" " * len(match[0]), text)
        starts, ends = split_tokens(text)
        first = line_firsts(text, starts)
        return cls(source, starts, ends, first, np.diff(np.append(first, len(starts))))

    def beginning(self, word: bytes) -> Indices:
        """Lines whose first word is this one."""
        place, size = self.starts[self.first], self.ends[self.first] - self.starts[self.first]
        letters = np.frombuffer(self.source.data + bytes(len(word)), dtype=np.uint8)
        fits = size == len(word)
        for k, letter in enumerate(word):
            fits &= letters[place + k] == letter
        return np.flatnonzero(fits)


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an OBJ file; see `read_mesh`."""
    source = Source(path, data)
    lines = Lines.of(source)
    vertices = lines.beginning(b"v")
    _need(lines, vertices, 4, "a vertex needs x, y and z")
    wide = vertices[~np.isin(lines.widths[vertices], (4, 5, 7, 8))]
    if len(wide):  # besides x, y, z a weight, a colour or both are known
        place = int(lines.starts[lines.first[wide[0]]])
        raise source.error(place, f"a vertex of {lines.widths[wide[0]] - 1} numbers is not known")
    where = lines.first[vertices][:, None] + np.arange(1, 4)
    starts, ends = lines.starts[where], lines.ends[where]
    if not len(vertices):
        raise source.failure("there is no vertex (v) in this file")
    points = pick_numbers(source, starts.ravel(), ends.ravel()).reshape(-1, 3)
    cells, order = _elements(lines, vertices)
    plain = TextTemplate(data, points, starts, ends)
    template = WithNormals(plain, "vertex normals (vn)") if len(lines.beginning(b"vn")) else plain
    rows = lines.beginning(b"g")
    markers = _groups(lines, cells, order, rows if len(rows) else lines.beginning(b"o"))
    for name, part in _groups(lines, cells, order, lines.beginning(b"usemtl")).items():
        markers[f"{name} (material)" if name in markers else name] = part
    return Mesh(points, cells, markers, template=template)


def _need(lines: Lines, chosen: Indices, words: int, message: str) -> None:
    short = np.flatnonzero(lines.widths[chosen] < words)
    if len(short):
        raise lines.source.error(int(lines.starts[lines.first[chosen[short[0]]]]), message)


def _elements(lines: Lines, vertices: Indices) -> tuple[Cells, dict[str, Indices]]:
    """Faces and lines by type, and the line of the file that each one stands in."""
    cells, order = {}, {}
    faces, edges = lines.beginning(b"f"), lines.beginning(b"l")
    _need(lines, faces, 4, "a face needs at least three vertices")
    _need(lines, edges, 3, "a line needs two vertices")
    for rows, widths in ((edges, None), (faces, lines.widths[faces] - 1)):
        for size in [2] if widths is None else np.unique(widths).tolist():
            chosen = rows if widths is None else rows[widths == size]
            name = {2: "line", 3: "triangle", 4: "quad"}.get(size, f"polygon{size}")
            if len(chosen):
                cells[name], order[name] = _nodes(lines, chosen, size, vertices), chosen
    return cells, order


def _nodes(lines: Lines, chosen: Indices, size: int, vertices: Indices) -> Indices:
    where = (lines.first[chosen][:, None] + np.arange(1, size + 1)).ravel()
    starts, ends = lines.starts[where], lines.ends[where]
    slashes = np.flatnonzero(np.frombuffer(lines.source.data, dtype=np.uint8) == ord("/"))
    slashes = np.append(slashes, len(lines.source.data))
    ends = np.minimum(ends, slashes[np.searchsorted(slashes, starts)])
    given = pick_numbers(lines.source, starts, ends, np.int64).reshape(-1, size)
    before = np.searchsorted(vertices, chosen)[:, None]
    nodes = np.where(given < 0, before + given, given - 1)
    wrong = np.flatnonzero(((nodes < 0) | (nodes >= len(vertices))).any(axis=1))
    if len(wrong):
        place = int(lines.starts[lines.first[chosen[wrong[0]]]])
        raise lines.source.error(place, f"a vertex index is not in 1 to {len(vertices)}")
    return nodes


def _groups(lines: Lines, cells: Cells, order: dict[str, Indices], rows: Indices) -> Markers:
    """What stands behind lines that begin a group, an object or a material, by their names."""
    members: dict[str, list[int]] = {}
    for k, row in enumerate(rows.tolist()):
        place = int(lines.starts[lines.first[row]])
        text = lines.source.data[place : lines.source.line_end(place)].split(None, 1)[1:]
        members.setdefault(decoded(b"".join(text)).strip(), []).append(k)
    of_cell = {kind: np.searchsorted(rows, at) - 1 for kind, at in order.items()}
    markers: Markers = {}
    for name, numbers in members.items():
        inside = {kind: nodes[np.isin(of_cell[kind], numbers)] for kind, nodes in cells.items()}
        found = {kind: nodes for kind, nodes in inside.items() if len(nodes)}
        if name and found:
            markers[name] = found
    return markers


def write_new(mesh: Mesh, path: Path) -> None:
    """Write the surface of a mesh as OBJ."""
    numbers = shortest(mesh.points.ravel().tolist())
    rows = ["v " + " ".join(numbers[k : k + 3]) for k in range(0, len(numbers), 3)]
    for nodes in mesh.surface().values():
        letter = "l " if nodes.shape[1] == 2 else "f "
        rows += [letter + " ".join(map(str, row)) for row in (nodes + 1).tolist()]
    write_bytes(path, ("\n".join(rows) + "\n").encode())
