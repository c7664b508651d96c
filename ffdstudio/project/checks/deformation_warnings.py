"""What a user should know of a deformed mesh before it is written."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.planes import planes_of
from ffdstudio.project.checks.freezing import face_names, torn_faces
from ffdstudio.project.plane_constraints import leaving

TOUCH = 1e-9  # of the diagonal: layers nearer than this lie on each other


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
    told = [*leaving(rest, current, planes_of(mesh)), *found, *_torn(mesh, rest, current)]
    return [*told, *parted_seams(rest, current)]


def parted_seams(rest: Lattice, current: Lattice) -> list[str]:
    """What to say of a ring with ends that lie on each other at rest and move apart.

    A lattice that is periodic in that direction has no such ends.

    Examples
    --------
    >>> ring = Lattice.cylinder((1, 2), shape=(2, 8)).clamped()
    >>> net = ring.control_points.copy()
    >>> net[:, 0] += 0.1
    >>> len(parted_seams(ring, ring.moved(net))), parted_seams(ring, ring)
    (1, [])
    """
    told = []
    for axis, name in enumerate("ijk"[: rest.dimension]):
        if rest.periodic[axis] or _gap(rest, axis) > TOUCH * rest.diagonal:
            continue
        gap = _gap(current, axis)
        if gap > TOUCH * rest.diagonal:
            told.append(
                f"the lattice closes on itself along {name} at rest and its two ends move apart by "
                f"up to {gap:.4g}: the mesh steps there (a periodic direction has no ends)"
            )
    return told


def _gap(lattice: Lattice, axis: int) -> float:
    """Largest distance between the first and the last layer of a direction, or of their weights."""
    net = np.moveaxis(lattice.control_points, axis, 0)
    weights = np.moveaxis(lattice.weights, axis, 0)
    apart = float(np.linalg.norm(net[0] - net[-1], axis=-1).max())
    return max(apart, lattice.diagonal * float(np.abs(weights[0] - weights[-1]).max()))


def _torn(mesh: Mesh, rest: Lattice, current: Lattice) -> list[str]:
    faces = torn_faces(rest, current, mesh)
    if not faces:
        return []
    return [
        f"outermost control points move at {face_names(faces)}, where mesh lies on both sides of "
        "the lattice's face: smoothness ends there (a frozen layer keeps it)"
    ]
