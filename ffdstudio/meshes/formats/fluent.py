"""Fluent meshes (.msh, .cas): faces with the cells on both sides, in text and in binary sections.

1. A file is sections in round brackets; numbers in heads and faces are hexadecimal, coordinates
   decimal. Nodes may come in several zones.
2. Binary sections hold the coordinates as singles or doubles, little end first.

Source: Fluent user's guide, "Mesh and case file format".
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.fluent_faces import partners_of, side_of, tokens
from ffdstudio.meshes.formats.fluent_mesh import mesh_of
from ffdstudio.meshes.formats.fluent_sections import FluentSections, Zone, sections_of
from ffdstudio.meshes.formats.number_table import pick_anywhere
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Mesh


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Fluent mesh; see `read_mesh`."""
    source = Source(path, data)
    sections = sections_of(source)
    progress(0.1)
    template = _template(source, sections)
    progress(0.4)
    sides = [side_of(source, zone, len(template.original)) for zone in sections.faces]
    pairs = [partners_of(source, zone) for zone in sections.pairs]
    progress(0.8)
    return mesh_of(source, template, sides, sections.names, pairs, sections.dimension)


def _template(source: Source, sections: FluentSections) -> TextTemplate | BinaryTemplate:
    zones = sorted(sections.nodes, key=lambda zone: zone.head[1])
    expected = 1
    for zone in zones:
        _, first, last, *_ = zone.head
        axes = zone.word(4) or sections.dimension
        if axes != sections.dimension or first != expected or last < first - 1:
            raise source.error(zone.begin, "the nodes of this zone do not follow those before")
        expected = last + 1
    if not zones:
        raise source.failure("there are no nodes (10 ...) in this file")
    if len({zone.real for zone in zones}) > 1:
        raise source.failure("zones of nodes in text and in binary in one file")
    return (_binary if zones[0].real else _text)(source, zones, sections.dimension)


def _text(source: Source, zones: list[Zone], axes: int) -> TextTemplate:
    parts: list[tuple[Indices, Indices]] = []
    for zone in zones:
        many = zone.head[2] - zone.head[1] + 1
        starts, ends = tokens(source, zone)
        if len(starts) != many * axes:
            raise source.error(
                zone.begin, f"{many} nodes announced, found {len(starts)} coordinates"
            )
        parts.append((starts.reshape(-1, axes), ends.reshape(-1, axes)))
    starts, ends = (np.concatenate([part[k] for part in parts]) for k in range(2))
    points = np.zeros((len(starts), 3))
    points[:, :axes] = pick_anywhere(source, starts, ends)
    return TextTemplate(source.data, points, starts, ends)


def _binary(source: Source, zones: list[Zone], axes: int) -> BinaryTemplate:
    dtype = np.dtype(f"<f{zones[0].real}")
    parts, places = [], []
    for zone in zones:
        many = zone.head[2] - zone.head[1] + 1
        size = many * axes
        if zone.begin + size * dtype.itemsize > zone.end:
            raise source.error(zone.begin, f"{many} nodes announced, the section is too short")
        with np.errstate(invalid="ignore"):
            values = np.frombuffer(source.data, dtype, size, zone.begin).astype(np.float64)
        parts.append(values.reshape(many, axes))
        places.append(zone.begin + dtype.itemsize * np.arange(size).reshape(many, axes))
    points = np.zeros((sum(map(len, parts)), 3))
    points[:, :axes] = np.concatenate(parts)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"node {bad[0] + 1} has a coordinate that is not finite")
    return BinaryTemplate(source.data, points, dtype, np.concatenate(places))
