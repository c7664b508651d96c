"""Thickness of a section, at places and at its largest."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.fields import says
from ffdstudio.optimize.spec.limits import ConstraintSpec

Abscissa = Annotated[float, Meta(ge=0, le=1)]


class Thickness(Quantity):
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


class MaxThickness(Quantity):
    """Largest vertical thickness of a contour, over its own abscissae."""

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        x = points[:, 0]
        thickness = Thickness(np.unique(x)[1:-1])
        values = thickness(points).values
        return Thickness(thickness.abscissae[[int(np.argmax(values))]])(points)


class ThicknessLimit(ConstraintSpec, frozen=True, kw_only=True, tag="thickness"):
    """Vertical distance of the two surfaces of a section at given abscissae."""

    title = "Thickness"
    needs = "section"

    at: Annotated[
        Annotated[tuple[Abscissa, ...], Meta(min_length=1)],
        says("x / c", "abscissae from 0 to 1", "chords"),
    ]

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        thickness = Thickness(self.at)
        thickness(shape.local)  # refuses what the section does not reach
        return thickness


class MaxThicknessLimit(ConstraintSpec, frozen=True, kw_only=True, tag="max-thickness"):
    """Largest vertical thickness of a section."""

    title = "Largest thickness"
    needs = "section"

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return MaxThickness()
