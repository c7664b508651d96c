"""What the user came for: the walls in a mesh, as against the far field around them."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.quasi2d import is_plane, plane_axes
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.project.document import Document
from ffdstudio.project.view.surface import DisplaySurface

ROOM = {2: 0.6, 3: 0.1}  # of a wall's extent, around it in the first picture, by dimension


def first_bounds(surface: DisplaySurface, points: Array, mesh: Mesh) -> Array:
    """(2, 3) box to show at first: around the walls with some room, or everything."""
    names = wall_markers(mesh)
    if not names:
        return np.array([points.min(axis=0), points.max(axis=0)])
    chosen = points[np.concatenate([surface.marker_points(name) for name in names])]
    low, high = chosen.min(axis=0), chosen.max(axis=0)
    room = ROOM[2 if is_plane(mesh) else 3] * float((high - low).max()) * np.ones(3)
    if is_plane(mesh):
        axes = plane_axes(mesh)
        room = room * (np.abs(axes).max(axis=0) > 0)
    return np.array([low - room / 2, high + room / 2])


def interesting(document: Document) -> Array | None:
    """(2, 3) box around what the user came for in all bodies; None if there is nothing."""
    boxes = [
        first_bounds(document.surface(body.key), document.points(body.key), body.mesh)
        for body in document.model.bodies
        if len(document.points(body.key))
    ]
    if not boxes:
        return None
    return np.array([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))])
