"""What a user should know of a deformed mesh before it is written."""

from __future__ import annotations

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.planes import planes_of
from ffdstudio.project.checks.freezing import face_names, torn_faces
from ffdstudio.project.plane_constraints import leaving


def remarks(
    mesh: Mesh, points: Array, rest: Lattice, current: Lattice, carried: bool = True
) -> list[str]:
    """Sentences without full stop: planes left, partners parted, smoothness that ends.

    Parameters
    ----------
    mesh : Mesh
        Undeformed.
    points : numpy.ndarray
        (n, 3) its nodes as deformed.
    rest, current : Lattice
        What has deformed it.
    carried : bool
        Whether the lattice moves all nodes, not the walls alone.
    """
    found = broken(mesh, points)
    if not carried:
        return found
    return [*leaving(rest, current, planes_of(mesh)), *found, *_torn(mesh, rest, current)]


def _torn(mesh: Mesh, rest: Lattice, current: Lattice) -> list[str]:
    faces = torn_faces(rest, current, mesh)
    if not faces:
        return []
    return [
        f"outermost control points move at {face_names(faces)}, where mesh lies on both sides of "
        "the lattice's face: smoothness ends there (a frozen layer keeps it)"
    ]
