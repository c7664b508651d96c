"""Frames: curved coordinates that a lattice at rest follows, with their inverse in closed form.

1. The map of a lattice in a frame is ``frame(u) + R(u) - R_0(u)``, R_0 being the spline of the
   control points when the lattice was made: with these it is the frame itself, exactly, and
   a moved control point adds its function times its motion in world units, as everywhere.
2. Hence nothing but the place of a point at rest asks for the frame: deformation, derivatives,
   drags and refinement are those of the spline, and stay linear in the control points.
3. A box needs no frame (its spline is the identity), a net of any other shape has none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine.direction import Direction
from ffdstudio.engine.knots import numbers
from ffdstudio.errors import InputError

TURN = 2 * np.pi


class Frame(Protocol):
    """Coordinates in space by the parameters of a lattice, and back."""

    def world(self, u: Array, order: Sequence[int]) -> Array:
        """(n, 3) points at (n, d) parameters, or a derivative of them by the parameters."""

    def parameters(self, points: Array, domain: Array) -> Array:
        """(n, d) parameters of (n, 3) points, beyond the (d, 2) domain for points outside."""

    def parts(self) -> dict[str, Any]:
        """What the frame is made of, as plain numbers and texts, "kind" among them."""


@dataclass(frozen=True)
class Cylinder:
    """Radius, angle (radians) and distance along an axis; radius and angle alone in a plane.

    Attributes
    ----------
    origin, axis, start : tuple of float
        A point of the axis, its direction, and the direction of angle 0, unit vectors at right
        angles.
    order : tuple of int
        Which coordinate each parameter is: 0 the radius, 1 the angle, 2 the height.

    Examples
    --------
    >>> frame = Cylinder.of(axis=[0, 0, 1], start=[1, 0, 0])
    >>> frame.world(np.array([[2.0, np.pi / 2, 5.0]]), (0, 0, 0)).round(12).tolist()
    [[0.0, 2.0, 5.0]]
    """

    origin: tuple[float, float, float]
    axis: tuple[float, float, float]
    start: tuple[float, float, float]
    order: tuple[int, ...] = (0, 1, 2)

    @classmethod
    def of(
        cls,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        axis: ArrayLike = (0.0, 0.0, 1.0),
        start: ArrayLike | None = None,
    ) -> Cylinder:
        """Frame around an axis; angle 0 by default in the next coordinate plane.

        Raises
        ------
        InputError
            If the vectors are no directions, or `start` lies along the axis.
        """
        along = _direction(axis, "the axis of a cylinder")
        away = np.roll(np.eye(3), -1, axis=0)[np.argmax(np.abs(along))] if start is None else start
        across = _direction(away, "the direction of angle 0")
        across = across - (across @ along) * along
        if np.linalg.norm(across) < 1e-9:
            raise InputError("the direction of angle 0 must not lie along the axis of the cylinder")
        across /= np.linalg.norm(across)
        return cls(_triple(origin, "the origin of a cylinder"), _tuple(along), _tuple(across))

    @classmethod
    def of_parts(cls, parts: Mapping[str, Any]) -> Cylinder:
        """Read what `parts` has made; vectors that are at right angles keep their bits."""
        triples = [_triple(parts[key], f"the {key} of a cylinder") for key in _VECTORS]
        order = parts["order"]
        if not isinstance(order, list | tuple) or sorted(order) not in ([0, 1], [0, 1, 2]):
            raise InputError("the order of a cylinder's coordinates has 0, 1 and 2 once each")
        vectors = np.array(triples[1:])
        if not np.allclose(vectors @ vectors.T, np.eye(2), rtol=0, atol=1e-9):
            raise InputError("axis and start of a cylinder must be unit vectors at right angles")
        return cls(triples[0], triples[1], triples[2], tuple(order))

    def parts(self) -> dict[str, Any]:
        """Kind, the vectors and the order as lists."""
        return {"kind": "cylinder", **{key: list(getattr(self, key)) for key in _KEYS}}

    @property
    def axes(self) -> Array:
        """(3, 3) directions of angle 0, of a quarter turn, and along the axis."""
        along, across = np.array(self.axis), np.array(self.start)
        return np.stack([across, np.cross(along, across), along])

    def world(self, u: Array, order: Sequence[int]) -> Array:
        """See `Frame`: derivatives turn the angle on by a quarter each."""
        radius, angle, height = (
            u[:, self.order.index(k)] if k in self.order else np.zeros(len(u)) for k in range(3)
        )
        by_radius, by_angle, by_height = (
            order[self.order.index(k)] if k in self.order else 0 for k in range(3)
        )
        cosine, sine = _turned(angle, by_angle)
        if by_radius:
            radius = np.full(len(u), 1.0 if by_radius == 1 else 0.0)
        local = np.zeros((len(u), 3))
        if by_height == 0:
            local[:, 0], local[:, 1] = radius * cosine, radius * sine
        if 2 in self.order and by_radius == by_angle == 0 and by_height < 2:
            local[:, 2] = height if by_height == 0 else 1.0
        out = local @ self.axes
        return out if any(order) else np.asarray(out + np.array(self.origin))

    def parameters(self, points: Array, domain: Array) -> Array:
        """See `Frame`; the angle is the one in or nearest to the domain."""
        local = (points - np.array(self.origin)) @ self.axes.T
        radius = np.hypot(local[:, 0], local[:, 1])
        low, high = domain[self.order.index(1)]
        angle = np.arctan2(local[:, 1], local[:, 0])
        angle -= TURN * np.round((angle - 0.5 * (low + high)) / TURN)
        if high - low > TURN * (1 - 1e-12):  # the seam: its two ends are one place
            angle = np.where(angle >= high, angle - TURN, angle)
            angle = np.where(angle < low, np.where(low - angle < 1e-9, low, high), angle)
        coordinates = (radius, angle, local[:, 2])
        return np.stack([coordinates[k] for k in self.order], axis=1)


_VECTORS = ("origin", "axis", "start")
_KEYS = (*_VECTORS, "order")


def frame_of(parts: Mapping[str, Any]) -> Frame:
    """Frame from what `Frame.parts` has made.

    Raises
    ------
    InputError
        If there is no such frame or its numbers are wrong.
    """
    kind = parts.get("kind")
    if kind != "cylinder" or set(parts) != {"kind", *_KEYS}:
        raise InputError(f"there is no lattice in a frame of the kind {kind!r}")
    return Cylinder.of_parts(parts)


def cylinder_directions(
    radii: ArrayLike,
    angles: ArrayLike | None,
    heights: ArrayLike | None,
    shape: Sequence[int],
    degrees: Sequence[int] | None,
) -> list[Direction]:
    """Radius, angle and height as directions of a lattice; see `Lattice.cylinder`."""
    counts = list(shape)
    if len(counts) not in (2, 3) or (len(counts) == 3) != (heights is not None):
        raise InputError("a cylinder has radius and angle, and height where heights are given")
    given = [min(3, int(n) - 1) for n in counts] if degrees is None else list(degrees)
    if len(given) != len(counts):
        raise InputError(f"{len(counts)} directions need as many degrees, got {len(given)}")
    ranges = [_range(radii, "radii"), (0.0, TURN) if angles is None else _range(angles, "angles")]
    ranges += [] if heights is None else [_range(heights, "heights")]
    if ranges[0][0] < 0:
        raise InputError("the inner radius of a cylinder must not be negative")
    if ranges[1][1] - ranges[1][0] > TURN:
        raise InputError("the angles of a cylinder are in radians and at most one turn apart")
    return [
        Direction.uniform(n, p, *ends, periodic=k == 1 and angles is None)
        for k, (n, p, ends) in enumerate(zip(counts, given, ranges, strict=True))
    ]


def cylinder_net(frame: Cylinder, directions: Sequence[Direction]) -> Array:
    """Control points whose spline comes as near to the cylinder as splines do.

    Radius and height are reproduced, the circle is interpolated at the Greville abscissae: what
    turns or scales the whole net does the same to the shape within that error.
    """
    by_coordinate = [directions[frame.order.index(k)] for k in sorted(frame.order)]
    radial, around, *axial = by_coordinate
    low, high = around.domain
    places = around.greville()
    places = low + np.mod(places - low, high - low) if around.periodic else places
    circle = np.stack([np.cos(places), np.sin(places)], axis=-1)
    circle = np.linalg.solve(around.matrix(np.clip(places, low, high)), circle)
    heights = axial[0].greville() if axial else np.zeros(1)
    net = np.zeros((radial.count, around.count, len(heights), 3))
    net[..., :2] = (radial.greville()[:, None, None] * circle)[:, :, None]
    net[..., 2] = heights
    points: Array = net @ frame.axes + np.array(frame.origin)
    if not axial:
        points = points[:, :, 0]
    return np.ascontiguousarray(points.transpose(*frame.order, len(frame.order)))


def _range(ends: ArrayLike, what: str) -> tuple[float, float]:
    values = numbers(ends, what)
    if values.shape != (2,) or not np.isfinite(values).all() or not values[0] < values[1]:
        raise InputError(f"the {what} of a cylinder are two finite ascending numbers, got {ends!r}")
    return float(values[0]), float(values[1])


def _turned(angle: Array, times: int) -> tuple[Array, Array]:
    """Cosine and sine differentiated some times, without the rounding of adding quarter turns."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return [(cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine)][times % 4]


def _direction(vector: ArrayLike, what: str) -> Array:
    values = np.array(_triple(vector, what))
    length = float(np.linalg.norm(values))
    if not length > 0:
        raise InputError(f"{what} must not be zero")
    return values / length


def _triple(values: ArrayLike, what: str) -> tuple[float, float, float]:
    array = numbers(values, what)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InputError(f"{what} must be 3 finite numbers, got {values!r}")
    return _tuple(array)


def _tuple(vector: Array) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
