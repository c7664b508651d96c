"""The zones of cells and faces of an OpenFOAM mesh, as markers.

A zone of cells lists cells, which are faces here: its elements are the nodes of each cell, in no
order, under the type ``polyhedronN``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.foamfile import FoamFile
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.source import decoded
from ffdstudio.meshes.mesh import Faces, Markers, boundary_faces
from ffdstudio.meshes.topology import Cells

_ZONE = re.compile(
    rb'("[^"]*"|[^\s{}();"]+)\s*\{\s*type\s+(?:cell|face)Zone\s*;'
    rb"\s*(?:cell|face)Labels\s+(?:List<label>)?\s*(\d+)\s*([({;])"
)


def add_zones(folder: Path, faces: Faces, points: int, markers: Markers) -> None:
    """Add the zones of a mesh of so many points that are not empty to its markers.

    Raises
    ------
    InputError
        If one refers to a cell or face that is not there.
    """
    for what, count in (("cell", faces.cells), ("face", len(faces))):
        name = f"{what}Zones"
        if not (folder / name).exists() and not (folder / f"{name}.gz").exists():
            continue
        file = FoamFile.find(folder, name)
        for title, chosen in _lists(file):
            if chosen.size and not (chosen.min() >= 0 and chosen.max() < count):
                raise file.source.failure(
                    f"zone {title} refers to a {what} not in 0 to {count - 1}"
                )
            cells = (
                boundary_faces(faces, chosen) if what == "face" else _cells(faces, chosen, points)
            )
            if cells:
                markers[f"{title} ({what} zone)" if title in markers else title] = cells


def _lists(file: FoamFile) -> Iterator[tuple[str, Indices]]:
    """Names of the zones and the labels in each."""
    source, at = file.source, file.begin
    while match := _ZONE.search(source.data, at):
        count, at = int(match[2]), match.end()
        if match[3] == b"(" and file.is_binary and count:
            labels = file.binary(count, at, file.label).astype(np.int64)
            at += labels.size * file.label.itemsize
        else:
            end = (
                at if match[3] == b";" else source.data.find(b"}" if match[3] == b"{" else b")", at)
            )
            starts, ends = split_tokens(source.data[at : max(end, at)])
            labels = pick_numbers(source, starts + at, ends + at, np.int64)
            if match[3] == b"{" and len(labels) == 1 and count < len(source.data):
                labels = np.repeat(labels, count)  # 5{7}: five times the same
        name = decoded(match[1].strip(b'"'))
        if len(labels) != count:
            raise source.error(match.start(), f"zone {name} has {len(labels)} labels, not {count}")
        yield name, labels


def _cells(faces: Faces, chosen: Indices, points: int) -> Cells:
    """Nodes of cells, by their number."""
    inside = np.zeros(faces.cells, dtype=bool)
    inside[chosen] = True
    sizes = np.diff(faces.offsets)
    pairs = []
    for cells in (faces.owner, faces.neighbour):
        taken = (cells >= 0) & inside[cells]
        of_node = np.repeat(taken, sizes)
        pairs.append(np.repeat(cells[taken], sizes[taken]) * points + faces.nodes[of_node])
    cell, node = np.divmod(np.unique(np.concatenate(pairs)), points)
    begin = np.flatnonzero(np.append(True, cell[1:] != cell[:-1])) if len(cell) else cell
    counts = np.diff(np.append(begin, len(cell)))
    return {
        f"polyhedron{size}": node[begin[counts == size][:, None] + np.arange(size)]
        for size in np.unique(counts).tolist()
    }
