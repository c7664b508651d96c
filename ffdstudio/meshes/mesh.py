"""The mesh: points, cells and named boundaries, with the file they came from.

1. A mesh is an immutable value. Its arrays are read-only; other coordinates make another mesh.
2. It remembers its file as a template, so that it can be written as that very file with other
   coordinates. Nobody but `write_mesh` and the formats looks at the template.
3. Files that list faces rather than cells (OpenFOAM, Fluent) carry them in `faces`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.links import Link
from ffdstudio.meshes.topology import Cells, corners, dimension, numbers, skin

Markers = dict[str, Cells]
SHAPES = {"tetra": (4, 0), "pyramid": (4, 1), "wedge": (2, 3), "hexahedron": (0, 6)}


class MeshWarning(UserWarning):
    """Something that the user should know of a mesh that was read or written."""


class Template(Protocol):
    """The file of a mesh, ready to be written again with other coordinates."""

    @property
    def original(self) -> Array:
        """(n, 3) coordinates as they are in the file."""

    def write(self, path: Path, points: Array) -> None:
        """Write the file with these (n, 3) coordinates; raises `InputError` where it cannot."""


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of a face-based mesh.

    Attributes
    ----------
    nodes : numpy.ndarray
        Node indices of all faces, one face after the other.
    offsets : numpy.ndarray
        (faces + 1,) where each face begins in `nodes`.
    owner, neighbour : numpy.ndarray
        (faces,) cells on both sides; `neighbour` is -1 at the boundary. Normals by the
        right-hand rule point from owner to neighbour.
    """

    nodes: Indices
    offsets: Indices
    owner: Indices
    neighbour: Indices

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def cells(self) -> int:
        """Number of cells."""
        return int(max(self.owner.max(initial=-1), self.neighbour.max(initial=-1))) + 1

    @property
    def counts(self) -> dict[str, int]:
        """Number of cells by type, told by the triangles and quads around them."""
        sizes = np.diff(self.offsets)
        inner = self.neighbour >= 0
        cells = np.concatenate([self.owner, self.neighbour[inner]])
        sizes = np.concatenate([sizes, sizes[inner]])
        many = self.cells
        key = [np.bincount(cells[chosen], minlength=many) for chosen in (sizes == 3, sizes == 4)]
        total = np.bincount(cells, minlength=many)
        found = {}
        for name, (triangles, quads) in SHAPES.items():
            fits = (key[0] == triangles) & (key[1] == quads) & (total == triangles + quads)
            found[name] = int(fits.sum())
        found["polyhedron"] = many - sum(found.values())
        return {name: count for name, count in found.items() if count}


@dataclass(frozen=True, eq=False)
class Mesh:
    """Points with cells and named boundaries.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3) float64, read-only, in the unit of the file; z = 0 in a 2D mesh.
    cells : dict
        Cell type -> (k, nodes) int64 node indices in VTK's order. Types are named as in
        meshio: vertex line triangle quad tetra pyramid wedge hexahedron, triangle6, ...
    markers : dict
        Name of a boundary, zone or group -> type -> (k, nodes).
    dimension : int
        2 or 3.
    faces : Faces, optional
        Faces of a face-based mesh, whose `cells` are then empty.
    kinds : dict
        Marker name -> its kind in the file, such as "wall", "empty", "symmetry", "periodic",
        for the markers where the file tells.
    partners : dict
        Marker name -> the marker it is periodic with, where the file tells.
    links : tuple of Link
        Periodic and abutting boundaries whose nodes the file pairs one by one.
    unread : dict
        Cells of the file with an area or a volume that are not among `cells`, by the name that
        the file gives their type -> how many. They move with their nodes, unseen.
    path, format : pathlib.Path or None, str
        Where it was read and in which format.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]})
    >>> mesh.counts
    {'triangle': 1}
    """

    points: Array
    cells: Cells = field(default_factory=dict)
    markers: Markers = field(default_factory=dict)
    dimension: int = 3
    faces: Faces | None = None
    kinds: dict[str, str] = field(default_factory=dict)
    partners: dict[str, str] = field(default_factory=dict)
    links: tuple[Link, ...] = ()
    unread: dict[str, int] = field(default_factory=dict)
    path: Path | None = None
    format: str = ""
    template: Template | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _read_only(_checked_points(self.points)))
        n = len(self.points)
        object.__setattr__(self, "cells", _checked_cells(self.cells, n, "the cells"))
        if not isinstance(self.markers, Mapping):
            raise InputError("the markers must be given by name: a dict")
        markers = {
            name: _checked_cells(cells, n, f"marker {name}") for name, cells in self.markers.items()
        }
        object.__setattr__(self, "markers", markers)

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {kind}" for kind, n in self.counts.items())
        return f"<Mesh of {len(self.points)} nodes, {counts or 'no cells'}>"

    def with_points(self, points: ArrayLike) -> Mesh:
        """Return the same mesh with other (n, 3) coordinates; it still writes its file.

        Raises
        ------
        InputError
            If the number of points differs or one is not finite.

        Examples
        --------
        >>> mesh = Mesh([[0, 0, 0], [1, 0, 0]], {"line": [[0, 1]]})
        >>> mesh.with_points(mesh.points + [0, 2, 0]).points
        array([[0., 2., 0.],
               [1., 2., 0.]])
        """
        new = _checked_points(points)
        if new.shape != self.points.shape:
            raise InputError(
                f"this mesh has {len(self.points)} nodes, the coordinates given are {len(new)}"
            )
        return replace(self, points=new)

    @property
    def counts(self) -> dict[str, int]:
        """Number of cells by type; also of a face-based mesh.

        Examples
        --------
        >>> Mesh([[0, 0, 0]] * 4, {"triangle": [[0, 1, 2]], "quad": [[0, 1, 2, 3]]}).counts
        {'triangle': 1, 'quad': 1}
        """
        if self.faces is not None:
            return self.faces.counts
        return {kind: len(nodes) for kind, nodes in self.cells.items()}

    @property
    def marker_counts(self) -> dict[str, int]:
        """Number of boundary elements by marker.

        Examples
        --------
        >>> Mesh([[0, 0, 0], [1, 0, 0]], {}, {"wall": {"line": [[0, 1]]}}).marker_counts
        {'wall': 1}
        """
        return {name: sum(map(len, cells.values())) for name, cells in self.markers.items()}

    @property
    def boundaries(self) -> list[str]:
        """Names of the markers whose elements have fewer dimensions than the cells.

        Examples
        --------
        >>> markers = {"floor": {"line": [[0, 1]]}, "zone": {"triangle": [[0, 1, 2]]}}
        >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}, markers)
        >>> mesh.boundaries
        ['floor']
        """
        highest = 3 if self.faces is not None else max(map(dimension, self.cells), default=3)
        return [
            name
            for name, cells in self.markers.items()
            if max(map(dimension, cells), default=0) < highest
        ]

    @property
    def bounds(self) -> Array:
        """(2, 3) lower and upper corner of the points; zeros without points.

        Examples
        --------
        >>> Mesh([[0, 5, 0], [3, 1, 2]]).bounds
        array([[0., 1., 0.],
               [3., 5., 2.]])
        """
        if len(self.points) == 0:
            return np.zeros((2, 3))
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    def marker_nodes(self, *names: str) -> Indices:
        """Sorted indices of the nodes on the named markers, on all boundaries if none is named.

        Zones and groups of cells are markers, too, but no boundaries.

        Raises
        ------
        InputError
            If there is no such marker; the message lists those that there are.

        Examples
        --------
        >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], {}, {"wall": {"line": [[2, 1]]}})
        >>> mesh.marker_nodes("wall")
        array([1, 2])
        >>> mesh.marker_nodes("hull")
        Traceback (most recent call last):
            ...
        ffdstudio.errors.InputError: no marker hull in this mesh; it has: wall
        """
        for name in names:
            if not isinstance(name, str) or name not in self.markers:
                known = ", ".join(self.markers) or "none"
                raise InputError(f"no marker {name} in this mesh; it has: {known}")
        chosen = [self.markers[name] for name in (names or self.boundaries)]
        parts = [nodes.ravel() for cells in chosen for nodes in cells.values()]
        return np.unique(np.concatenate(parts)) if parts else np.empty(0, dtype=np.int64)

    def surface(self) -> Cells:
        """Lines, triangles, quads and polygons to show the mesh by, as type -> corner nodes.

        A volume mesh shows its outer faces, any other one its own cells.

        Examples
        --------
        >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> Mesh(corners, {"tetra": [[0, 1, 2, 3]]}).surface()["triangle"].shape
        (4, 3)
        """
        if self.faces is not None:
            return boundary_faces(self.faces)
        if any(dimension(kind) == 3 for kind in self.cells):
            return skin(self.cells)
        return {
            kind: corners(kind, nodes) for kind, nodes in self.cells.items() if dimension(kind) > 0
        }


def boundary_faces(faces: Faces, chosen: Indices | None = None) -> Cells:
    """Chosen faces, by default those without a neighbour, by type: triangle, quad, polygonN."""
    if chosen is None:
        chosen = np.flatnonzero(faces.neighbour < 0)
    sizes = np.diff(faces.offsets)[chosen]
    cells = {}
    for size in np.unique(sizes):
        begin = faces.offsets[chosen[sizes == size]]
        name = {3: "triangle", 4: "quad"}.get(int(size), f"polygon{size}")
        cells[name] = faces.nodes[begin[:, None] + np.arange(size)]
    return cells


def _checked_points(points: ArrayLike) -> Array:
    array = numbers(points, "points").copy()
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"points must be an array (n, 3), got {array.shape}")
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InputError(
            f"node {bad} (counted from 0) has a coordinate that is not a finite number"
        )
    return array


def _checked_cells(cells: Cells, n: int, what: str) -> Cells:
    if not isinstance(cells, Mapping):
        raise InputError(f"{what} must be given by type: a dict of arrays")
    return {kind: _checked_nodes(nodes, n, f"{what}: {kind}") for kind, nodes in cells.items()}


def _checked_nodes(nodes: ArrayLike, n: int, what: str) -> Indices:
    array = _whole(nodes, what)
    if array.ndim != 2:
        raise InputError(f"{what} must be an array (cells, nodes), got {array.shape}")
    if array.size and not (array.min() >= 0 and array.max() < n):
        bad = int(np.flatnonzero(((array < 0) | (array >= n)).any(axis=1))[0])
        raise InputError(f"{what} {bad} (counted from 0) refers to a node outside 0 to {n - 1}")
    return _read_only(array)


def _whole(nodes: ArrayLike, what: str) -> Indices:
    try:
        given = np.asarray(nodes)
        with np.errstate(invalid="ignore"):
            array = given.astype(np.int64, copy=False)
        if given.dtype.kind in "iu" or np.array_equal(array, given):
            return array
    except (TypeError, ValueError):
        pass
    raise InputError(f"{what} must be an array of node indices")


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
