"""The shape of a study: a section by name or file, or a part of a mesh.

1. A section by name or file has a chord of 1. With its target's trailing edge it gets that edge's
   thickness, and ends where each surface of the target does.
2. A section in a mesh is seen at the mesh's nodes, or, with a number of points, on the spline
   through them, whatever the mesh's own spacing is.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.engine import embed
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.airfoil import split_element
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.optimize.build.place import Moved, Pair, Place
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.geometry.contour import Contour
from ffdstudio.optimize.geometry.profiles import profiles
from ffdstudio.optimize.geometry.sections import (
    Section,
    is_naca,
    target_contour,
    trailing_ends,
    trailing_gap,
)
from ffdstudio.optimize.geometry.shapes import Shape, selig_order
from ffdstudio.optimize.geometry.surfaces import SOLID, triangles_of
from ffdstudio.optimize.spec.parts import ShapeSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.optimize.variables.metrics import Surface

Array = NDArray[np.float64]
POINTS = 161  # of a section by name or file, if nothing is said
AIRFOILS = (".dat", ".txt")


def shape_of(study: StudySpec, place: Place) -> Shape:
    """Shape that a study is about.

    Raises
    ------
    InputError
        If it cannot be read, has no such marker, or is no section or surface.
    """
    source = place.found(study.shape.source)
    if by_name(source, study.shape):
        return _section(source, study, place)
    found = moved(source, study.shape, place)
    flat = found.mesh.dimension == 2
    thin = not flat and study.objective.needs == "section" and is_plane(found.mesh)
    return (_in_plane if flat or thin else _in_space)(found, study)


def by_name(source: Any, shape: ShapeSpec) -> bool:
    """Whether a source is a section with a chord of 1, not a part of a mesh."""
    if isinstance(source, np.ndarray) or is_naca(source):
        return True
    if not isinstance(source, str) or shape.marker or not shape.normalise:
        return False
    return split_element(source)[0].lower().endswith(AIRFOILS)


def _section(source: Any, study: StudySpec, place: Place) -> Shape:
    """See 1."""
    target = study.objective.contour(place) if study.shape.trailing_edge == "match" else None
    gap, ends = (0.0, (1.0, 1.0)) if target is None else _missing(source, target)
    made = Section.of(source, gap, study.shape.points or POINTS, ends)
    return Shape(made.points, Surface.curve(made.points), judged=made.dense, placed=False)


def _missing(source: Any, target: Contour) -> tuple[float, tuple[float, float]]:
    """What the trailing edge of a source lacks: thickness, and factors of x on both surfaces."""
    own = None if is_naca(source) else target_contour(source)
    gap = trailing_gap(target) - (0.0 if own is None else trailing_gap(own))
    ends = trailing_ends(target) / (1.0 if own is None else trailing_ends(own))
    return gap, (float(ends[0]), float(ends[1]))


def moved(source: Any, shape: ShapeSpec, place: Place) -> Moved:
    """A mesh with its nodes where the study finds them."""
    if isinstance(source, Moved):
        return source
    mesh = source if isinstance(source, Mesh) else read_mesh(source)
    points = np.asarray(mesh.points)
    for pair in (lattice_pair(name, place) for name in shape.lattices):
        points = embed(pair.rest, points).deform(pair.current)
    return Moved(mesh, points)


def lattice_pair(source: str, place: Place) -> Pair:
    """A lattice at hand or in a file, at rest and as it is."""
    from ffdstudio.exchange import read_lattice

    found = place.found(source)
    return found if isinstance(found, Pair) else Pair(*read_lattice(found))


# ---- parts of meshes -----------------------------------------------------------------------


def _in_plane(body: Moved, study: StudySpec) -> Shape:
    points, mesh, marker = body.points, body.mesh, study.shape.marker
    if study.objective.whole:
        lines = _lines(mesh, marker)
        surface = Surface.edges(points, lines)
        contour = selig_order(mesh.points, lines)
        return Shape(points.copy(), surface, mesh, np.arange(len(points)), contour=contour)
    if study.shape.points is None and marker and mesh.dimension == 2:
        nodes = selig_order(mesh.points, _lines(mesh, marker))
        return Shape(points[nodes], Surface.curve(points[nodes]), mesh, nodes)
    nodes = profile_nodes(mesh, marker)
    outline = points[nodes]
    chord = Chord.of(outline)
    local = Contour.through(chord.local(outline)).sample(study.shape.points or POINTS)
    return Shape(chord.world(local), Surface.curve(local), mesh, nodes, outline=outline)


def profile_nodes(mesh: Mesh, marker: str) -> NDArray[np.int64]:
    """Nodes of a section in a mesh, in Selig's order; `InputError` if it is none."""
    for profile in profiles(mesh):
        if profile.marker == marker:
            if not np.array_equal(profile.axes, np.eye(3)[:2]):
                raise InputError(
                    f"the section of {_name(mesh)} does not lie along x and y, as studies need it"
                )
            return profile.nodes
    _elements(mesh, marker)
    raise InputError(f"{_part(mesh, marker)} is no airfoil section")


def _lines(mesh: Mesh, marker: str) -> NDArray[np.int64]:
    elements = _elements(mesh, marker)
    if "line" not in elements:
        raise InputError(f"{_part(mesh, marker)} is neither a contour nor a surface")
    return np.asarray(elements["line"])[:, :2]


def _in_space(body: Moved, study: StudySpec) -> Shape:
    points, mesh, marker = body.points, body.mesh, study.shape.marker
    triangles = triangles_of(_elements(mesh, marker))
    if not len(triangles):
        raise InputError(f"{_part(mesh, marker)} is neither a contour nor a surface")
    if study.objective.whole:
        surface = Surface.triangles(points, triangles)
        return Shape(points.copy(), surface, mesh, np.arange(len(points)), triangles)
    used, compact = np.unique(triangles, return_inverse=True)
    compact = compact.reshape(triangles.shape)
    return Shape(points[used], Surface.triangles(points[used], compact), mesh, used, compact)


def _elements(mesh: Mesh, marker: str) -> Any:
    """Elements of a marker; without one, those of a mesh that is nothing but a surface."""
    if marker in mesh.markers:
        return mesh.markers[marker]
    if marker:
        known = ", ".join(mesh.markers) or "none"
        raise InputError(f"{_name(mesh)} has no marker {marker!r}, only {known}")
    solid = any(name in mesh.cells for name in SOLID) or mesh.faces is not None
    if solid or (mesh.dimension == 2 and set(mesh.cells) != {"line"}):
        raise InputError("[shape] a mesh needs the name of a marker")
    return mesh.cells


def _part(mesh: Mesh, marker: str) -> str:
    return f"the marker {marker!r} of {_name(mesh)}" if marker else _name(mesh)


def _name(mesh: Mesh) -> str:
    return str(mesh.path or "the mesh")
