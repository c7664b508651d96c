"""How far a drag has gone: from cursor and camera to a displacement, as pure functions.

1. Everything is computed from where the drag began; nothing accumulates.
2. The anchor, the point that was grabbed, keeps its distance to the cursor in pixels: it
   need not be hit exactly, and stays under the cursor wherever the lock allows it.
3. A free drag stays in the plane through the anchor that faces the camera.
4. On an axis the anchor goes to the point nearest to the ray through the cursor. Where the
   axis is within 5 degrees of the ray that point is ill-defined: vertical mouse travel
   counts instead. Past the vanishing point of the axis the drag stops at a large distance.
5. In a plane the anchor goes to where the ray meets it; a plane seen edge-on takes the
   free displacement without its normal part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.project.view.camera import Camera, Ray, facing

Pixel = tuple[float, float]

ALONG_VIEW = np.cos(np.radians(5.0))
EDGE_ON = np.sin(np.radians(5.0))
FINE = 0.1
FAR = 100.0  # times the distance to the viewer
SNAP_PIXELS = 12.0


@dataclass(frozen=True)
class Lock:
    """Restriction of a drag: along an axis, or in the plane with a normal.

    Attributes
    ----------
    direction : tuple of float
        (3,) unit vector: of the axis, or normal to the plane.
    plane : bool
    name : str
        For the read-out: ``X``, ``YZ``.
    """

    direction: tuple[float, ...]
    plane: bool = False
    name: str = ""

    @classmethod
    def axis(cls, number: int) -> Lock:
        """Lock to a coordinate axis."""
        return cls(tuple(np.eye(3)[number].tolist()), False, "XYZ"[number])

    @classmethod
    def without(cls, number: int) -> Lock:
        """Lock to the plane of the two other coordinate axes."""
        return cls(tuple(np.eye(3)[number].tolist()), True, "XYZ".replace("XYZ"[number], ""))


def displacement(
    camera: Camera,
    anchor: ArrayLike,
    begin: Pixel,
    cursor: Pixel,
    lock: Lock | None = None,
    fine: bool = False,
    snap: float = 0.0,
) -> Array:
    """(3,) displacement of the anchor since the drag began.

    Parameters
    ----------
    camera : Camera
    anchor : array_like
        (3,) where the grabbed point was.
    begin, cursor : tuple of float
        Pixels where the drag began and where the cursor is.
    lock : Lock, optional
        Axis or plane to stay in; by default the plane facing the camera.
    fine : bool
        Move by one tenth only.
    snap : float
        Round the displacement to multiples of this length, 0 for no rounding.

    Examples
    --------
    >>> camera = Camera(np.eye(4), 200, 200)
    >>> displacement(camera, [0, 0, 0], (100, 100), (150, 50))
    array([0.5, 0.5, 0. ])
    """
    start = np.asarray(anchor, dtype=np.float64)
    if begin == cursor:
        return np.zeros(3)
    x, y = camera.project([start])[0] + np.subtract(cursor, begin)
    ray = camera.ray(x, y)
    if lock is None:
        move = _free(camera, ray, start)
    elif lock.plane:
        move = _in_plane(camera, ray, start, np.array(lock.direction))
    else:
        move = _on_axis(camera, ray, start, np.array(lock.direction), begin[1] - cursor[1])
    return _snapped(move * FINE if fine else move, lock, snap)


def snap_step(camera: Camera, anchor: ArrayLike) -> float:
    """Length to snap to: 1, 2 or 5 times a power of ten, at least some pixels wide."""
    least = SNAP_PIXELS * camera.pixel_size(anchor)
    power = 10.0 ** float(np.floor(np.log10(least)))
    result: float = next(n * power for n in (1, 2, 5, 10) if n * power >= least)
    return result


def _free(camera: Camera, ray: Ray, start: Array) -> Array:
    return facing(ray, start, camera.forward) - start


def _in_plane(camera: Camera, ray: Ray, start: Array, normal: Array) -> Array:
    slope = ray.direction @ normal
    reach = (start - ray.origin) @ normal / slope if abs(slope) > EDGE_ON else -1.0
    move = _free(camera, ray, start)
    if reach > 0:
        move = ray.origin + reach * ray.direction - start
    return move - (move @ normal) * normal  # exactly nothing along a coordinate axis


def _on_axis(camera: Camera, ray: Ray, start: Array, axis: Array, up: float) -> Array:
    view = camera.ray(*camera.project([start])[0]).direction
    if abs(view @ axis) > ALONG_VIEW:
        return up * camera.pixel_size(start) * axis
    limit = FAR * float(np.linalg.norm(start - ray.origin))
    result: Array = np.clip(_nearest(ray, start, axis), -limit, limit) * axis
    return result


def _nearest(ray: Ray, start: Array, axis: Array) -> float:
    """Length along the axis to the point nearest to the ray."""
    offset, cosine = ray.origin - start, float(axis @ ray.direction)
    sine = max(1 - cosine**2, 1e-12)
    along = (axis @ offset - cosine * (ray.direction @ offset)) / sine
    behind = (along * axis - offset) @ ray.direction < 0  # past the vanishing point
    return float(-np.sign(along) * np.inf if behind else along)


def _snapped(move: Array, lock: Lock | None, step: float) -> Array:
    if step <= 0:
        return move
    if lock is None:
        return np.round(move / step) * step
    if not lock.plane:
        axis = np.array(lock.direction)
        result: Array = np.round(move @ axis / step) * step * axis
        return result
    basis = _basis(np.array(lock.direction))
    return np.round(basis @ move / step) * step @ basis


def _basis(normal: Array) -> Array:
    """(2, 3) unit vectors of a plane, along the coordinate axes where that is possible."""
    first: Array = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])
