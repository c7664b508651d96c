"""Exodus II meshes (.exo, .e, .g, ...): netCDF files, classic or HDF5.

1. Coordinates are the variables coordx, coordy, coordz, or the rows of coord in old files.
2. Element blocks become cells and, if there are several, markers. Side sets become markers of
   faces, node sets markers of vertices.

Source: G. D. Sjaardema and others, "EXODUS II: A finite element data model", SAND92-2137.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.hdftemplate import DatasetPlace, HdfTemplate, Piece
from ffdstudio.meshes.formats.netcdf import Variable, variables
from ffdstudio.meshes.formats.patch import BinaryTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import MIDDLE_BEFORE_TOP, polygon_name
from ffdstudio.meshes.mesh import Markers, Mesh, Template
from ffdstudio.meshes.topology import Cells, base_type

TYPES = {  # begin of the name -> by number of nodes
    "HEX": {8: "hexahedron", 20: "hexahedron20", 27: "hexahedron27"},
    "TET": {4: "tetra", 10: "tetra10"},
    "WED": {6: "wedge", 15: "wedge15"},
    "PYR": {5: "pyramid", 13: "pyramid13"},
    "QUA": {4: "quad", 8: "quad8", 9: "quad9"},
    "SHE": {3: "triangle", 4: "quad", 8: "quad8", 9: "quad9"},
    "TRI": {3: "triangle", 6: "triangle6"},
    "BAR": {2: "line", 3: "line3"},
    "BEA": {2: "line", 3: "line3"},
    "TRU": {2: "line", 3: "line3"},
    "EDG": {2: "line", 3: "line3"},
    "SPH": {1: "vertex"},
    "CIR": {1: "vertex"},
}
SIDES: dict[str, list[tuple[int, ...]]] = {
    "hexahedron": [
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (0, 4, 7, 3),
        (0, 3, 2, 1),
        (4, 5, 6, 7),
    ],
    "tetra": [(0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)],
    "wedge": [(0, 1, 4, 3), (1, 2, 5, 4), (0, 3, 5, 2), (0, 2, 1), (3, 4, 5)],
    "pyramid": [(0, 1, 4), (1, 2, 4), (2, 3, 4), (0, 4, 3), (0, 3, 2, 1)],
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
}


class ElementBlock(NamedTuple):
    """Cells of one element block; elements are numbered through all blocks from `first`."""

    name: str
    kind: str
    nodes: Indices
    first: int
    is_shell: bool


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an Exodus mesh; see `read_mesh`."""
    source = Source(path, data)
    found = variables(source)
    template, axes = _template(source, found)
    progress(0.5)
    blocks = _blocks(source, found, len(template.original), axes)
    cells: dict[str, list[Indices]] = {}
    for block in blocks:
        cells.setdefault(block.kind, []).append(block.nodes)
    markers: Markers = {}
    if len(blocks) > 1:
        for block in blocks:
            _add(markers, block.name, "block", {block.kind: block.nodes})
    _side_sets(source, found, blocks, markers)
    _node_sets(source, found, len(template.original), markers)
    joined = {kind: np.concatenate(nodes) for kind, nodes in cells.items()}
    return Mesh(template.original, joined, markers, dimension=axes, template=template)


def _template(source: Source, found: dict[str, Variable]) -> tuple[Template, int]:
    rows = [found[name] for name in ("coordx", "coordy", "coordz") if name in found]
    if not rows and "coord" in found and len(found["coord"].shape) == 2:
        rows = [found["coord"].row(k) for k in range(found["coord"].shape[0])]
    if len(rows) not in (2, 3) or any(row.dtype.kind != "f" for row in rows):
        raise source.failure("there are no coordinates (coordx, coordy, coordz): no Exodus file?")
    if len({row.shape for row in rows}) > 1 or len({row.dtype for row in rows}) > 1:
        raise source.failure("the arrays of coordinates do not fit each other")
    count, dtype = rows[0].shape[0], rows[0].dtype
    points = np.zeros((count, 3))
    for axis, row in enumerate(rows):
        with np.errstate(invalid="ignore"):
            points[:, axis] = row.values
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"node {bad[0] + 1} has a coordinate that is not finite")
    if all(row.place >= 0 for row in rows):
        places = np.array([row.place for row in rows]) + dtype.itemsize * np.arange(count)[:, None]
        return BinaryTemplate(source.data, points, dtype, places), len(rows)
    if "coord" in found:
        raise source.failure("its coordinates are stored in pieces, which is not supported here")
    arrays = tuple(DatasetPlace(f"/{row.name}", -1, dtype) for row in rows)
    index = np.repeat(np.arange(count)[:, None], len(rows), axis=1)
    pieces = [Piece(arrays, index, np.arange(count))]
    return HdfTemplate(source, points, pieces, dtype), len(rows)


def _names(found: dict[str, Variable], key: str) -> list[str]:
    return found[key].texts() if key in found and found[key].dtype.kind == "S" else []


def _name(names: list[str], number: int, default: str) -> str:
    own = names[number - 1] if number <= len(names) else ""
    return own or f"{default} {number}"


def _blocks(
    source: Source, found: dict[str, Variable], count: int, axes: int
) -> list[ElementBlock]:
    names, first = _names(found, "eb_names"), 1
    blocks: list[ElementBlock] = []
    for number in range(1, len(found) + 1):
        variable = found.get(f"connect{number}")
        if variable is None:
            continue
        if len(variable.shape) != 2 or variable.dtype.kind not in "iu":
            raise source.failure(f"element block {number} is damaged")
        title = variable.attributes.get("elem_type", "").upper()
        kind = TYPES.get(title[:3], {}).get(variable.shape[1])
        if kind is None:
            raise source.failure(
                f"element block {number} has elements of type {title or 'unknown'} "
                f"with {variable.shape[1]} nodes, which are not supported"
            )
        nodes = variable.values.astype(np.int64) - 1
        if nodes.size and not (nodes.min() >= 0 and nodes.max() < count):
            raise source.failure(f"element block {number} refers to a node not in 1 to {count}")
        if kind in MIDDLE_BEFORE_TOP:
            nodes = nodes[:, MIDDLE_BEFORE_TOP[kind]]
        shell = axes == 3 and base_type(kind) in ("triangle", "quad")
        blocks.append(ElementBlock(_name(names, number, "block"), kind, nodes, first, shell))
        first += len(nodes)
    return blocks


def _add(markers: Markers, name: str, what: str, cells: Cells) -> None:
    """Add a marker; of several with the same name the later ones get their kind and a number."""
    title, number = name, 1
    while title in markers:
        title = f"{name} ({what})" if number == 1 else f"{name} ({what} {number})"
        number += 1
    markers[title] = cells


def _side_sets(
    source: Source, found: dict[str, Variable], blocks: list[ElementBlock], markers: Markers
) -> None:
    names = _names(found, "ss_names")
    for number in range(1, len(found) + 1):
        elements, sides = found.get(f"elem_ss{number}"), found.get(f"side_ss{number}")
        if elements is None or sides is None:
            continue
        if (
            elements.shape != sides.shape
            or elements.dtype.kind not in "iu"
            or sides.dtype.kind not in "iu"
        ):
            raise source.failure(f"side set {number} is damaged")
        cells = _faces(elements.values.astype(np.int64), sides.values.astype(np.int64), blocks)
        _add(markers, _name(names, number, "side set"), "side set", cells)


def _faces(elements: Indices, sides: Indices, blocks: list[ElementBlock]) -> Cells:
    """Faces of elements, both counted from 1."""
    parts: dict[str, list[Indices]] = {}
    for block in blocks:
        inside = (elements >= block.first) & (elements < block.first + len(block.nodes))
        shapes = list(SIDES.get(base_type(block.kind), []))
        if block.is_shell:  # two faces, then the edges
            whole = tuple(range(3 if base_type(block.kind) == "triangle" else 4))
            shapes = [whole, whole[::-1], *shapes]
        for side, shape in enumerate(shapes, start=1):
            rows = elements[inside & (sides == side)] - block.first
            if len(rows):
                faces = block.nodes[rows][:, list(shape)]
                parts.setdefault(polygon_name(len(shape)), []).append(faces)
    return {kind: np.concatenate(faces) for kind, faces in parts.items()}


def _node_sets(source: Source, found: dict[str, Variable], count: int, markers: Markers) -> None:
    names = _names(found, "ns_names")
    for number in range(1, len(found) + 1):
        variable = found.get(f"node_ns{number}")
        if variable is None:
            continue
        nodes = variable.values.astype(np.int64).reshape(-1, 1) - 1
        if nodes.size and not (nodes.min() >= 0 and nodes.max() < count):
            raise source.failure(f"node set {number} refers to a node not in 1 to {count}")
        _add(markers, _name(names, number, "node set"), "node set", {"vertex": nodes})
