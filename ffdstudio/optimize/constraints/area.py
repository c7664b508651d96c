"""Area of a section."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.limits import ConstraintSpec


class Area(Quantity):
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


class AreaLimit(ConstraintSpec, frozen=True, kw_only=True, tag="area"):
    """Area inside a section, of a chord of 1."""

    title = "Area"
    needs = "section"

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return Area()
