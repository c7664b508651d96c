"""The camera as a matrix: from points to pixels and from pixels to rays, in NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array


@dataclass(frozen=True, eq=False)
class Ray:
    """Half line from the viewer through a pixel: `origin` + s `direction`, s >= 0.

    Attributes
    ----------
    origin, direction : numpy.ndarray
        (3,) world coordinates; the direction has length 1 and points away from the viewer.
    """

    origin: Array
    direction: Array


@dataclass(frozen=True, eq=False)
class Camera:
    """Perspective or parallel projection onto a picture.

    Attributes
    ----------
    matrix : array_like
        (4, 4) from homogeneous world coordinates (a column) to clip coordinates; after
        division by w, x to the right, y upwards and z away are within [-1, 1] in the picture.
    width, height : float
        Of the picture, in pixels. Pixel coordinates count from its upper left corner, y down.

    Examples
    --------
    >>> camera = Camera(np.eye(4), 200, 100)
    >>> camera.project([[0.5, 0.5, 0.0]])
    array([[150.,  25.]])
    """

    matrix: ArrayLike
    width: float
    height: float

    @cached_property
    def _forward(self) -> Array:
        return np.asarray(self.matrix, dtype=np.float64)

    @cached_property
    def _inverse(self) -> Array:
        return np.asarray(np.linalg.inv(self._forward), dtype=np.float64)

    @property
    def parallel(self) -> bool:
        """Whether all rays are parallel."""
        return not self._forward[3, :3].any()

    def project(self, points: ArrayLike) -> Array:
        """(n, 2) pixels of (n, 3) points; NaN for points behind the viewer."""
        return self.project_with_depth(points)[0]

    def project_with_depth(self, points: ArrayLike) -> tuple[Array, Array]:
        """Return pixels and the (n,) depth, which grows away from the viewer."""
        array = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        clip = array @ self._forward[:, :3].T + self._forward[:, 3]
        w = np.where(clip[:, 3] > 0, clip[:, 3], np.nan)[:, None]
        device = clip[:, :3] / w
        half = np.array([self.width, self.height]) / 2
        pixels: Array = half + half * [1, -1] * device[:, :2]
        return pixels, device[:, 2]

    def ray(self, x: float, y: float) -> Ray:
        """Ray through a pixel."""
        near, far = self._unproject(x, y, -1.0), self._unproject(x, y, 1.0)
        return Ray(near, (far - near) / float(np.linalg.norm(far - near)))

    def _unproject(self, x: float, y: float, depth: float) -> Array:
        device = [2 * x / self.width - 1, 1 - 2 * y / self.height, depth, 1.0]
        point = self._inverse @ device
        result: Array = point[:3] / point[3]
        return result

    def at_depth(self, x: float, y: float, depth: float) -> Array:
        """(3,) world point at a pixel and a depth as `project_with_depth` has it.

        Examples
        --------
        >>> Camera(np.eye(4), 200, 100).at_depth(150, 25, 0.25)
        array([0.5 , 0.5 , 0.25])
        """
        return self._unproject(x, y, depth)

    @property
    def forward(self) -> Array:
        """(3,) direction in which the camera looks: the normal of the picture."""
        return self.ray(self.width / 2, self.height / 2).direction

    def pixel_size(self, point: ArrayLike) -> float:
        """Length of one pixel at a point, in world units; vertically, facing the camera."""
        here: Array = np.asarray(point, dtype=np.float64)
        x, y = self.project(here)[0]
        return float(np.linalg.norm(facing(self.ray(x, y - 1), here, self.forward) - here))


def facing(ray: Ray, point: Array, normal: Array) -> Array:
    """Where a ray meets the plane through a point."""
    s = (point - ray.origin) @ normal / (ray.direction @ normal)
    return ray.origin + s * ray.direction
