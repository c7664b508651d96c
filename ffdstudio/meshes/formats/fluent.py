"""Fluent meshes (.msh, .cas) in ASCII: faces with the cells on both sides.

1. A file is sections in round brackets; numbers in heads and faces are hexadecimal, coordinates
   decimal. Nodes may come in several zones.
2. In three dimensions the mesh stays one of faces; in two, the edges around a cell are
   chained into triangles, quads and polygons.
3. On which side of a face its first cell lies is measured, not believed: writers differ.
4. Binary sections (2010, 3010, ...) are refused.

Source: Fluent user's guide, "Mesh and case file format".
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.fluent_sections import Sections, Zone, sections_of
from ffdstudio.meshes.formats.number_table import pick_anywhere, split_tokens
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import offsets_of, polygon_name
from ffdstudio.meshes.mesh import Faces, Markers, Mesh, boundary_faces
from ffdstudio.meshes.topology import Array, Cells, Indices

INTERIOR = 2
KINDS = {3: "wall", 7: "symmetry", 8: "periodic", 12: "periodic"}


class Side(NamedTuple):
    """Faces of one zone: flat nodes with offsets, and the cells on both sides from 1; 0: none."""

    zone: list[int]
    nodes: Indices
    offsets: Indices
    cells: Indices


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Fluent mesh; see `read_mesh`."""
    source = Source(path, data)
    sections = sections_of(source)
    progress(0.1)
    template = _template(source, sections)
    progress(0.4)
    zones = [_faces(source, zone, len(template.original)) for zone in sections.faces]
    progress(0.8)
    if sections.dimension == 2:
        return _plane(source, template, zones, sections)
    return _solid(source, template, zones, sections)


def _template(source: Source, sections: Sections) -> TextTemplate:
    parts: list[tuple[Indices, Indices]] = []
    for zone in sorted(sections.nodes, key=lambda zone: zone.head[1]):
        axes = zone.head[4] if len(zone.head) > 4 else sections.dimension
        expected = 1 + sum(len(part[0]) for part in parts)
        _, first, last, *_ = zone.head
        starts, ends = _tokens(source, zone)
        if axes != sections.dimension or first != expected:
            raise source.error(zone.begin, "the nodes of this zone do not follow those before")
        if len(starts) != (last - first + 1) * axes:
            raise source.error(
                zone.begin, f"{last - first + 1} nodes announced, found {len(starts)} coordinates"
            )
        parts.append((starts.reshape(-1, axes), ends.reshape(-1, axes)))
    if not parts:
        raise source.failure("there are no nodes (10 ...) in this file")
    starts, ends = (np.concatenate([part[k] for part in parts]) for k in range(2))
    points = np.zeros((len(starts), 3))
    points[:, : sections.dimension] = pick_anywhere(source, starts, ends)
    return TextTemplate(source.data, points, starts, ends)


def _tokens(source: Source, zone: Zone) -> tuple[Indices, Indices]:
    starts, ends = split_tokens(source.data[zone.begin : zone.end])
    return starts + zone.begin, ends + zone.begin


def _hexadecimal(source: Source, zone: Zone) -> Indices:
    """Numbers of a section, digit by digit for all of them at once."""
    starts, ends = _tokens(source, zone)
    digit = np.full(256, 255, dtype=np.uint8)
    for value, letter in enumerate(b"0123456789abcdef"):
        digit[letter] = value
        digit[ord(chr(letter).upper())] = value
    digits = digit[np.frombuffer(source.data, dtype=np.uint8)[zone.begin : zone.end]]
    sizes = ends - starts
    values = np.zeros(len(starts), dtype=np.int64)
    if len(starts) and sizes.max() > 12:
        raise source.error(int(starts[sizes.argmax()]), "not a hexadecimal number")
    for k in range(int(sizes.max(initial=0))):
        longer = sizes > k
        found = digits[starts[longer] - zone.begin + k]
        if (found == 255).any():
            bad = starts[longer][found == 255][0]
            raise source.error(int(bad), "not a hexadecimal number")
        values[longer] = values[longer] * 16 + found
    return values


def _faces(source: Source, zone: Zone, nodes: int) -> Side:
    values = _hexadecimal(source, zone)
    count = zone.head[2] - zone.head[1] + 1
    size = zone.head[4] if len(zone.head) > 4 else 0
    if size in (2, 3, 4):
        if len(values) != count * (size + 2):
            raise source.error(zone.begin, f"{count} faces announced, not as many found")
        table = values.reshape(count, size + 2)
        flat, offsets, cells = table[:, :size].ravel(), size * np.arange(count + 1), table[:, size:]
    elif size in (0, 5):
        flat, offsets, cells = _mixed(source, zone, values, count)
    else:
        raise source.error(zone.begin, f"faces of type {size} are not known")
    if flat.size and not (flat.min() >= 1 and flat.max() <= nodes):
        raise source.error(zone.begin, f"a face refers to a node that is not in 1 to {nodes}")
    if count < 0 or ((cells == 0).all(axis=1)).any():
        raise source.error(zone.begin, "a face without cells")
    return Side(zone.head, flat - 1, offsets, cells)


def _mixed(
    source: Source, zone: Zone, values: Indices, count: int
) -> tuple[Indices, Indices, Indices]:
    """Faces that state their size first."""
    numbers, begins, at = values.tolist(), [], 0
    while at < len(numbers):
        begins.append(at)
        at += numbers[at] + 3
    if at != len(numbers) or len(begins) != count:
        raise source.error(zone.begin, f"{count} faces announced, not as many found")
    first = np.array(begins, dtype=np.int64)
    sizes = values[first]
    ends = first + 1 + sizes
    cells = values[ends[:, None] + np.arange(2)]
    flat = np.delete(values, np.concatenate([first, ends, ends + 1]))
    return flat, offsets_of(sizes), cells


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


def _solid(source: Source, template: TextTemplate, zones: list[Side], sections: Sections) -> Mesh:
    nodes, offsets, cells = _joined(source, zones)
    lone = cells[:, 0] < 0  # the only cell stands second: turn the face round
    inward = _points_inward(template.original, nodes, offsets, cells)
    turned = np.where(lone, not inward, inward)
    owner = np.where(lone, cells[:, 1], cells[:, 0])
    faces = Faces(_turned(nodes, offsets, turned), offsets, owner, np.where(lone, -1, cells[:, 1]))
    markers: Markers = {}
    kinds = {}
    first = 0
    for zone in zones:
        count = len(zone.cells)
        if zone.zone[3:4] != [INTERIOR]:
            name, kind = _name(sections, zone.zone)
            markers[name] = boundary_faces(faces, np.arange(first, first + count))
            kinds[name] = kind
        first += count
    return Mesh(template.original, {}, markers, faces=faces, kinds=kinds, template=template)


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


def _name(sections: Sections, head: list[int]) -> tuple[str, str]:
    kind, name = sections.names.get(head[0], ("", f"zone {head[0]}"))
    return name, kind or KINDS.get(head[3] if len(head) > 3 else 0, "patch")


def _plane(source: Source, template: TextTemplate, zones: list[Side], sections: Sections) -> Mesh:
    nodes, offsets, cells = _joined(source, zones)
    if (np.diff(offsets) != 2).any():
        raise source.failure("in two dimensions a face has two nodes")
    edges = nodes.reshape(-1, 2)
    markers: Markers = {}
    kinds = {}
    for zone in zones:
        if zone.zone[3:4] != [INTERIOR]:
            name, kind = _name(sections, zone.zone)
            markers[name], kinds[name] = {"line": zone.nodes.reshape(-1, 2)}, kind
    found = {
        kind: _anticlockwise(template.original, chain)
        for kind, chain in _chained(source, edges, cells).items()
    }
    return Mesh(template.original, found, markers, dimension=2, kinds=kinds, template=template)


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
