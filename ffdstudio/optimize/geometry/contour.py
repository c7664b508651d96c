"""Airfoil contours as C2 cubic splines over arc length.

1. Points run from the upper trailing edge over the nose to the lower trailing edge, so the
   upper surface is the part of the spline before the nose (its least x).
2. The nearest point is sought on one surface only: near a sharp trailing edge a free search
   jumps to the other one. Around the nose the two overlap a little: points that were foremost
   before a deformation may have come to lie just behind the nose of the deformed contour.
3. Normalised means x in [0, 1] on the spline's true least x; y keeps its origin, for the
   nose of a tabulated section need not lie at y = 0.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Mask
from ffdstudio.errors import InputError

OVERLAP = 3e-4  # of the length: how far a surface reaches around the nose; with 1e-2 points of one
# side settle on the other where the nose is sharp (AG35)


class Footpoints(NamedTuple):
    """Nearest points of a contour: distance with sign, and its derivative by the point."""

    distance: Array  # (n,), positive on the outside
    direction: Array  # (n, 2), d distance / d point


class Contour:
    """An airfoil contour through points.

    Parameters
    ----------
    points : array_like
        (m, 2) or (m, 3) from the upper trailing edge over the nose to the lower trailing
        edge (Selig order), m >= 5. A third coordinate is ignored.
    normalise : bool
        Scale and shift to x in [0, 1] on the spline's true least x.

    Raises
    ------
    InputError
        If the points are too few, not finite, or have no nose between their ends.

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 60)
    >>> circle = Contour(0.5 + 0.5 * np.column_stack([np.cos(angle), np.sin(angle)]))
    >>> foot = circle.nearest([[0.5, 1.25]], np.array([True]))
    >>> abs(foot.distance[0] - 0.25) < 1e-5
    np.True_
    """

    def __init__(self, points: ArrayLike, normalise: bool = True) -> None:
        xy = _checked(points)
        self._fit(xy)
        if normalise:
            self._fit((xy - [self.nose_x, 0.0]) / (xy[[0, -1], 0].max() - self.nose_x))

    def _fit(self, xy: Array) -> None:
        from scipy.interpolate import CubicSpline

        with np.errstate(over="ignore", invalid="ignore"):
            s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xy, axis=0), axis=1))])
        if not (np.isfinite(s).all() and (np.diff(s) > 0).all()):
            raise InputError("the points of this section are too far apart or too near for a curve")
        self.points = xy
        self.spline = CubicSpline(s, xy)
        self.length = float(s[-1])
        self.nose = _least_x(self.spline, s, xy)
        self.nose_x = float(self.spline(self.nose)[0])
        over = OVERLAP * self.length
        self._tables = {
            True: self._table(0.0, self.nose + over),
            False: self._table(self.nose - over, self.length),
        }

    def _table(self, start: float, end: float) -> tuple[Array, Any]:
        """Parameters along one surface, dense, and a search tree of their points."""
        from scipy.spatial import cKDTree

        s = self._dense(start, end)
        return s, cKDTree(self.spline(s))

    def _dense(self, start: float, end: float) -> Array:
        inner = self.spline.x[(self.spline.x > start) & (self.spline.x < end)]
        ends = np.concatenate([[start], inner, [end]])
        result: Array = np.interp(
            np.linspace(0, len(ends) - 1, 12 * (len(ends) - 1) + 1), range(len(ends)), ends
        )
        return result

    @classmethod
    def through(cls, points: ArrayLike) -> Self:
        """Contour through points as they are."""
        return cls(points, normalise=False)

    def nearest(self, points: ArrayLike, upper: Mask) -> Footpoints:
        """Signed distance of (n, 2+) points to the surface that `upper` names for each."""
        xy = np.asarray(points, dtype=np.float64)[:, :2]
        s = np.empty(len(xy))
        for surface in (True, False):
            mine = upper == surface
            if mine.any():
                s[mine] = self._project(xy[mine], *self._tables[surface])
        return self._footpoints(xy, s)

    def _project(self, xy: Array, table: Array, tree: Any) -> Array:
        """Parameter of the nearest point on one surface: tabulated start, Newton, clamped."""
        nearest = tree.query(xy)[1]
        low, high = (
            table[np.maximum(nearest - 1, 0)],
            table[np.minimum(nearest + 1, len(table) - 1)],
        )
        s = table[nearest]
        for _ in range(12):
            gap, tangent, bend = self.spline(s) - xy, self.spline(s, 1), self.spline(s, 2)
            slope = np.einsum("ij,ij->i", gap, tangent)
            curvature = np.einsum("ij,ij->i", tangent, tangent) + np.einsum("ij,ij->i", gap, bend)
            square = np.einsum("ij,ij->i", tangent, tangent)
            step = slope / np.where(curvature > 0.1 * square, curvature, square)
            new = np.clip(s - step, low, high)
            if np.abs(new - s).max() <= 1e-15 * self.length:
                break
            s = new
        result: Array = new
        return result

    def _footpoints(self, xy: Array, s: Array) -> Footpoints:
        tangent = self.spline(s, 1)
        normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        gap = xy - self.spline(s)
        along = np.einsum("ij,ij->i", gap, normal)
        length = np.linalg.norm(gap, axis=1)
        # past the end of a surface the gap is not normal to it: the end point is the nearest
        beyond = length > (1 + 1e-6) * np.abs(along) + 1e-13 * self.length
        sign = np.where(along < 0, -1.0, 1.0)
        ends = sign[:, None] * gap / np.where(beyond, length, 1.0)[:, None]
        return Footpoints(
            np.where(beyond, sign * length, along), np.where(beyond[:, None], ends, normal)
        )

    def at(self, x: ArrayLike, upper: Mask) -> Array:
        """(n, 2) points with given abscissae on the surface that `upper` names for each."""
        x = np.asarray(x, dtype=np.float64)
        s = np.empty(len(x))
        for surface in (True, False):
            mine = upper == surface
            if mine.any():
                ends = (0.0, self.nose) if surface else (self.nose, self.length)
                s[mine] = self._parameter_at(x[mine], self._dense(*ends))
        return self.spline(s)

    def _parameter_at(self, x: Array, table: Array) -> Array:
        """Bisection on one surface, where x falls or rises; ends are clamped."""
        values = self.spline(table)[:, 0]
        if values[0] > values[-1]:
            table, values = table[::-1], values[::-1]
        index = np.clip(np.searchsorted(np.maximum.accumulate(values), x), 1, len(values) - 1)
        low, high = table[index - 1].copy(), table[index].copy()
        for _ in range(60):
            middle = 0.5 * (low + high)
            below = self.spline(middle)[:, 0] < x
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return 0.5 * (low + high)

    def sample(self, count: int) -> Array:
        """(count, 3) points at cosine-spaced abscissae, `count` odd, the nose in the middle.

        Examples
        --------
        >>> angle = np.linspace(0, 2 * np.pi, 60)
        >>> circle = Contour(0.5 + 0.5 * np.column_stack([np.cos(angle), np.sin(angle)]))
        >>> abs(circle.sample(5)[:, 0].round(6))
        array([1. , 0.5, 0. , 0.5, 1. ])
        """
        x, upper = cosine_abscissae(count)
        span = self.spline([0.0, self.length])[:, 0].max() - self.nose_x
        xy = self.at(self.nose_x + span * x, upper)
        xy[count // 2] = self.spline(self.nose)
        return np.column_stack([xy, np.zeros(count)])


def cosine_abscissae(count: int) -> tuple[Array, Mask]:
    """Abscissae 1 ... 0 ... 1 of a contour of `count` points, and which are on the upper side."""
    if count < 5 or count % 2 == 0:
        raise InputError(
            f"a contour is sampled at an odd number of points, at least 5, got {count}"
        )
    half = count // 2
    x = 0.5 * (1 - np.cos(np.pi * np.arange(half + 1) / half))
    return np.concatenate([x[::-1], x[1:]]), np.arange(count) <= half


def upper_side(points: Array) -> Mask:
    """Which points of a contour in Selig order come before or at its least x."""
    return np.arange(len(points)) <= int(np.argmin(points[:, 0]))


def _checked(points: ArrayLike) -> Array:
    xy = np.asarray(points, dtype=np.float64)
    if xy.ndim != 2 or xy.shape[1] not in (2, 3):
        raise InputError(f"a contour needs an array (m, 2) or (m, 3) of points, got {xy.shape}")
    if not np.isfinite(xy).all():
        raise InputError("the points of a contour must be finite numbers")
    xy = xy[:, :2]
    distinct = np.concatenate([[True], np.linalg.norm(np.diff(xy, axis=0), axis=1) > 0])
    xy = xy[distinct]
    if len(xy) < 5:
        raise InputError(f"a contour needs at least 5 distinct points, got {len(xy)}")
    nose = int(np.argmin(xy[:, 0]))
    if nose in (0, len(xy) - 1):
        raise InputError("a contour must run from the trailing edge over the nose and back")
    result: Array = xy
    return result


def _least_x(spline: Any, s: Array, xy: Array) -> float:
    """Parameter of the least x: the root of x'(s) beside the foremost point."""
    foremost = int(np.argmin(xy[:, 0]))
    slope = spline.derivative()
    roots = np.asarray(slope.roots(extrapolate=False)[0], dtype=np.float64)
    near = roots[(roots >= s[foremost - 1]) & (roots <= s[foremost + 1])]
    return float(near[np.argmin(spline(near)[:, 0])]) if near.size else float(s[foremost])
