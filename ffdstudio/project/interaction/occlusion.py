"""Which control points lie behind a surface, as the viewer sees it: projection, no graphics card.

1. Only the few points under the cursor are asked about, so the triangles are asked for those
   that cover a pixel; what is projected is kept while neither camera nor model changes.
2. After division by w the depth is linear over the picture: it is interpolated like a plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.project.view.camera import Camera
from ffdstudio.project.view.surface import DisplaySurface, outer_polygons

if TYPE_CHECKING:
    from ffdstudio.project.document import Document
    from ffdstudio.project.model import Body

SLACK = 1e-6  # of the depth of the picture: what is nearer to a surface lies on it
MOST = 400_000  # triangles that there is time for


class Occluders:
    """The drawn surfaces of a document's bodies, as something that hides."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._triangles: dict[str, tuple[object, Indices]] = {}
        self._known: tuple[object, bytes] | None = None
        self._corners: list[Array] = []

    def hidden(self, camera: Camera, points: Array) -> Mask:
        """(n,) which of the points (n, 3) are behind a surface."""
        out = np.zeros(len(points), dtype=bool)
        if not len(points):
            return out
        corners = self._projected(camera)
        pixels, depth = camera.project_with_depth(points)
        for row, (place, far) in enumerate(zip(pixels, depth, strict=True)):
            out[row] = any(_covers(each, place, float(far)) for each in corners)
        return out

    def under(self, camera: Camera, x: float, y: float) -> Array | None:
        """(3,) point of the nearest drawn surface under a pixel; None if there is none."""
        place = np.array([x, y])
        found = [_depth(each, place) for each in self._projected(camera)]
        depth = min(found, default=np.inf)
        return camera.at_depth(x, y, depth) if np.isfinite(depth) else None

    def _projected(self, camera: Camera) -> list[Array]:
        """(t, 3, 3) corners of the triangles of each body in pixels and depth."""
        document = self._document
        stamp = np.asarray(camera.matrix).tobytes() + bytes(f"{camera.width}", "ascii")
        key = (document.model, stamp)
        if self._known is None or self._known[0] is not key[0] or self._known[1] != stamp:
            bodies = [body for body in document.model.bodies if body.visible]
            self._corners = [self._of(body, camera) for body in bodies if not is_plane(body.mesh)]
            self._known = key
        return self._corners

    def _of(self, body: Body, camera: Camera) -> Array:
        surface = self._document.surface(body.key)
        drawn = (surface, body.hidden_markers)
        known = self._triangles.get(body.key)
        if known is None or known[0] != drawn:
            known = (drawn, drawn_triangles(surface, body))
            self._triangles[body.key] = known
        pixels, depth = camera.project_with_depth(self._document.points(body.key))
        return np.column_stack([pixels, depth])[known[1]]


def drawn_triangles(surface: DisplaySurface, body: Body) -> Indices:
    """(t, 3) displayed points of the triangles that are drawn."""
    gone = [k for k, name in enumerate(surface.markers) if name in body.hidden_markers]
    keep = ~outer_polygons(surface, body.mesh) & ~np.isin(surface.polygon_marker, gone)
    sizes, parts = np.diff(surface.offsets), [np.empty((0, 3), dtype=np.int64)]
    for size in np.unique(sizes[keep]):
        chosen = np.flatnonzero(keep & (sizes == size))
        ring = surface.connectivity[surface.offsets[chosen][:, None] + np.arange(size)]
        parts += [ring[:, [0, k, k + 1]] for k in range(1, size - 1)]
    found = np.concatenate(parts)
    return found[:: 1 + len(found) // MOST]


def _covers(corners: Array, place: Array, depth: float) -> bool:
    """Whether one of the triangles (t, 3, 3) covers a pixel, nearer than a depth."""
    return bool(_depth(corners[corners[:, :, 2].min(axis=1) < depth], place) < depth - SLACK)


def _depth(corners: Array, place: Array) -> float:
    """Depth of the nearest of the triangles (t, 3, 3) that cover a pixel; else infinity."""
    flat = corners[:, :, :2]
    near = (flat.min(axis=1) <= place).all(axis=1) & (flat.max(axis=1) >= place).all(axis=1)
    a, b, c = np.moveaxis(corners[near], 1, 0)
    area = _cross(b - a, c - a)
    proper = area != 0
    a, b, c, area = a[proper], b[proper], c[proper], area[proper]
    v = _cross(place - a[:, :2], c - a) / area
    w = _cross(b - a, place - a[:, :2]) / area
    at = a[:, 2] + v * (b - a)[:, 2] + w * (c - a)[:, 2]
    inside = (v >= 0) & (w >= 0) & (v + w <= 1) & (np.abs(at) <= 1)
    return float(at[inside].min(initial=np.inf))


def _cross(one: Array, other: Array) -> Array:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
