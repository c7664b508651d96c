"""A mesh from the zones of faces of a Fluent file, in text or in HDF5.

1. In three dimensions the mesh stays one of faces; in two, the edges around a cell are
   chained into triangles, quads and polygons.
2. On which side of a face its first cell lies is measured, not believed: writers differ.
3. A periodic zone and its shadow are partners. Their faces are put in the order in which the
   file pairs them, so that partners correspond.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import offsets_of, polygon_name
from ffdstudio.meshes.mesh import Faces, Markers, Mesh, Template, boundary_faces
from ffdstudio.meshes.topology import Cells

INTERIOR = 2
KINDS = {3: "wall", 7: "symmetry", 8: "periodic", 12: "periodic"}
SHADOWS = ("shadow", "periodic-shadow")


class Side(NamedTuple):
    """Faces of one zone: flat nodes with offsets, and the cells on both sides from 1; 0: none."""

    number: int
    first: int  # its first face, from 1
    type: int
    nodes: Indices
    offsets: Indices
    cells: Indices


class Partners(NamedTuple):
    """A periodic zone, its shadow, and (k, 2) numbers of faces that correspond, maybe none."""

    zone: int
    shadow: int
    faces: Indices


def mesh_of(
    source: Source,
    template: Template,
    sides: list[Side],
    names: dict[int, tuple[str, str]],
    pairs: list[Partners],
    dimension: int,
) -> Mesh:
    """Mesh from zones; `names` has the type and name of a zone by its number."""
    sides = [_in_order(side, pairs) for side in sides]
    titles = _titles(sides, names)
    known = [pair for pair in pairs if pair.zone in titles and pair.shadow in titles]
    partners = {titles[pair.zone][0]: titles[pair.shadow][0] for pair in known}
    kinds = dict(titles.values())
    build = _plane if dimension == 2 else _solid
    mesh = build(source, template, sides, titles)
    kinds = {name: kind for name, kind in kinds.items() if name in mesh.markers}
    return Mesh(
        mesh.points,
        mesh.cells,
        mesh.markers,
        mesh.dimension,
        mesh.faces,
        kinds,
        partners,
        template=template,
    )


def _in_order(side: Side, pairs: list[Partners]) -> Side:
    """Zone whose paired faces come first, in the order of the pairs."""
    columns = [(pair.zone, pair.faces[:, 0]) for pair in pairs]
    columns += [(pair.shadow, pair.faces[:, 1]) for pair in pairs]
    listed = [faces - side.first for zone, faces in columns if zone == side.number and len(faces)]
    many = len(side.cells)
    if not listed or listed[0].min() < 0 or listed[0].max() >= many:
        return side
    order = np.concatenate([listed[0], np.setdiff1d(np.arange(many), listed[0])])
    if len(order) != many:
        return side
    sizes = np.diff(side.offsets)[order]
    offsets = offsets_of(sizes)
    places = np.repeat(side.offsets[:-1][order] - offsets[:-1], sizes) + np.arange(offsets[-1])
    return side._replace(nodes=side.nodes[places], offsets=offsets, cells=side.cells[order])


def _titles(sides: list[Side], names: dict[int, tuple[str, str]]) -> dict[int, tuple[str, str]]:
    """Name and kind of each zone; a second zone of the same name keeps its number."""
    titles: dict[int, tuple[str, str]] = {}
    for side in sides:
        name, kind = _name(side, names)
        if any(name == other for other, _ in titles.values()):
            name = f"{name} ({side.number})"
        titles[side.number] = name, kind
    return titles


def _name(side: Side, names: dict[int, tuple[str, str]]) -> tuple[str, str]:
    kind, name = names.get(side.number, ("", f"zone {side.number}"))
    kind = "periodic" if kind in SHADOWS else kind
    return name, kind or KINDS.get(side.type, "patch")


def _joined(source: Source, zones: list[Side]) -> tuple[Indices, Indices, Indices]:
    """Nodes, offsets and cells of all faces, zone after zone."""
    if not zones:
        raise source.failure("there are no faces (13 ...) in this file")
    nodes = np.concatenate([zone.nodes for zone in zones])
    sizes = np.concatenate([np.diff(zone.offsets) for zone in zones])
    cells = np.concatenate([zone.cells for zone in zones]) - 1
    most = len(sizes) * 2
    if cells.size and cells.max() >= most:
        raise source.failure("a face belongs to a cell that cannot be there")
    return nodes, offsets_of(sizes), cells


def _solid(
    source: Source, template: Template, zones: list[Side], titles: dict[int, tuple[str, str]]
) -> Mesh:
    nodes, offsets, cells = _joined(source, zones)
    lone = cells[:, 0] < 0  # the only cell stands second: turn the face round
    inward = _points_inward(template.original, nodes, offsets, cells)
    turned = np.where(lone, not inward, inward)
    owner = np.where(lone, cells[:, 1], cells[:, 0])
    faces = Faces(_turned(nodes, offsets, turned), offsets, owner, np.where(lone, -1, cells[:, 1]))
    markers: Markers = {}
    first = 0
    for zone in zones:
        count = len(zone.cells)
        if zone.type != INTERIOR:
            name, _ = titles[zone.number]
            markers[name] = boundary_faces(faces, np.arange(first, first + count))
        first += count
    return Mesh(template.original, {}, markers, faces=faces)


def _points_inward(points: Array, nodes: Indices, offsets: Indices, cells: Indices) -> bool:
    """Whether the faces' normals by the right-hand rule point into their first cell."""
    size = np.maximum(np.diff(offsets), 1)[:, None]
    centre = np.add.reduceat(points[nodes], np.minimum(offsets[:-1], len(nodes) - 1)) / size
    many = int(cells.max()) + 2
    middle, count = np.zeros((many, 3)), np.zeros((many, 1))
    for side in (0, 1):
        np.add.at(middle, cells[:, side], centre)
        np.add.at(count, cells[:, side], 1)
    middle /= np.maximum(count, 1)
    begin = np.minimum(offsets[:-1], len(nodes) - 3)
    a, b, c = (points[nodes[begin + k]] for k in range(3))
    outward = ((centre - middle[cells[:, 0]]) * np.cross(b - a, c - a)).sum(axis=1)
    return int((outward < 0)[cells[:, 0] >= 0].sum()) * 2 > len(outward)


def _turned(nodes: Indices, offsets: Indices, turned: np.ndarray) -> Indices:
    """Nodes with the order of some faces reversed."""
    of_face = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    place = np.arange(len(nodes))
    mirrored = offsets[of_face] + offsets[of_face + 1] - 1 - place
    return nodes[np.where(turned[of_face], mirrored, place)]


def _plane(
    source: Source, template: Template, zones: list[Side], titles: dict[int, tuple[str, str]]
) -> Mesh:
    nodes, offsets, cells = _joined(source, zones)
    if (np.diff(offsets) != 2).any():
        raise source.failure("in two dimensions a face has two nodes")
    edges = nodes.reshape(-1, 2)
    markers: Markers = {}
    for zone in zones:
        if zone.type != INTERIOR:
            markers[titles[zone.number][0]] = {"line": zone.nodes.reshape(-1, 2)}
    found = {
        kind: _anticlockwise(template.original, chain)
        for kind, chain in _chained(source, edges, cells).items()
    }
    return Mesh(template.original, found, markers, dimension=2)


def _chained(source: Source, edges: Indices, cells: Indices) -> Cells:
    """Polygons from the edges around each cell, which the first cell has on one side."""
    sides = np.concatenate([edges[:, ::-1], edges])
    owner = np.concatenate([cells[:, 0], cells[:, 1]])
    sides, owner = sides[owner >= 0], owner[owner >= 0]
    order = np.argsort(owner, kind="stable")
    sides, owner = sides[order], owner[order]
    begin = np.flatnonzero(np.append(True, np.diff(owner) != 0))
    sizes = np.diff(np.append(begin, len(owner)))
    found: Cells = {}
    for size in np.unique(sizes).tolist():
        rows = sides[begin[sizes == size][:, None] + np.arange(size)]
        chain = [rows[:, 0, 0], rows[:, 0, 1]]
        for _ in range(size - 2):
            follows = rows[:, :, 0] == chain[-1][:, None]
            chain.append(rows[np.arange(len(rows)), follows.argmax(axis=1), 1])
            if not follows.any(axis=1).all():
                raise source.failure("the edges around a cell do not close")
        found[polygon_name(size)] = np.stack(chain, axis=1)
    return found


def _anticlockwise(points: Array, chain: Indices) -> Indices:
    """Polygons all turned round if most of them run clockwise."""
    x, y = points[chain, 0], points[chain, 1]
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    return chain[:, ::-1] if np.median(area) < 0 else chain
