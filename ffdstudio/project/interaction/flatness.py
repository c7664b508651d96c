"""The plane that flat things stay in, and what of a lock is left in it.

A mesh of two dimensions has no third coordinate to be written to: whatever moves its points out
of the plane cannot be exported, so no gesture, field or dialog offers it.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.project.interaction.dragging import Lock
from ffdstudio.project.model import Model

PARALLEL = 1e-9  # sine of an angle that counts as none


def plane_of(model: Model) -> Lock | None:
    """Plane of the active lattice if it has two directions, or of a scene of 2D meshes."""
    item, bodies = model.active_lattice, model.bodies
    if item is not None and item.rest.dimension == 2:
        return Lock(tuple(np.cross(*item.rest.axes).tolist()), plane=True)
    if bodies and all(body.mesh.dimension == 2 for body in bodies):
        return Lock((0.0, 0.0, 1.0), plane=True)
    return None


def normal_axis(plane: Lock | None) -> int | None:
    """Coordinate axis (0, 1, 2) that a plane is at right angles to, if there is one.

    Examples
    --------
    >>> normal_axis(Lock((0.0, 0.0, -1.0), plane=True)), normal_axis(None)
    (2, None)
    """
    if plane is None:
        return None
    along = np.abs(plane.direction)
    best = int(np.argmax(along))
    return best if np.delete(along, best).max() < PARALLEL else None


def within(lock: Lock, plane: Lock | None) -> Lock | None:
    """What a lock allows inside a plane; None if it leads out of it.

    Examples
    --------
    >>> flat = Lock((0.0, 0.0, 1.0), plane=True)
    >>> within(Lock.axis(0), flat).name, within(Lock.axis(2), flat)
    ('X', None)
    >>> within(Lock.without(0), flat).name, within(Lock.without(2), flat) == flat
    ('Y', True)
    """
    if plane is None:
        return lock
    normal, along = np.array(plane.direction), np.array(lock.direction)
    if not lock.plane:
        return lock if abs(normal @ along) < PARALLEL else None
    line = np.cross(normal, along)
    length = float(np.linalg.norm(line))
    if length < PARALLEL:
        return plane
    line = line / length
    letter = normal_axis(Lock(tuple(line.tolist())))
    return Lock(tuple(line.tolist()), name=lock.name if letter is None else "XYZ"[letter])
