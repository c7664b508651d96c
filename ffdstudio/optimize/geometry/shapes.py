"""What a case optimizes: a section, or the marker of a mesh; as points in a useful order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.airfoil import split_element
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.geometry.sections import is_naca, opened, sampled
from ffdstudio.optimize.variables.metrics import Surface


@dataclass
class Shape:
    """Points that the objective sees.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3); of a 2D contour in Selig's order.
    surface : Surface
    mesh : Mesh, optional
        That they belong to.
    nodes : numpy.ndarray, optional
        Their numbers in it.
    triangles : numpy.ndarray, optional
        Of a surface in 3D.
    contour : numpy.ndarray, optional
        Where the section is among the points of a whole mesh, in Selig's order.
    """

    points: Array
    surface: Surface
    mesh: Mesh | None = None
    nodes: NDArray[np.int64] | None = None
    triangles: NDArray[np.int64] | None = None
    contour: NDArray[np.int64] | None = None

    @property
    def flat(self) -> bool:
        """Whether it is a section."""
        return self.triangles is None

    @cached_property
    def chord(self) -> Chord | None:
        """Where the section lies; None for a surface in 3D."""
        return Chord.of(self.section) if self.flat else None

    @property
    def section(self) -> Array:
        """(n, 3) points without those of the mesh around."""
        return self.points if self.contour is None else self.points[self.contour]

    @property
    def local(self) -> Array:
        """(n, 3) points of the section in chords, or of the surface as it is."""
        if self.chord is None or self.chord.unit:
            return self.section
        return self.chord.local(self.section)


def section_shape(source: str, count: int, gap: float | None = None) -> Shape:
    """Cosine-spaced section, on request with a gap at its trailing edge."""
    points = sampled(source, count)
    if gap is not None:
        points = opened(points, gap - float(points[0, 1] - points[-1, 1]))
    return Shape(points, Surface.curve(points))


def is_section(source: str) -> bool:
    """Whether a source is the name of a NACA section or an airfoil file."""
    return is_naca(source) or split_element(source)[0].lower().endswith((".dat", ".txt"))


def mesh_shape(path: str, marker: str, whole: bool) -> Shape:
    """Marker of a mesh; with `whole` all nodes are seen, the marker tells where the metric lives.

    Raises
    ------
    InputError
        If there is no such marker, or it is no contour or surface.
    """
    mesh = read_mesh(path)
    if marker not in mesh.markers:
        raise InputError(
            f"{path} has no marker {marker!r}, only {', '.join(mesh.markers) or 'none'}"
        )
    elements = mesh.markers[marker]
    if "line" in elements and mesh.dimension == 2:
        return _contour_of(mesh, elements["line"], whole)
    triangles = triangles_of(elements)
    if not len(triangles):
        raise InputError(f"marker {marker!r} of {path} is neither a contour nor a surface")
    used, compact = np.unique(triangles, return_inverse=True)
    compact = compact.reshape(triangles.shape)
    points = np.asarray(mesh.points)
    if whole:
        surface = Surface.triangles(points, triangles)
        return Shape(points.copy(), surface, mesh, np.arange(len(points)), triangles)
    surface = Surface.triangles(points[used], compact)
    return Shape(points[used], surface, mesh, used, compact)


def _contour_of(mesh: Mesh, lines: NDArray[np.int64], whole: bool) -> Shape:
    points, nodes = np.asarray(mesh.points), selig_order(mesh.points, lines)
    if whole:
        surface = Surface.edges(points, lines)
        return Shape(points.copy(), surface, mesh, np.arange(len(points)), contour=nodes)
    return Shape(points[nodes], Surface.curve(points[nodes]), mesh, nodes)


def triangles_of(elements: dict[str, Any]) -> NDArray[np.int64]:
    """Triangles of a marker, quads split."""
    parts = [np.asarray(elements.get("triangle", np.empty((0, 3), dtype=np.int64)))]
    if "quad" in elements:
        quads = np.asarray(elements["quad"])
        parts += [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    return np.concatenate(parts)


def selig_order(points: Array, lines: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes of a closed chain of lines from the trailing edge over the upper side and back.

    The trailing edge, the node of the largest x, comes first and last.

    Raises
    ------
    InputError
        If the lines are not one closed chain.
    """
    neighbours: dict[int, list[int]] = {}
    for a, b in lines.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    if any(len(near) != 2 for near in neighbours.values()):
        raise InputError("the marker is not one closed contour")
    start = max(neighbours, key=lambda k: (points[k, 0], points[k, 1]))
    first = max(neighbours[start], key=lambda k: points[k, 1])
    chain = [start, first]
    while chain[-1] != start:
        a, b = neighbours[chain[-1]]
        chain.append(b if a == chain[-2] else a)
    if len(chain) != len(lines) + 1:
        raise InputError("the marker is not one closed contour")
    return np.array(chain, dtype=np.int64)
