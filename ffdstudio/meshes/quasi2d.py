"""Meshes of a plane problem in space: one cell deep, between two planes.

1. OpenFOAM and many others know no plane meshes; a section lies between two planes instead that
   are `empty` patches or symmetry planes, or the sides of a wedge.
2. A mesh counts as such if every node lies on one of two planes that the file, or the name of
   a marker, says something planar of (`planes_of`), or that are the whole of markers whose
   names say front and back. How many cells there are along the outline does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.planes import Plane, planes_of, size_of
from ffdstudio.meshes.topology import corners, dimension

FLAT = 1e-6  # of the mesh's size: how far a node may be from its plane
SIDES = ("front", "back", "side", "empty", "wedge", "sym", "period")
DEEP = 0.5  # of the two other extents: a slab is thinner than that
STEEP = 0.5  # cosine between the planes of a wedge, at least


@dataclass(frozen=True, eq=False)
class Slab:
    """The plane that a one-cell-deep mesh stands for.

    Attributes
    ----------
    axes : numpy.ndarray
        (2, 3) unit vectors to the right and upwards in the plane.
    normal : numpy.ndarray
        (3,) towards whoever looks at it: right, up and normal are right-handed.
    front : numpy.ndarray
        (k,) nodes of the side that is looked at, ascending.
    markers : tuple of str
        The two sides.
    wedge : bool
        Whether the sides are at an angle.
    """

    axes: Array
    normal: Array
    front: Indices
    markers: tuple[str, ...]
    wedge: bool = False


_known: WeakKeyDictionary[Mesh, Slab | None] = WeakKeyDictionary()


def slab_of(mesh: Mesh) -> Slab | None:
    """The plane that a mesh stands for; None if it is deeper than one cell, or flat already.

    Examples
    --------
    >>> corner = np.array([[0, 0], [4, 0], [4, 4], [0, 4.0]])
    >>> points = [[x, y, z] for z in (0.0, 1.0) for x, y in corner]
    >>> sides = {"front": {"quad": [[4, 5, 6, 7]]}, "back": {"quad": [[0, 3, 2, 1]]}}
    >>> slab = slab_of(Mesh(points, {"hexahedron": [range(8)]}, sides))
    >>> slab.normal, slab.front, slab.markers
    (array([0., 0., 1.]), array([4, 5, 6, 7]), ('front', 'back'))
    """
    if mesh not in _known:
        _known[mesh] = _found(mesh) if mesh.dimension == 3 and _solid(mesh) else None
    return _known[mesh]


def is_plane(mesh: Mesh) -> bool:
    """Whether a mesh is, or stands for, a plane one.

    Examples
    --------
    >>> is_plane(Mesh(np.eye(3), {"triangle": [[0, 1, 2]]}))
    False
    """
    return mesh.dimension == 2 or slab_of(mesh) is not None


def plane_axes(mesh: Mesh) -> Array:
    """(2, 3) directions of a plane mesh, or of the plane that a mesh stands for."""
    slab = slab_of(mesh)
    return np.eye(3)[:2] if slab is None else slab.axes


def outlines(mesh: Mesh) -> dict[str, Indices]:
    """Lines (k, 2) of each marker as seen from the front of a one-cell-deep mesh.

    Of a plane mesh, the lines of its markers.
    """
    slab = slab_of(mesh)
    if slab is None:
        cells = {name: found.get("line") for name, found in mesh.markers.items()}
        return {name: lines[:, :2] for name, lines in cells.items() if lines is not None}
    front = np.zeros(len(mesh.points), dtype=bool)
    front[slab.front] = True
    found = {name: _edges(mesh, name, front) for name in mesh.boundaries}
    sides = {name for name in found if name in slab.markers}
    return {name: lines for name, lines in found.items() if len(lines) and name not in sides}


def _edges(mesh: Mesh, name: str, front: Array) -> Indices:
    """Edges of a marker's faces that lie in the front; each once."""
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for kind, nodes in mesh.markers[name].items():
        if dimension(kind) == 2:
            ring = corners(kind, nodes)
            edges = np.stack([ring, np.roll(ring, -1, axis=1)], axis=-1).reshape(-1, 2)
            pairs.append(edges[front[edges].all(axis=1)])
    every = np.concatenate(pairs)
    return every[np.sort(np.unique(np.sort(every, axis=1), axis=0, return_index=True)[1])]


def _solid(mesh: Mesh) -> bool:
    return mesh.faces is not None or any(dimension(kind) == 3 for kind in mesh.cells)


def _found(mesh: Mesh) -> Slab | None:
    planes = [*planes_of(mesh), *_named(mesh)]
    for number, first in enumerate(planes):
        for second in planes[number + 1 :]:
            slab = _between(mesh, first, second)
            if slab is not None:
                return slab
    return None


def _between(mesh: Mesh, first: Plane, second: Plane) -> Slab | None:
    """Slab between two planes that together hold every node."""
    cosine = abs(float(first.normal @ second.normal))
    slack = FLAT * size_of(mesh)
    if cosine < STEEP:
        return None
    far = [np.abs(plane.distances(mesh.points)) > slack for plane in (first, second)]
    if (far[0] & far[1]).any() or not far[0].any() or not far[1].any():
        return None
    wedge = cosine < 1 - 1e-9
    middle = first.normal + np.sign(first.normal @ second.normal) * second.normal
    axes, normal = _looking(middle / np.linalg.norm(middle))
    local = mesh.points @ np.array([*axes, normal]).T
    sizes = np.ptp(local, axis=0)
    if sizes[2] > DEEP * max(sizes[0], sizes[1]):
        return None
    on = [np.flatnonzero(~mask) for mask in far]
    front = max(on, key=lambda nodes: float(local[nodes, 2].mean()))
    return Slab(axes, normal, front, tuple(dict.fromkeys((first.name, second.name))), wedge)


def _looking(normal: Array) -> tuple[Array, Array]:
    """Right and up of whoever looks along a normal, and the normal towards him.

    Coordinate planes are seen as they are drawn: x to the right, else y; y or z upwards.
    """
    largest = int(np.argmax(np.abs(normal)))
    if np.abs(np.delete(normal, largest)).max() <= 1e-9:
        flat: Array = np.delete(np.eye(3), largest, axis=0)
        return flat, np.cross(flat[0], flat[1])
    first = np.eye(3)[0 if largest != 0 else 1]
    first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    up = np.cross(normal, first)
    axes = np.array([first, up if up[int(np.argmax(np.abs(up)))] > 0 else -up])
    return axes, np.cross(axes[0], axes[1])


def _named(mesh: Mesh) -> list[Plane]:
    """Planes at right angles to an axis at both ends of a mesh that markers of such names fill."""
    slack, found = FLAT * size_of(mesh), []
    for name in mesh.boundaries:
        nodes = mesh.marker_nodes(name)
        if not len(nodes) or not any(word in name.lower() for word in SIDES):
            continue
        places = mesh.points[nodes]
        for axis in range(3):
            levels = {float(end): axis for end in mesh.bounds[:, axis]}
            near = [np.abs(places[:, axis] - level) <= slack for level in levels]
            if len(levels) == 2 and (near[0] | near[1]).all():
                found += [
                    Plane(name, "symmetry", np.sort(nodes[on]), np.eye(3)[axis], level)
                    for level, on in zip(levels, near, strict=True)
                    if on.any()
                ]
    return found
