"""OFF surfaces: a keyword, counts, vertices, faces.

The keyword may have letters before it that tell what else a vertex holds (colours, normals);
x, y and z come first. Normals are kept as they were.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.normals import WithNormals
from ffdstudio.meshes.formats.number_table import Rows, read_rows
from ffdstudio.meshes.formats.patch import TextTemplate, shortest
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import polygon_name
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import Cells

_KEYWORD = re.compile(rb"(?:[ \t\r]*(?:#[^\n]*)?\n)*[ \t]*((?:ST)?C?N?)(4?n?)OFF\b(\s*BINARY)?")


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an OFF surface; see `read_mesh`."""
    source = Source(path, data)
    match = _KEYWORD.match(data)
    if match is not None and (match[2] or match[3]):
        raise source.error(match.start(), "only OFF in three dimensions and as text is supported")
    begin = match.end() if match else 0
    rows = read_rows(source, begin, len(data), np.float64, b"#", spans=True)
    if not len(rows) or rows.widths[0] not in (2, 3):
        raise source.failure("there are no counts of vertices and faces: no OFF surface?")
    vertices, faces = (int(n) for n in rows.values[:2])
    if vertices < 0 or faces < 0 or len(rows) < 1 + vertices + faces:
        raise source.failure(
            f"{vertices} vertices and {faces} faces are announced, found {len(rows) - 1} lines"
        )
    template = _vertices(source, rows, np.arange(1, 1 + vertices))
    cells = _faces(source, rows, 1 + vertices + np.arange(faces), vertices)
    normals = match is not None and b"N" in match[1]
    kept = WithNormals(template, "vertex normals") if normals else template
    return Mesh(template.original, cells, template=kept)


def _vertices(source: Source, rows: Rows, part: Indices) -> TextTemplate:
    short = np.flatnonzero(rows.widths[part] < 3)
    if len(short):
        raise source.error(int(rows.places[part[short[0]]]), "a vertex needs x, y and z")
    where = rows.first[part][:, None] + np.arange(3)
    points = rows.values[where]
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.error(int(rows.places[part[bad[0]]]), "a coordinate is not a finite number")
    return TextTemplate(source.data, points, rows.starts[where], rows.ends[where])


def _faces(source: Source, rows: Rows, part: Indices, count: int) -> Cells:
    sizes = rows.values[rows.first[part]]
    wrong = np.flatnonzero((sizes < 1) | (sizes % 1 != 0) | (sizes + 1 > rows.widths[part]))
    if len(wrong):
        raise source.error(int(rows.places[part[wrong[0]]]), "a face is incomplete")
    cells = {}
    for size in np.unique(sizes).astype(int).tolist():
        chosen = part[sizes == size]
        nodes = rows.values[rows.columns(size + 1, chosen)[:, 1:]]
        bad = np.flatnonzero(((nodes < 0) | (nodes >= count) | (nodes % 1 != 0)).any(axis=1))
        if len(bad):
            place = int(rows.places[chosen[bad[0]]])
            raise source.error(place, f"a face refers to a vertex not in 0 to {count - 1}")
        cells[polygon_name(size)] = nodes.astype(np.int64)
    return cells


def write_new(mesh: Mesh, path: Path) -> None:
    """Write the surface of a mesh as OFF."""
    faces = [row for nodes in mesh.surface().values() for row in nodes.tolist()]
    lines = ["OFF", f"{len(mesh.points)} {len(faces)} 0"]
    lines += [" ".join(shortest(row)) for row in mesh.points.tolist()]
    lines += [" ".join(map(str, [len(row), *row])) for row in faces]
    write_bytes(path, "\n".join([*lines, ""]).encode())
