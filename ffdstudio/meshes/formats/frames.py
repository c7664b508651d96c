"""Local frames in which a deck gives coordinates: rectangular, cylindrical, spherical.

Angles are in degrees. Cylindrical coordinates are r, theta, z; spherical ones r, theta from
the z axis, phi about it (S), or r, theta about it, phi from the plane of x and y (L). Back in
a frame, an angle is the one nearest to what the file had.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame: `kind` is R, C, S or L, `origin` (3,), and `axes` (3, 3) with x, y, z as rows."""

    kind: str
    origin: Array
    axes: Array

    @classmethod
    def through(cls, kind: str, origin: Array, on_z: Array, in_xz: Array) -> Frame:
        """Frame from its origin, a point on the z axis and one in the plane of x and z.

        Raises
        ------
        ValueError
            If the three points lie on a line.

        Examples
        --------
        >>> origin, on_z, in_xz = np.array([[1.0, 0, 0], [1, 0, 2], [1, 3, 1]])
        >>> Frame.through("R", origin, on_z, in_xz).to_global(np.array([[1.0, 0, 0]]))
        array([[1., 1., 0.]])
        """
        z = on_z - origin
        y = np.cross(z, in_xz - origin)
        sizes = np.linalg.norm(z), np.linalg.norm(y)
        if not (sizes[0] > 0 and sizes[1] > 1e-12 * sizes[0] * np.linalg.norm(in_xz - origin)):
            raise ValueError("the three points of a frame lie on a line")
        z, y = z / sizes[0], y / sizes[1]
        return cls(kind, origin, np.stack([np.cross(y, z), y, z]))

    def to_global(self, local: Array) -> Array:
        """(n, 3) points from their coordinates in this frame."""
        return self.origin + _straight(self.kind, local) @ self.axes

    def to_local(self, points: Array, near: Array) -> Array:
        """(n, 3) coordinates in this frame; angles nearest to those of `near`."""
        x, y, z = ((points - self.origin) @ self.axes.T).T
        if self.kind == "R":
            return np.stack([x, y, z], axis=1)
        flat = np.hypot(x, y)
        about = np.degrees(np.arctan2(y, x))
        if self.kind == "C":
            about = _near(np.where(flat > 0, about, near[:, 1]), near[:, 1])
            return np.stack([flat, about, z], axis=1)
        size = np.hypot(flat, z)
        if self.kind == "L":
            up = np.where(size > 0, np.degrees(np.arctan2(z, flat)), near[:, 2])
            about = _near(np.where(flat > 0, about, near[:, 1]), near[:, 1])
            return np.stack([size, about, up], axis=1)
        down = np.where(size > 0, np.degrees(np.arctan2(flat, z)), near[:, 1])
        about = _near(np.where(flat > 0, about, near[:, 2]), near[:, 2])
        return np.stack([size, down, about], axis=1)


def _near(angle: Array, other: Array) -> Array:
    return np.asarray(angle + 360 * np.rint((other - angle) / 360))


def _straight(kind: str, local: Array) -> Array:
    """Rectangular coordinates in the axes of the frame."""
    if kind == "R":
        return local
    r, first, second = local.T
    if kind == "C":
        t = np.radians(first)
        return np.stack([r * np.cos(t), r * np.sin(t), second], axis=1)
    if kind == "L":
        first, second = 90.0 - second, first
    t, p = np.radians(first), np.radians(second)
    flat = r * np.sin(t)
    return np.stack([flat * np.cos(p), flat * np.sin(p), r * np.cos(t)], axis=1)
