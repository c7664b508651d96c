"""AVS-UCD meshes, which end in .inp as Abaqus decks do (also .avs, .ucd)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import (
    line_firsts,
    pick_anywhere,
    pick_numbers,
    split_tokens,
)
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import Cells

TYPES = {  # name -> ours, and VTK's order of the nodes
    b"pt": ("vertex", [0]),
    b"line": ("line", [0, 1]),
    b"tri": ("triangle", [0, 1, 2]),
    b"quad": ("quad", [0, 1, 2, 3]),
    b"tet": ("tetra", [0, 1, 3, 2]),
    b"pyr": ("pyramid", [1, 2, 3, 4, 0]),
    b"prism": ("wedge", [3, 4, 5, 0, 1, 2]),
    b"hex": ("hexahedron", [4, 5, 6, 7, 0, 1, 2, 3]),
}


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an AVS-UCD mesh; see `read_mesh`. Materials become markers."""
    source = Source(path, data)
    begin = 0
    while data[begin : begin + 1] == b"#":
        begin = source.line_end(begin)
    starts, ends = split_tokens(data[begin:])
    first = line_firsts(data[begin:], starts)
    starts, ends = starts + begin, ends + begin
    if len(first) < 2 or first[1] != 5:
        raise source.error(begin, "an AVS-UCD file begins with a line of five counts")
    nodes, cells = (source.integer(data[starts[k] : ends[k]], begin, "a count") for k in range(2))
    if nodes + cells > len(first) - 1:
        raise source.error(
            begin, f"{nodes} nodes and {cells} cells announced, {len(first) - 1} lines follow"
        )
    first = np.append(first, len(starts))
    if (np.diff(first[1 : nodes + cells + 2]) < 4).any():
        bad = 1 + int(np.flatnonzero(np.diff(first[1 : nodes + cells + 2]) < 4)[0])
        raise source.error(int(starts[first[bad]]), "this line is too short")
    wide = np.flatnonzero(np.diff(first[1 : nodes + 2]) != 4)
    if len(wide):
        place = int(starts[first[1 + wide[0]]])
        raise source.error(place, "a node has an index and three coordinates")
    where = first[1 : nodes + 1][:, None] + np.arange(1, 4)
    points = pick_numbers(source, starts[where].ravel(), ends[where].ravel()).reshape(-1, 3)
    ids = pick_numbers(source, starts[first[1 : nodes + 1]], ends[first[1 : nodes + 1]], np.int64)
    template = TextTemplate(data, points, starts[where], ends[where])
    found, materials = _cells(source, first[nodes + 1 : nodes + cells + 2], starts, ends, ids)
    markers = {
        f"material {number}": {
            kind: rows[materials[kind] == number]
            for kind, rows in found.items()
            if (materials[kind] == number).any()
        }
        for number in np.unique(np.concatenate([*materials.values(), np.empty(0, dtype=np.int64)]))
    }
    return Mesh(points, found, markers, template=template)


def _cells(
    source: Source, first: Indices, starts: Indices, ends: Indices, ids: Indices
) -> tuple[Cells, dict[str, Indices]]:
    """Cells by type and the material of each."""
    order = np.argsort(ids, kind="stable")
    words = [source.data[starts[k] : ends[k]] for k in first[:-1] + 2]
    cells, materials = {}, {}
    for name in dict.fromkeys(words):
        rows = np.array([k for k, word in enumerate(words) if word == name])
        place = int(starts[first[rows[0]]])
        if name not in TYPES:
            raise source.error(
                place, f"cells of type {name[:10].decode('latin-1')!r} are not known"
            )
        kind, nodes = TYPES[name]
        if (np.diff(first)[rows] != 3 + len(nodes)).any():
            raise source.error(place, f"a {kind} with another number of nodes than {len(nodes)}")
        where = first[rows][:, None] + 3 + np.array(nodes)
        given = pick_anywhere(source, starts[where], ends[where], np.int64)
        if not len(ids):
            raise source.failure("there are cells but no nodes")
        found = np.minimum(np.searchsorted(ids[order], given), len(ids) - 1)
        if (ids[order][found] != given).any():
            missing = given[ids[order][found] != given][0]
            raise source.failure(f"a cell refers to node {missing}, which is not there")
        cells[kind] = order[found]
        materials[kind] = pick_numbers(
            source, starts[first[rows] + 1], ends[first[rows] + 1], np.int64
        )
    return cells, materials
