"""The coordinates of a CGNS zone, and its rind planes: copies of what lies in other zones."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats.cgns_nodes import Node
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import MeshWarning

AXES = ("CoordinateX", "CoordinateY", "CoordinateZ")
SAME = 1e-9  # of the mesh's size: how near copies of a node lie to it


class Grid(NamedTuple):
    """Arrays of coordinates, which of their numbers are the zone's nodes, and its dimensions.

    `kept` counts flat, the first index running fastest; `dims` leaves out the rind.
    """

    arrays: list[Node]
    kept: Indices
    dims: tuple[int, ...]

    def points(self) -> Array:
        """(n, 3) coordinates with those of the rind."""
        found = np.zeros((len(self.arrays[0].values()), 3))
        with np.errstate(invalid="ignore"):
            for axis, node in enumerate(self.arrays):
                found[:, axis] = node.values()
        return found

    @property
    def rind(self) -> Indices:
        """Nodes of the rind, counted flat."""
        outside = np.ones(len(self.arrays[0].values()), dtype=bool)
        outside[self.kept] = False
        return np.flatnonzero(outside)


def grid_of(source: Source, zone: Node) -> Grid:
    """Coordinates of a zone.

    Raises
    ------
    InputError
        If there are none, or they are not x, y, z.
    """
    grids = list(zone.of("GridCoordinates_t"))
    grid = zone.child("GridCoordinates") or (grids[0] if grids else None)
    if grid is None:
        raise source.failure(f"zone {zone.name} has no coordinates")
    if len(grids) > 1:
        others = ", ".join(node.name for node in grids if node is not grid)
        warnings.warn(
            f"{source.path.name}: zone {zone.name} has other coordinates, which are kept as they "
            f"were: {others}",
            MeshWarning,
            stacklevel=2,
        )
    arrays = _arrays(source, zone, grid)
    kept, dims = _core(source, zone, grid, arrays[0])
    return Grid(arrays, kept, dims)


def _arrays(source: Source, zone: Node, grid: Node) -> list[Node]:
    """Arrays of coordinates of a zone, two or three."""
    found = [node for node in map(grid.child, AXES) if node is not None]
    names = [node.name for node in grid.of("DataArray_t")]
    if len(found) < 2 or [node.name for node in found] != list(AXES[: len(found)]):
        raise source.failure(f"zone {zone.name} has coordinates {', '.join(names)}, not x, y, z")
    for node in found:
        if (
            node.dtype is None
            or node.dtype.kind != "f"
            or len(node.values()) != len(found[0].values())
        ):
            raise source.failure(f"zone {zone.name}: {node.name} is damaged")
    return found


def _core(source: Source, zone: Node, grid: Node, array: Node) -> tuple[Indices, tuple[int, ...]]:
    """Flat indices and dimensions of the nodes within the rind planes."""
    everything = np.arange(len(array.values()))
    kind, rind = zone.child("ZoneType"), grid.child("Rind")
    if kind is None or kind.text() != "Structured" or rind is None:
        return everything, array.dims
    planes = rind.values().astype(np.int64)
    if len(planes) != 2 * len(array.dims) or (planes < 0).any():
        raise source.failure(f"zone {zone.name} has rind planes that do not fit it")
    ends = [n - int(b) for n, b in zip(array.dims, planes[1::2], strict=True)]
    ranges = [range(int(a), b) for a, b in zip(planes[::2], ends, strict=True)]
    if any(len(part) < 1 for part in ranges):
        raise source.failure(f"zone {zone.name} is all rind planes")
    block = everything.reshape(array.dims[::-1])
    return block[np.ix_(*reversed(ranges))].ravel(), tuple(map(len, ranges))


def copies_in_rind(
    source: Source, grids: list[Grid], parts: list[Array], points: Array
) -> list[tuple[Indices, Indices]]:
    """Nodes in the rind of each zone that are copies of a node in one: flat index, and node."""
    none = np.empty(0, dtype=np.int64)
    rinds = [grid.rind for grid in grids]
    if not any(map(len, rinds)):
        return [(none, none)] * len(grids)
    from scipy.spatial import cKDTree

    tree, found, lost = cKDTree(points), [], 0
    slack = SAME * float(np.ptp(points, axis=0).max())
    for part, rind in zip(parts, rinds, strict=True):
        finite = rind[np.isfinite(part[rind]).all(axis=1)]
        distance, nodes = tree.query(part[finite], distance_upper_bound=slack)
        near = np.isfinite(distance)
        found.append((finite[near], np.asarray(nodes, dtype=np.int64)[near]))
        lost += int(len(rind) - near.sum())
    if lost:
        warnings.warn(
            f"{source.path.name}: {lost} nodes in rind planes are no copies of nodes of a zone "
            "and are kept as they were",
            MeshWarning,
            stacklevel=2,
        )
    return found
