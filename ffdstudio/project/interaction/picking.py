"""Which control point is under the cursor: by projection, without asking the graphics card."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Mask
from ffdstudio.project.view.camera import Camera

SAME_SPOT = 3.0  # pixels within which depth decides


def nearest(
    camera: Camera, points: ArrayLike, x: float, y: float, radius: float = 10.0
) -> int | None:
    """Row of the point under a pixel, or None.

    Of the points within `radius` pixels the nearest one counts; where several lie over one
    another to about the size of their dots, the one in front.

    Examples
    --------
    >>> camera = Camera(np.diag([1.0, 1.0, 0.1, 1.0]), 100, 100)
    >>> nearest(camera, [[0, 0, 1], [0, 0, -1], [0.5, 0, 0]], 51, 50)
    1
    """
    pixels, depth = camera.project_with_depth(points)
    distance = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
    distance[~(np.abs(depth) <= 1)] = np.inf  # behind, or cut off
    if not len(distance) or not distance.min() <= radius:
        return None
    close = np.flatnonzero(distance <= min(distance.min() + SAME_SPOT, radius))
    return int(close[np.argmin(depth[close])])


def near(camera: Camera, points: ArrayLike, x: float, y: float, radius: float) -> Mask:
    """(n,) which points are within some pixels of a pixel."""
    pixels = camera.project(points)
    return np.asarray(np.hypot(pixels[:, 0] - x, pixels[:, 1] - y) <= radius)


def in_rectangle(
    camera: Camera, points: ArrayLike, corner: tuple[float, float], other: tuple[float, float]
) -> NDArray[np.int64]:
    """Rows of the points inside a rectangle of pixels between two opposite corners."""
    pixels = camera.project(points)
    low, high = np.minimum(corner, other), np.maximum(corner, other)
    return np.flatnonzero(((pixels >= low) & (pixels <= high)).all(axis=1))
