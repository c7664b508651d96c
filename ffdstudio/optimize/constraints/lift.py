"""Lift and moment of a section, by the panel method."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.flow.panel import flow_about
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.fields import Angle, says
from ffdstudio.optimize.spec.limits import ConstraintSpec

ATTACK = says("Angle", "of attack", "°")


class Lift(Quantity):
    """Lift coefficient of the panel method at one angle of attack (inviscid)."""

    def __init__(self, angle: float) -> None:
        self.angle = float(angle)
        self.angles = (self.angle,)

    def values(self, points: Array) -> Array:
        """See `Quantity`."""
        return flow_about(points, self.angles).lift()

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        xy = flow_about(points, self.angles).gradient(lift=np.ones(1))
        return Values(self.values(points), np.column_stack([xy, np.zeros(len(xy))]).reshape(1, -1))


class Moment(Lift):
    """Pitching moment about the quarter chord at one angle of attack (inviscid)."""

    def values(self, points: Array) -> Array:
        """See `Quantity`."""
        return flow_about(points, self.angles).moment()

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        xy = flow_about(points, self.angles).gradient(moment=np.ones(1))
        return Values(self.values(points), np.column_stack([xy, np.zeros(len(xy))]).reshape(1, -1))


class LiftLimit(ConstraintSpec, frozen=True, kw_only=True, tag="lift"):
    """Lift coefficient at an angle of attack, inviscid."""

    title = "Lift"
    needs = "section"

    angle: Annotated[Angle, ATTACK]

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return Lift(self.angle)


class MomentLimit(ConstraintSpec, frozen=True, kw_only=True, tag="moment"):
    """Pitching moment about the quarter chord at an angle of attack, inviscid."""

    title = "Moment"
    needs = "section"

    angle: Annotated[Angle, ATTACK]

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return Moment(self.angle)
