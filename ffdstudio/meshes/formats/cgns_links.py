"""Connections of CGNS zones whose vertices correspond one to one, periodic or abutting.

A structured connection is two ranges of vertices and a transform: entry a at place i says that
direction i of the zone runs along direction |a| of its donor, backwards if it is negative. Any
other one lists vertices on both sides. Those that list faces are told, not read.

Source: CGNS SIDS, "Multizone interface connectivity".
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.cgns_nodes import Node
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.links import Link
from ffdstudio.meshes.mesh import MeshWarning


class Spot(NamedTuple):
    """A zone: its base, node, dimensions without rind, first node, and prefix of its names."""

    base: str
    zone: Node
    dims: tuple[int, ...]
    first: int
    prefix: str


def links_of(source: Source, spots: dict[tuple[str, str], Spot]) -> Iterator[Link]:
    """Links of all connections whose two sides differ, each told once."""
    known: set[tuple[int, ...]] = set()
    unread: list[str] = []
    for spot in spots.values():
        groups = spot.zone.of("ZoneGridConnectivity_t")
        for node in (node for group in groups for node in group.children):
            donor = _donor(spots, spot, node)
            if donor is None:
                continue
            pair = _pair(source, spot, donor, node)
            if pair is None:
                unread.append(spot.prefix + node.name)
                continue
            first, second = pair
            key = (len(first), *sorted((int(first.min()), int(second.min()))))
            if key not in known and (first != second).any():
                known.add(key)
                yield Link(_names(spot, donor, node), first, second)
    if unread:
        warnings.warn(
            f"{source.path.name}: connections between faces are kept but not watched: "
            f"{', '.join(unread)}",
            MeshWarning,
            stacklevel=2,
        )


def _donor(spots: dict[tuple[str, str], Spot], spot: Spot, node: Node) -> Spot | None:
    """Zone on the other side if the connection is one to one."""
    kind = node.child("GridConnectivityType")
    general = node.label == "GridConnectivity_t"
    if general and (kind is None or kind.text() != "Abutting1to1"):
        return None
    if not general and node.label != "GridConnectivity1to1_t":
        return None
    base, _, zone = node.text().rpartition("/")
    return spots.get((base or spot.base, zone))


def _names(spot: Spot, donor: Spot, node: Node) -> tuple[str, ...]:
    """Name of the connection, and of the one back if the donor has one, else the donor's."""
    back = [
        other.name
        for group in donor.zone.of("ZoneGridConnectivity_t")
        for other in group.children
        if other is not node and other.text().rpartition("/")[2] == spot.zone.name
    ]
    other = donor.prefix + back[0] if back else donor.zone.name
    return tuple(dict.fromkeys((spot.prefix + node.name, other)))


def _pair(source: Source, spot: Spot, donor: Spot, node: Node) -> tuple[Indices, Indices] | None:
    """Nodes on both sides, None where faces are listed."""
    location = node.child("GridLocation")
    if location is not None and location.text() != "Vertex":
        return None
    ends, others = node.child("PointRange"), node.child("PointRangeDonor")
    if ends is not None and others is not None:
        return _ranges(source, spot, donor, node, ends, others)
    own = _listed(source, spot, node, node.child("PointList") or ends)
    back = _listed(source, donor, node, node.child("PointListDonor"))
    if own is None or back is None or len(own) != len(back) or not len(own):
        return None
    return own, back


def _listed(source: Source, spot: Spot, node: Node, child: Node | None) -> Indices | None:
    if child is None:
        return None
    values = child.values().astype(np.int64)
    if child.name == "PointRange" and len(values) == 2:
        values = np.arange(values[0], min(values[1], values[0] + len(source.data)) + 1)
    if len(values) % len(spot.dims):
        return None
    return _flat(source, spot, node, values.reshape(-1, len(spot.dims)))


def _flat(source: Source, spot: Spot, node: Node, points: Indices) -> Indices:
    """Node indices from (k, directions) vertices, which count from 1."""
    if points.size and ((points < 1).any() or (points > np.array(spot.dims)).any()):
        raise source.failure(f"connection {node.name} lies outside its zones")
    strides = np.concatenate([[1], np.cumprod(spot.dims[:-1])]).astype(np.int64)
    return spot.first + (points - 1) @ strides


def _ranges(
    source: Source, spot: Spot, donor: Spot, node: Node, ends: Node, others: Node
) -> tuple[Indices, Indices]:
    many = len(spot.dims)
    if len(ends.values()) != 2 * many or len(others.values()) != 2 * many:
        raise source.failure(f"connection {node.name} does not fit its zone")
    begin, end = ends.values().astype(np.int64).reshape(2, many)
    start = others.values().astype(np.int64)[:many]
    child = node.child("Transform")
    given = child.values().astype(np.int64) if child is not None else np.arange(1, many + 1)
    if sorted(np.abs(given).tolist()) != list(range(1, many + 1)):
        raise source.failure(f"connection {node.name} has a transform that is none")
    for corner in (begin, end):
        _flat(source, spot, node, corner[None])
    steps = [
        np.arange(a, b + (1 if b >= a else -1), 1 if b >= a else -1)
        for a, b in zip(begin.tolist(), end.tolist(), strict=True)
    ]
    points = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, many)
    turn = np.zeros((many, many), dtype=np.int64)
    turn[np.abs(given) - 1, np.arange(many)] = np.sign(given)
    across = (points - begin) @ turn.T + start
    return _flat(source, spot, node, points), _flat(source, donor, node, across)
