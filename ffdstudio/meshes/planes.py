"""Boundaries that lie in a plane and have to stay there: symmetry, `empty` and wedge patches.

1. The file tells which they are (`Mesh.kinds`). Where it does not, a marker counts that has
   "sym" in its name and all of whose nodes lie in planes, far more exactly than by chance.
2. One marker may consist of several planes: front and back of a plane OpenFOAM case, the sides
   of a channel. They are peeled off one after the other, each found by its largest element.
3. A solver mirrors or leaves out a direction there; nodes off the plane make it stop, or
   compute something else without a word.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import Cells, corners, dimension

PLANAR = ("symmetry", "empty", "wedge")
TOLD, GUESSED = 1e-6, 1e-9  # of the mesh's size: how flat a marker is by the file, or by its name
MOST = 6  # planes of one marker


@dataclass(frozen=True, eq=False)
class Plane:
    """Nodes of a marker in the plane ``normal @ x == offset``.

    Attributes
    ----------
    name, kind : str
        Of the marker; its kind is "symmetry", "empty" or "wedge", or what the file calls it.
    nodes : numpy.ndarray
        (k,) sorted.
    normal : numpy.ndarray
        (3,) unit vector, its largest component positive; exactly an axis where it is one.
    offset : float
    """

    name: str
    kind: str
    nodes: Indices
    normal: Array
    offset: float

    def distances(self, points: Array) -> Array:
        """(n,) signed distances of points (n, 3) from the plane."""
        return np.asarray(points @ self.normal - self.offset)


_known: WeakKeyDictionary[Mesh, tuple[Plane, ...]] = WeakKeyDictionary()


def planes_of(mesh: Mesh) -> tuple[Plane, ...]:
    """Planes that nodes of a mesh have to stay in.

    Examples
    --------
    >>> line = {"line": [[0, 1], [1, 2]]}
    >>> points = [[0, 2, 0], [1, 2, 0], [3, 2, 0], [1, 3, 0]]
    >>> cells = {"triangle": [[0, 1, 3], [1, 2, 3]]}
    >>> [plane] = planes_of(Mesh(points, cells, {"SYM": line}, dimension=2))
    >>> plane.normal, plane.offset
    (array([0., 1., 0.]), 2.0)
    """
    if mesh not in _known:
        _known[mesh] = tuple(plane for name in mesh.boundaries for plane in _planes(mesh, name))
    return _known[mesh]


def size_of(mesh: Mesh) -> float:
    """Length of the diagonal of the mesh's bounds."""
    return float(np.linalg.norm(np.ptp(mesh.bounds, axis=0)))


def plane_through(mesh: Mesh, name: str) -> Plane | None:
    """Plane that a marker lies in as a whole, whatever the file says of it; None if it is curved.

    Examples
    --------
    >>> line = {"line": [[0, 1]]}
    >>> cells = {"triangle": [[0, 1, 2]]}
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], cells, {"floor": line}, dimension=2)
    >>> plane_through(mesh, "floor").normal
    array([0., 1., 0.])
    """
    cells = _faces(mesh, mesh.markers[name])
    if not cells:
        return None
    nodes = np.unique(np.concatenate([part.ravel() for part in cells.values()]))
    fit = _fitted(mesh, nodes)
    if fit is None or np.abs(mesh.points[nodes] @ fit[0] - fit[1]).max() > GUESSED * size_of(mesh):
        return None
    return Plane(name, mesh.kinds.get(name, ""), nodes, *fit)


def _planes(mesh: Mesh, name: str) -> list[Plane]:
    told = mesh.kinds.get(name, "")
    guessed = told not in (*PLANAR, "wall", "periodic") and "sym" in name.lower()
    if told not in PLANAR and not guessed:
        return []
    cells = _faces(mesh, mesh.markers[name])
    slack = (GUESSED if guessed else TOLD) * size_of(mesh)
    found: list[Plane] = []
    rest = cells
    while rest and len(found) < MOST:
        fit = _largest(mesh, rest, slack)
        if fit is None:
            break
        plane, rest = fit
        found.append(Plane(name, "symmetry" if guessed else told, *plane))
    return [] if rest else found  # a curved one has facets, but is no plane


def _faces(mesh: Mesh, cells: Cells) -> Cells:
    """Elements that bound cells: faces in space, edges in a plane mesh."""
    return {
        kind: nodes
        for kind, nodes in cells.items()
        if len(nodes) and dimension(kind) == mesh.dimension - 1
    }


def _largest(
    mesh: Mesh, cells: Cells, slack: float
) -> tuple[tuple[Indices, Array, float], Cells] | None:
    """Plane of all elements, or of the largest one; and the elements that are not in it."""
    every = np.unique(np.concatenate([nodes.ravel() for nodes in cells.values()]))
    whole = _fitted(mesh, every)
    if whole is not None and np.abs(mesh.points[every] @ whole[0] - whole[1]).max() <= slack:
        return (every, *whole), {}
    normal, place = _normal_of_largest(mesh, cells)
    if not normal.any():
        return None
    chosen, _ = _split(mesh, cells, normal, float(normal @ place), slack)
    fit = _fitted(mesh, chosen)
    if fit is None:
        return None
    chosen, rest = _split(mesh, cells, *fit, slack)
    return ((chosen, *fit), rest) if len(chosen) else None


def _split(
    mesh: Mesh, cells: Cells, normal: Array, offset: float, slack: float
) -> tuple[Indices, Cells]:
    """Nodes of the elements in a plane, and the other elements."""
    far = np.abs(mesh.points @ normal - offset) > slack
    out = {kind: far[nodes].any(axis=1) for kind, nodes in cells.items()}
    inside = [nodes[~out[kind]].ravel() for kind, nodes in cells.items()]
    rest = {kind: nodes[out[kind]] for kind, nodes in cells.items() if out[kind].any()}
    return np.unique(np.concatenate(inside)), rest


def _normal_of_largest(mesh: Mesh, cells: Cells) -> tuple[Array, Array]:
    """Unit normal of the largest element, zero if it has no extent, and a node of it."""
    best, normal, place = 0.0, np.zeros(3), np.zeros(3)
    for kind, nodes in cells.items():
        p = mesh.points[corners(kind, nodes)]
        if mesh.dimension == 2:
            areas = (p[:, 1] - p[:, 0])[:, [1, 0, 2]] * [1, -1, 0]
        else:
            areas = np.cross(p[:, 2] - p[:, 0], p[:, -1] - p[:, 1])
        sizes = np.linalg.norm(areas, axis=1)
        first = int(np.argmax(sizes))
        if sizes[first] > best:
            best, normal, place = float(sizes[first]), areas[first] / sizes[first], p[first, 0]
    return normal, place


def _fitted(mesh: Mesh, nodes: Indices) -> tuple[Array, float] | None:
    """Plane nearest to nodes (least squares); None if they lie on a line or are too few."""
    d = mesh.dimension
    if len(nodes) < d:
        return None
    cloud = mesh.points[nodes] - mesh.points[nodes[0]]  # before the mean: an axis stays exact
    centred = (cloud - cloud.mean(axis=0))[:, :d]
    _, sizes, axes = np.linalg.svd(np.linalg.qr(centred, mode="r"))
    if sizes[d - 2] <= 1e-12 * size_of(mesh):
        return None
    normal = np.zeros(3)
    normal[:d] = axes[-1]
    normal = _cleaned(normal)
    values = mesh.points[nodes] @ normal
    return normal, float(np.median(values)) + 0.0


def _cleaned(normal: Array) -> Array:
    """Unit normal with its largest component positive; an axis where it is one but for noise."""
    largest = int(np.argmax(np.abs(normal)))
    normal = normal * np.sign(normal[largest])
    if np.abs(np.delete(normal, largest)).max() <= 1e-9:
        return np.asarray(np.eye(3)[largest])
    return normal
