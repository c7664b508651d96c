"""How far a shape may move."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.fields import Letter, says
from ffdstudio.optimize.spec.limits import ConstraintSpec
from ffdstudio.optimize.variables.rules import AXES


class Displacement(Quantity):
    """How far each point has moved in a direction: bounds of the shape."""

    def __init__(self, start: Array, direction: Array) -> None:
        self.start, self.direction = np.array(start), np.asarray(direction, dtype=np.float64)

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        from scipy.sparse import identity, kron

        rows = kron(identity(len(points)), self.direction[None, :]).tocsr()
        return Values((points - self.start) @ self.direction, rows)


class DisplacementLimit(ConstraintSpec, frozen=True, kw_only=True, tag="displacement"):
    """How far any point moves in a direction."""

    title = "Displacement"

    direction: Annotated[Letter, says("Direction", "that the points move in")]

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return Displacement(shape.local, np.array(AXES[self.direction]))
