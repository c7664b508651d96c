"""Angle between the two surfaces of a section at its trailing edge.

A trailing edge that is too thin cannot be built. The angle is measured over the aft part of the
section, for between the last two points it would be that of a few millionths of the chord.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from msgspec import Meta

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.fields import says
from ffdstudio.optimize.spec.limits import ConstraintSpec

Reach = Annotated[float, Meta(gt=0, le=0.5)]


class _Slope(NamedTuple):
    """Slope of a surface over its aft part, and its derivatives by (x, y) of some nodes."""

    value: float
    nodes: list[int]
    rows: Array


class TrailingEdgeAngle(Quantity):
    """Angle in degrees between straight lines along the aft part of both surfaces.

    Parameters
    ----------
    reach : float
        Length of that part along x.

    Examples
    --------
    >>> wedge = np.array([[1.0, 0, 0], [0.5, 0.5, 0], [0, 0, 0], [0.5, -0.5, 0], [1, 0, 0]])
    >>> TrailingEdgeAngle(0.25)(wedge).values
    array([90.])
    """

    def __init__(self, reach: float = 0.05) -> None:
        self.reach = float(reach)

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        nose, last = int(np.argmin(points[:, 0])), len(points) - 1
        upper = self._slope(points, np.arange(nose, -1, -1))
        lower = self._slope(points, np.arange(nose, last + 1))
        angle, rows = 0.0, np.zeros((len(points), 3))
        for sign, slope in ((1.0, lower), (-1.0, upper)):  # the upper one falls aft, below rises
            angle += sign * np.arctan(slope.value)
            by_slope = sign / (1 + slope.value**2)
            for node, row in zip(slope.nodes, slope.rows, strict=True):
                rows[node, :2] += by_slope * row
        return Values(np.degrees(np.array([angle])), np.degrees(rows).reshape(1, -1))

    def _slope(self, points: Array, order: Indices) -> _Slope:
        """Slope from the point `reach` ahead of the end of a surface to the end."""
        x, y = points[order, 0], points[order, 1]
        place = x[-1] - self.reach
        if place <= x[0]:
            raise InputError(f"the section has no aft part of {self.reach:g} chords")
        k = int(np.clip(np.searchsorted(x, place) - 1, 0, len(x) - 2))
        width, rise = x[k + 1] - x[k], y[k + 1] - y[k]
        t, steep = (place - x[k]) / width, rise / width
        height = y[k] + t * rise
        # the place moves with the end of the surface, so the height does by the local slope
        rows = np.array([[steep * (1 - t), t - 1], [steep * t, -t], [-steep, 1.0]]) / self.reach
        nodes = [int(order[k]), int(order[k + 1]), int(order[-1])]
        return _Slope(float((y[-1] - height) / self.reach), nodes, rows)


class TrailingEdgeAngleLimit(ConstraintSpec, frozen=True, kw_only=True, tag="trailing-edge-angle"):
    """Angle between the two surfaces of a section at its trailing edge, in degrees."""

    title = "Trailing-edge angle"
    needs = "section"

    reach: Annotated[Reach, says("Over", "length of the aft part that is measured", "chords")] = (
        0.05
    )

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return TrailingEdgeAngle(self.reach)
