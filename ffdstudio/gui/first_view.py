"""What the user came for: the walls in a mesh, as against the far field around them."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.project.document import Document
from ffdstudio.project.view.surface import Surface

SMALL = 0.25  # of the diagonal of the whole mesh: a marker that is smaller is a wall
ROOM = {2: 0.6, 3: 0.1}  # of a wall's extent, around it in the first picture, by dimension


def walls(surface: Surface, points: Array) -> tuple[str, ...]:
    """Markers that are much smaller than the mesh; none if all are, or if there are none.

    Examples
    --------
    >>> wall, far = np.eye(3), 100 * np.array([[1.0, 0, 0], [-1, 0, 0]])
    >>> lines = np.array([[0, 1], [1, 2], [3, 4]])
    >>> none = np.zeros(0, dtype=np.int64)
    >>> marked = np.array([0, 0, 1])
    >>> surface = Surface(np.arange(5), none, np.zeros(1, int), lines, none, marked, ("w", "f"))
    >>> walls(surface, np.concatenate([wall, far]))
    ('w',)
    """
    if not len(points):
        return ()
    limit = SMALL * float(np.linalg.norm(np.ptp(points, axis=0)))
    rows = {name: surface.marker_points(name) for name in surface.markers}
    small = tuple(
        name
        for name, chosen in rows.items()
        if len(chosen) and np.linalg.norm(np.ptp(points[chosen], axis=0)) <= limit
    )
    return small if len(small) < len(surface.markers) else ()


def first_bounds(surface: Surface, points: Array, dimension: int) -> Array:
    """(2, 3) box to show at first: around the walls with some room, or everything."""
    names = walls(surface, points)
    if not names:
        return np.array([points.min(axis=0), points.max(axis=0)])
    chosen = points[np.concatenate([surface.marker_points(name) for name in names])]
    low, high = chosen.min(axis=0), chosen.max(axis=0)
    room = ROOM[dimension] * float((high - low).max()) * np.array([1, 1, dimension - 2])
    return np.array([low - room / 2, high + room / 2])


def interesting(document: Document) -> Array | None:
    """(2, 3) box around what the user came for in all bodies; None if there is nothing."""
    boxes = [
        first_bounds(document.surface(body.key), document.points(body.key), body.mesh.dimension)
        for body in document.model.bodies
        if len(document.points(body.key))
    ]
    if not boxes:
        return None
    return np.array([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))])
