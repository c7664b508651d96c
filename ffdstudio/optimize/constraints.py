"""Constraints on the shape, with exact derivatives by the points.

A constraint is a function of the points with a lower and an upper limit; equal limits make it
an equation. Values are scaled by the caller's units: chord 1 for airfoils.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import flow_about

Array = NDArray[np.float64]


class Values(NamedTuple):
    """(k,) values and (k, 3 n) derivatives by the coordinates; None if nobody asked for them."""

    values: Array
    derivatives: Any


class Quantity(Protocol):
    """Something measured on a shape."""

    def __call__(self, points: Array) -> Values:
        """Values and derivatives at (n, 3) points."""
        ...


@runtime_checkable
class Aerodynamic(Protocol):
    """A quantity that needs a flow: derivatives cost an adjoint solve and are had apart."""

    @property
    def angles(self) -> tuple[float, ...]:
        """Angles of attack, in degrees; none if there is no flow after all."""
        ...

    def values(self, points: Array) -> Array:
        """(k,) values alone."""
        ...


def angles_of(quantity: Quantity) -> tuple[float, ...]:
    """Angles of attack of the flows that a quantity needs."""
    return quantity.angles if isinstance(quantity, Aerodynamic) else ()


def measured(quantity: Quantity, points: Array, derivatives: bool = True) -> Values:
    """Values, without derivatives if those cost something and are not wanted."""
    if not derivatives and isinstance(quantity, Aerodynamic):
        return Values(quantity.values(points), None)
    return quantity(points)


@dataclass(frozen=True)
class Constraint:
    """Lower <= quantity <= upper.

    Raises
    ------
    InputError
        If no limit is given or the lower one exceeds the upper one.
    """

    quantity: Quantity
    lower: float | None = None
    upper: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if self.lower is None and self.upper is None:
            raise InputError(f"the constraint {self.name or 'on the shape'} has no limit")
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise InputError(f"the lower limit of {self.name} exceeds the upper one")

    @property
    def kind(self) -> str:
        """Whether it is an equation ("eq") or an inequality ("ineq")."""
        return "eq" if self.lower is not None and self.lower == self.upper else "ineq"

    def slack(self, points: Array, derivatives: bool = True) -> Values:
        """Values that have to be 0 ("eq") or at least 0 ("ineq")."""
        values, rows = measured(self.quantity, points, derivatives)
        rows = rows.toarray() if hasattr(rows, "toarray") else rows
        signs = [(1.0, self.lower), (-1.0, None if self.kind == "eq" else self.upper)]
        parts = [(sign, limit) for sign, limit in signs if limit is not None]
        slack = np.concatenate([sign * (values - limit) for sign, limit in parts])
        if rows is None:
            return Values(slack, None)
        return Values(slack, np.vstack([sign * np.asarray(rows) for sign, _ in parts]))

    def missed(self, slack: Array) -> float:
        """Largest distance by which the constraint is missed, from its slack."""
        return float(np.abs(slack).max() if self.kind == "eq" else max(0.0, -slack.min()))

    def violation(self, points: Array) -> float:
        """Largest distance by which the constraint is missed."""
        return self.missed(self.slack(points, derivatives=False).values)


class Area:
    """Area inside a closed contour in the x-y plane (shoelace formula).

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> Area()(square).values
    array([1.])
    """

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        x, y = points[:, 0], points[:, 1]
        ahead, behind = np.roll(points, -1, axis=0), np.roll(points, 1, axis=0)
        area = 0.5 * float(x @ ahead[:, 1] - y @ ahead[:, 0])
        rows = np.zeros_like(points)
        rows[:, 0] = 0.5 * (ahead[:, 1] - behind[:, 1])
        rows[:, 1] = 0.5 * (behind[:, 0] - ahead[:, 0])
        sign = 1.0 if area >= 0 else -1.0
        return Values(np.array([sign * area]), sign * rows.reshape(1, -1))


class Volume:
    """Volume inside a triangulated closed surface (divergence theorem).

    A surface that is open at a symmetry plane through the origin counts as closed there.
    """

    def __init__(self, triangles: NDArray[np.int64]) -> None:
        self.triangles = triangles

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        a, b, c = (points[self.triangles[:, k]] for k in range(3))
        rows = np.zeros_like(points)
        for k, across in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
            np.add.at(rows, self.triangles[:, k], across / 6)
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
        sign = 1.0 if volume >= 0 else -1.0
        return Values(np.array([sign * volume]), sign * rows.reshape(1, -1))


class Thickness:
    """Vertical distance of the surfaces of a contour at given abscissae.

    The surfaces are taken as the polygon of the points: linear between two of them.
    """

    def __init__(self, abscissae: Any) -> None:
        self.abscissae = np.atleast_1d(np.asarray(abscissae, dtype=np.float64))

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        nose = int(np.argmin(points[:, 0]))
        self._check(points[nose, 0], points[[0, -1], 0].min())
        values = np.zeros(len(self.abscissae))
        rows = np.zeros((len(values), len(points), 3))
        surfaces = (np.arange(nose, -1, -1), 1.0), (np.arange(nose, len(points)), -1.0)
        for index, sign in surfaces:
            x, y = points[index, 0], points[index, 1]
            k = np.clip(np.searchsorted(x, self.abscissae) - 1, 0, len(x) - 2)
            width = x[k + 1] - x[k]
            t, slope = (self.abscissae - x[k]) / width, (y[k + 1] - y[k]) / width
            values += sign * (y[k] + t * (y[k + 1] - y[k]))
            at = np.arange(len(values))
            for node, share in ((index[k], 1 - t), (index[k + 1], t)):
                rows[at, node, 1] += sign * share
                rows[at, node, 0] -= sign * share * slope
        return Values(values, rows.reshape(len(values), -1))

    def _check(self, low: float, high: float) -> None:
        room = 0.01 * (high - low)  # nose and trailing edge may move a little
        outside = (self.abscissae < low - room) | (self.abscissae > high + room)
        if outside.any():
            raise InputError(
                f"there is no thickness at x = {self.abscissae[outside][0]:g}: the section "
                f"reaches from {low:g} to {high:g}"
            )


class MaxThickness:
    """Largest vertical thickness of a contour, over its own abscissae."""

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        x = points[:, 0]
        thickness = Thickness(np.unique(x)[1:-1])
        values = thickness(points).values
        return Thickness(thickness.abscissae[[int(np.argmax(values))]])(points)


class NoseRadius:
    """Radius of the circle through the foremost point and its two neighbours.

    Circumscribed circle of a triangle: abc / (4 area); derivatives by the chain rule.
    """

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        nose = int(np.clip(np.argmin(points[:, 0]), 1, len(points) - 2))
        corner = points[nose - 1 : nose + 2, :2]
        rows = np.zeros_like(points)
        radius, rows[nose - 1 : nose + 2, :2] = _circle(corner)
        return Values(np.array([radius]), rows.reshape(1, -1))


def _circle(p: Array) -> tuple[float, Array]:
    edges = np.roll(p, -1, axis=0) - p  # from corner k to corner k + 1
    lengths = np.linalg.norm(edges, axis=1)
    twice = float(edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0])
    radius = float(lengths.prod() / (2 * abs(twice)))
    by_log = np.zeros((3, 2))
    for k in range(3):
        pull = edges[k] / lengths[k] ** 2
        by_log[k] -= pull
        by_log[(k + 1) % 3] += pull
        ahead, behind = p[(k + 1) % 3], p[(k + 2) % 3]
        by_log[k] -= np.array([ahead[1] - behind[1], behind[0] - ahead[0]]) / twice
    return radius, radius * by_log


class Lift:
    """Lift coefficient of the panel method at one angle of attack (inviscid)."""

    def __init__(self, angle: float) -> None:
        self.angle = float(angle)

    @property
    def angles(self) -> tuple[float, ...]:
        """See `Aerodynamic`."""
        return (self.angle,)

    def values(self, points: Array) -> Array:
        """See `Aerodynamic`."""
        return flow_about(points, self.angles).lift()

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        xy = flow_about(points, self.angles).gradient(lift=np.ones(1))
        return Values(self.values(points), np.column_stack([xy, np.zeros(len(xy))]).reshape(1, -1))


class Moment(Lift):
    """Pitching moment about the quarter chord at one angle of attack (inviscid)."""

    def values(self, points: Array) -> Array:
        """See `Aerodynamic`."""
        return flow_about(points, self.angles).moment()

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        xy = flow_about(points, self.angles).gradient(moment=np.ones(1))
        return Values(self.values(points), np.column_stack([xy, np.zeros(len(xy))]).reshape(1, -1))


class Displacement:
    """How far each point has moved in a direction: bounds of the shape."""

    def __init__(self, start: Array, direction: Array) -> None:
        self.start, self.direction = np.array(start), np.asarray(direction, dtype=np.float64)

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        from scipy.sparse import identity, kron

        rows = kron(identity(len(points)), self.direction[None, :]).tocsr()
        return Values((points - self.start) @ self.direction, rows)
