"""Dragging the skin itself: a point of the mesh goes with the mouse, the lattice is solved for.

1. A point of the mesh moves by sum N_k dP_k, N its basis functions in the active lattice. Of all
   moves of control points that take it where it is wanted the smallest is taken (least squares):
   dP_k = N_k D / sum N_k^2. Frozen points, and those that are selected, are held.
2. A control point on a symmetry plane slides in it: along the normal it takes no part.
3. As for the guard, the lattice has to be the last one that deforms.

Hsu, Hughes and Kaufman, Direct manipulation of free-form deformations, SIGGRAPH 1992.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import embed
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.project.checks.guarding import is_last
from ffdstudio.project.followers import deformed
from ffdstudio.project.interaction.occlusion import Occluders
from ffdstudio.project.model import Index, LatticeItem
from ffdstudio.project.plane_constraints import planes_in, slid
from ffdstudio.project.view.camera import Camera

if TYPE_CHECKING:
    from ffdstudio.project.document import Document

NEAR = 14.0  # pixels from the cursor to a point of the mesh, at most
LEAST = 1e-9  # of an influence: less is none


@dataclass(frozen=True, eq=False)
class SkinPoint:
    """A point of a displayed surface.

    Attributes
    ----------
    body : str
        Key of its body.
    row : int
        Among the displayed points.
    place : numpy.ndarray
        (3,) where it is now.
    """

    body: str
    row: int
    place: Array


@dataclass(frozen=True, eq=False)
class Handle:
    """What moves with a point of the skin.

    Attributes
    ----------
    points : tuple of tuple of int
        Control points that move, ascending.
    shares : numpy.ndarray
        (k, 3) by how much each moves for a unit move of the skin, by coordinate.
    """

    points: tuple[Index, ...]
    shares: Array

    def move(self, vector: Array) -> Array:
        """(k, 3) moves of the control points that move the skin by a vector."""
        return self.shares * vector


def skin_under(
    document: Document, occluders: Occluders, camera: Camera, x: float, y: float
) -> SkinPoint | None:
    """Point of a displayed surface that is seen nearest to a pixel; None if none is near."""
    hit = occluders.under(camera, x, y)
    best: tuple[float, SkinPoint] | None = None
    for body in document.model.bodies:
        if not body.visible:
            continue
        points = document.points(body.key)
        pixels, depth = camera.project_with_depth(points)
        distance = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        distance[~(np.abs(depth) <= 1)] = np.inf
        if hit is None and not is_plane(body.mesh):
            continue
        near = np.flatnonzero(distance <= NEAR)
        if not len(near):
            continue
        if hit is not None:  # of those in the picture the one next to what the cursor is on
            row = int(near[np.argmin(np.linalg.norm(points[near] - hit, axis=1))])
        else:
            row = int(near[np.argmin(distance[near])])
        found = SkinPoint(body.key, row, points[row].copy())
        if best is None or distance[row] < best[0]:
            best = float(distance[row]), found
    return None if best is None else best[1]


def handle_of(document: Document, point: SkinPoint, held: Iterable[Index] = ()) -> Handle | None:
    """What moves with a point of the skin; None if no control point that is free moves it."""
    model = document.model
    item = model.active_lattice
    if item is None or not is_last(model, item):
        return None
    surface, body = document.surface(point.body), model.body(point.body)
    start = body.mesh.points[surface.nodes[point.row]][None]
    earlier = model.steps[: [step.key for step in model.steps].index(item.key)]
    embedding = embed(item.rest, deformed(start, earlier))
    shares = embedding.jacobian(item.current).toarray()[0].reshape(item.rest.shape)
    free = ~item.frozen_mask & (shares > LEAST)
    for index in held:
        free[index] = False
    points: tuple[Index, ...] = tuple(map(tuple, np.argwhere(free).tolist()))
    if not points:
        return None
    return Handle(points, smallest(shares[free], _allowed(document, item, points)))


def smallest(influences: Array, allowed: Array) -> Array:
    """(k, 3) smallest moves for a unit move of a point, by coordinate.

    Parameters
    ----------
    influences : numpy.ndarray
        (k,) basis functions at the point.
    allowed : numpy.ndarray
        (k, 3) 1 where a control point may move along a coordinate, else 0.

    Examples
    --------
    >>> smallest(np.array([0.5, 0.5]), np.array([[1, 1, 0], [1, 0, 0.0]]))
    array([[1., 2., 0.],
           [1., 0., 0.]])
    """
    taking = influences[:, None] * allowed
    total = (taking**2).sum(axis=0)
    return np.asarray(taking / np.where(total > 0, total, np.inf))


def _allowed(document: Document, item: LatticeItem, points: tuple[Index, ...]) -> Array:
    where = tuple(np.array(points).T)
    start, planes = item.rest.control_points[where], planes_in(document.model)
    size = item.rest.diagonal
    moved = [slid(item.rest, where, start + size * axis, planes) - start for axis in np.eye(3)]
    columns = [np.abs(step[:, k]) > 0.5 * size for k, step in enumerate(moved)]
    return np.asarray(np.column_stack(columns), dtype=np.float64)
