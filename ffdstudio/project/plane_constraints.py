"""Control points on a plane that boundary nodes have to stay in: they slide in it.

1. A lattice that begins at a symmetry plane keeps it plane if the control points on it keep
   their distance from it, which is none; what they do within the plane is free.
2. A point on two planes slides along their common line, one on three stays where it is.
3. A normal along a coordinate axis takes that coordinate from the rest, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.meshes.planes import Plane, planes_of
from ffdstudio.project.model import Index, Model

Where = tuple[NDArray[np.intp], ...]
ON_PLANE = 1e-9  # of the net's diagonal, as for points on a lattice's face
PARALLEL = 1e-6  # what is left of a unit normal that tells nothing new


def planes_in(model: Model) -> tuple[Plane, ...]:
    """Planes of all bodies as they were read."""
    return tuple(plane for body in model.bodies for plane in planes_of(body.mesh))


def lying(rest: Lattice, places: Array, planes: Sequence[Plane]) -> NDArray[np.bool_]:
    """(k, planes) which of the places (k, 3) at rest lie on which plane."""
    slack = ON_PLANE * rest.diagonal
    found = [np.abs(plane.distances(places)) <= slack for plane in planes]
    return np.array(found, dtype=bool).reshape(len(planes), len(places)).T


def slid(rest: Lattice, where: Where, positions: Array, planes: Sequence[Plane]) -> Array:
    """Positions (k, 3) of control points without what leads away from their planes.

    Parameters
    ----------
    rest : Lattice
        Undeformed.
    where : tuple of numpy.ndarray
        Index arrays (k,) of the control points.
    positions : numpy.ndarray
        (k, 3) where they are wanted.
    planes : sequence of Plane

    Examples
    --------
    >>> plane = Plane("SYM", "symmetry", np.arange(0), np.array([0.0, 1, 0]), 0.0)
    >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(2, 2, 2))
    >>> corner = np.array([[0]] * 3)
    >>> slid(box, tuple(corner), np.array([[0.5, 0.25, 0]]), [plane])
    array([[0.5, 0. , 0. ]])
    """
    places = rest.control_points[where]
    on = lying(rest, places, planes)
    if not on.any():
        return positions
    new = positions.copy()
    for pattern in np.unique(on, axis=0):
        rows = (on == pattern).all(axis=1)
        for normal in _basis([p.normal for p, held in zip(planes, pattern, strict=True) if held]):
            new[rows] = _without(normal, places[rows], new[rows])
    return new


def alike(rest: Lattice, where: Where, vector: Array, planes: Sequence[Plane]) -> Array | None:
    """Make of a vector what the control points make of it; None where they differ in that."""
    on = lying(rest, rest.control_points[where], planes)
    if not on.any():
        return vector
    if (on != on[0]).any():
        return None
    for normal in _basis([p.normal for p, held in zip(planes, on[0], strict=True) if held]):
        vector = _without(normal, np.zeros(3), vector)
    return vector


def names_at(rest: Lattice, point: Index, planes: Sequence[Plane]) -> tuple[str, ...]:
    """Markers in whose planes a control point slides."""
    on = lying(rest, rest.control_points[point][None], planes)
    names = [plane.name for plane, held in zip(planes, on.reshape(-1), strict=True) if held]
    return tuple(dict.fromkeys(names))


def leaving(rest: Lattice, current: Lattice, planes: Sequence[Plane]) -> list[str]:
    """Sentences about control points that lie on a plane at rest and do not any more."""
    places = rest.control_points.reshape(-1, 3)
    step = current.control_points.reshape(-1, 3) - places
    slack, found = ON_PLANE * rest.diagonal, []
    for plane, on in zip(planes, lying(rest, places, planes).T, strict=True):
        off = np.abs(step[on] @ plane.normal)
        bad = int((off > slack).sum())
        if bad:
            what = "a control point" if bad == 1 else f"{bad} control points"
            leave = "leaves" if bad == 1 else "leave"
            found.append(f"{what} on {plane.name} {leave} its plane, by up to {off.max():.3g}")
    return found


def _basis(normals: Sequence[Array]) -> list[Array]:
    """Orthonormal vectors that span normals; the first normal is the first of them."""
    found: list[Array] = []
    for normal in normals:
        left = normal - sum((axis * (axis @ normal) for axis in found), np.zeros(3))
        length = float(np.linalg.norm(left))
        if length > PARALLEL:
            found.append(left if length == 1 else left / length)
    return found


def _without(normal: Array, origin: Array, places: Array) -> Array:
    """Places moved along a unit normal to the height of their origins."""
    largest = int(np.argmax(np.abs(normal)))
    if abs(normal[largest]) == 1:
        new = places.copy()
        new[..., largest] = origin[..., largest]
        return new
    return np.asarray(places - ((places - origin) @ normal)[..., None] * normal)
