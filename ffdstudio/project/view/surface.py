"""What the window draws of a mesh: its surface, with the nodes' numbers, and a proxy of it.

1. Only nodes on the surface are drawn, so nothing in a frame grows with the volume.
2. Polygons and lines know the marker they belong to, so that markers can be hidden.
3. A surface of more than `PROXY_ABOVE` points gets a proxy for drags: vertex clustering
   (Rossignac and Borrel 1993), where each cell of a grid keeps one of its own points, so
   that proxy points are rows of the surface and follow exactly as those do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.quasi2d import is_plane, outlines, slab_of
from ffdstudio.meshes.topology import corners, dimension
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.project.view.shading import Shading, shading_of

PROXY_ABOVE = 200_000
PROXY_POINTS = 40_000
NO_MARKER = -1


@dataclass(frozen=True, eq=False)
class Proxy:
    """A coarse stand-in for a surface.

    Attributes
    ----------
    rows : numpy.ndarray
        (k,) rows of the surface's points that it keeps.
    triangles, lines : numpy.ndarray
        (t, 3) and (l, 2) into `rows`.
    shading : Shading or None
    """

    rows: Indices
    triangles: Indices
    lines: Indices
    shading: Shading | None = None


@dataclass(frozen=True, eq=False)
class DisplaySurface:
    """What is drawn of a mesh.

    Attributes
    ----------
    nodes : numpy.ndarray
        (m,) node of the mesh for each displayed point, ascending.
    connectivity, offsets : numpy.ndarray
        Polygons: displayed points of one after the other, and the (p + 1,) beginnings.
    lines : numpy.ndarray
        (l, 2) displayed points.
    polygon_marker, line_marker : numpy.ndarray
        (p,) and (l,) index into `markers`; -1 for none.
    markers : tuple of str
    has_volume : bool
        Whether this is the skin of a volume mesh.
    proxy : Proxy or None
        What to show during a drag; None if the surface is small enough itself.
    shading : Shading or None
        What shares a normal; None of a plane mesh, which is seen straight on.
    """

    nodes: Indices
    connectivity: Indices
    offsets: Indices
    lines: Indices
    polygon_marker: Indices
    line_marker: Indices
    markers: tuple[str, ...] = ()
    has_volume: bool = False
    proxy: Proxy | None = None
    shading: Shading | None = None

    def marker_points(self, name: str) -> Indices:
        """Return the displayed points on a marker, ascending."""
        number = self.markers.index(name)
        polygon = np.repeat(self.polygon_marker, np.diff(self.offsets)) == number
        on_lines = self.lines[self.line_marker == number].ravel()
        return np.unique(np.concatenate([self.connectivity[polygon], on_lines]))


def surface_of(mesh: Mesh, proxy_above: int = PROXY_ABOVE) -> DisplaySurface:
    """Extract what to draw of a mesh.

    Examples
    --------
    >>> tetra = Mesh(np.eye(4)[:, :3], {"tetra": [[0, 1, 2, 3]]})
    >>> len(surface_of(tetra).offsets) - 1
    4
    """
    polygons, lines = _drawn(mesh)
    names = tuple(mesh.markers)
    nodes = _used([*polygons, lines], len(mesh.points))
    row_of = np.zeros(len(mesh.points), dtype=np.int64)
    row_of[nodes] = np.arange(len(nodes))
    sizes = [np.full(len(block), block.shape[1]) for block in polygons]
    offsets = np.concatenate([[0], np.cumsum(np.concatenate([[], *sizes]))]).astype(np.int64)
    connectivity = row_of[np.concatenate([_none(1), *(b.ravel() for b in polygons)])]
    marked = [_markers(block, mesh, names) for block in polygons]
    polygon_marker = np.concatenate([_none(1), *marked])
    of_lines = _markers(lines, mesh, names)
    if slab_of(mesh) is not None:
        of_lines = _outlined(lines, mesh, names)
    volume = mesh.faces is not None or any(dimension(kind) == 3 for kind in mesh.cells)
    drawn = (connectivity, offsets, row_of[lines], polygon_marker, of_lines)
    surface = (nodes, *drawn, names, volume)
    places, shading, proxy = mesh.points[nodes], None, None
    if len(nodes) > proxy_above:
        rows = [row_of[block] for block in polygons]
        proxy = cluster(places, rows, row_of[lines])
    if not is_plane(mesh) and len(connectivity):
        shading = shading_of(places, connectivity, offsets)
        if proxy is not None:
            corners = proxy.triangles.ravel(), np.arange(0, proxy.triangles.size + 1, 3)
            proxy = replace(proxy, shading=shading_of(places[proxy.rows], *corners))
    return DisplaySurface(*surface, proxy, shading)


def outer_polygons(surface: DisplaySurface, mesh: Mesh) -> Mask:
    """(p,) polygons of the far field around walls, and of the planes that it ends at."""
    names = wall_markers(mesh)
    if not names or is_plane(mesh):
        return np.zeros(len(surface.polygon_marker), dtype=bool)
    inner = [surface.markers.index(name) for name in names]
    return ~np.isin(surface.polygon_marker, inner)


def _used(blocks: list[Indices], count: int) -> Indices:
    """Nodes of the blocks, ascending; all of them where nothing uses any."""
    mask = np.zeros(count, dtype=bool)
    for block in blocks:
        mask[block.ravel()] = True
    return np.flatnonzero(mask) if mask.any() else np.arange(count)


def _none(*shape: int) -> Indices:
    return np.empty((0, *shape[1:]), dtype=np.int64)


def _drawn(mesh: Mesh) -> tuple[list[Indices], Indices]:
    """Blocks of polygons with as many corners each, and lines; as node numbers."""
    found = mesh.surface()
    polygons = [nodes for nodes in found.values() if nodes.shape[1] > 2 and len(nodes)]
    lines = [nodes for nodes in found.values() if nodes.shape[1] == 2]
    # the boundaries of a plane mesh are lines; they carry its markers
    for cells in mesh.markers.values():
        lines += [nodes[:, :2] for kind, nodes in cells.items() if kind.startswith("line")]
    if slab_of(mesh) is not None:  # seen from the front, the walls around it are lines as well
        lines += list(outlines(mesh).values())
    every = np.concatenate([_none(1, 2), *lines])
    first = np.unique(_key(every), return_index=True)[1]
    return polygons, every[np.sort(first)]


def _key(elements: Indices) -> NDArray[np.uint64]:
    """One number for each set of nodes: a hash, so matches are checked by `_markers`."""
    total = np.zeros(len(elements), dtype=np.uint64)
    for column in np.sort(elements, axis=1).astype(np.uint64).T:
        total = (total ^ column) * np.uint64(0x9E3779B97F4A7C15)
        total ^= total >> np.uint64(29)
    return total


def _markers(elements: Indices, mesh: Mesh, names: tuple[str, ...]) -> Indices:
    """(k,) the first marker that has each element; -1 for none."""
    marker = np.full(len(elements), NO_MARKER, dtype=np.int64)
    if not names:
        return marker
    keys = _key(elements)
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    for number, name in reversed(list(enumerate(names))):
        for kind, nodes in mesh.markers[name].items():
            own = corners(kind, nodes)
            if own.shape[1] == elements.shape[1] and len(elements) and len(own):
                _paint(marker, number, own, elements, ordered, order)
    return marker


def _outlined(lines: Indices, mesh: Mesh, names: tuple[str, ...]) -> Indices:
    """(l,) marker whose outline has each line; -1 for none."""
    marker = np.full(len(lines), NO_MARKER, dtype=np.int64)
    keys = _key(lines)
    for name, own in outlines(mesh).items():
        marker[np.isin(keys, _key(own))] = names.index(name)
    return marker


def _paint(
    marker: Indices,
    number: int,
    own: Indices,
    elements: Indices,
    ordered: NDArray[np.uint64],
    order: Indices,
) -> None:
    place = np.minimum(np.searchsorted(ordered, _key(own)), len(ordered) - 1)
    found = order[place]
    same = (np.sort(own, axis=1) == np.sort(elements[found], axis=1)).all(axis=1)
    marker[found[same]] = number


# ---- the proxy --------------------------------------------------------------------------


def cluster(
    points: Array, polygons: list[Indices], lines: Indices, target: int = PROXY_POINTS
) -> Proxy:
    """Merge points that share a cell of a grid with about `target` occupied cells.

    Parameters
    ----------
    points : numpy.ndarray
        (m, 3).
    polygons : list of numpy.ndarray
        Blocks (k, corners) of rows of `points`.
    lines : numpy.ndarray
        (l, 2) rows of `points`.
    target : int
        Wanted number of points.
    """
    first, group = _grid(points, target)
    fans = [_fan(block) for block in polygons]
    triangles = _distinct(group[np.concatenate([_none(1, 3), *fans])])
    return Proxy(first, triangles, _distinct(group[lines]))


def _grid(points: Array, target: int) -> tuple[Indices, Indices]:
    """First point of each occupied cell, and the cell of each point."""
    lower, extent = points.min(axis=0), np.ptp(points, axis=0).max()
    size = extent / np.sqrt(target) if extent > 0 else 1.0
    for _ in range(4):  # a surface occupies about area / size^2 cells
        cell = ((points - lower) / size).astype(np.int64)
        counts = cell.max(axis=0) + 1
        flat = (cell[:, 0] * counts[1] + cell[:, 1]) * counts[2] + cell[:, 2]
        _, first, group = np.unique(flat, return_index=True, return_inverse=True)
        ratio = len(first) / target
        if 0.7 < ratio < 1.4:
            break
        size *= np.sqrt(ratio)
    return first, group


def _fan(block: Indices) -> Indices:
    inner = range(1, block.shape[1] - 1)
    return np.concatenate([block[:, [0, k, k + 1]] for k in inner])


def _distinct(elements: Indices) -> Indices:
    """Elements whose corners differ, each set of corners once."""
    ordered = np.sort(elements, axis=1)
    proper = elements[(ordered[:, 1:] != ordered[:, :-1]).all(axis=1)]
    result: Indices = proper[np.sort(np.unique(_key(proper), return_index=True)[1])]
    return result
