"""Commands that change a lattice: its points, weights, frozen layers, degrees and knots."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ffdstudio.engine.frozen import frozen_mask
from ffdstudio.project.commands.base import (
    Command,
    Numbers,
    Points,
    named,
    numbers,
    refined,
    reset,
    where,
)
from ffdstudio.project.model import Index, Model
from ffdstudio.project.plane_constraints import planes_in, slid

DIRECTIONS = "ijk"


@dataclass(frozen=True)
class MovePoints(Command):
    """Put control points to new positions, in world units; on a symmetry plane they slide."""

    verb: ClassVar[str] = "move points"
    item: str
    points: tuple[Index, ...]
    positions: Points

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        at = where(item, self.points)
        net = item.current.control_points.copy()
        wanted = numbers(self.positions, (len(self.points), 3), "positions")
        net[at] = slid(item.rest, at, wanted, planes_in(model))
        return model.with_(replace(item, current=item.current.moved(net)))

    def label(self, model: Model) -> str:
        return f"Move {named(self.points)}"


@dataclass(frozen=True)
class SetWeights(Command):
    """Give control points new weights."""

    verb: ClassVar[str] = "set weights"
    item: str
    points: tuple[Index, ...]
    weights: Numbers

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        at = where(item, self.points)
        weights = item.current.weights.copy()
        weights[at] = numbers(self.weights, (len(self.points),), "weights")
        return model.with_(replace(item, current=item.current.moved(weights=weights)))

    def label(self, model: Model) -> str:
        return f"Weight of {named(self.points)}"


@dataclass(frozen=True)
class ResetPoints(Command):
    """Put control points and weights back to rest; None means all of them."""

    verb: ClassVar[str] = "reset points"
    item: str
    points: tuple[Index, ...] | None = None

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        if self.points is None:
            return model.with_(replace(item, current=item.rest))
        mask = np.zeros(item.rest.shape, dtype=bool)
        mask[where(item, self.points, frozen_too=True)] = True
        return model.with_(replace(item, current=reset(item, mask)))

    def label(self, model: Model) -> str:
        what = model.lattice(self.item).name if self.points is None else named(self.points)
        return f"Reset {what}"


@dataclass(frozen=True)
class FreezeLayers(Command):
    """Freeze the outermost layers of points on every face that is not open; they go to rest."""

    verb: ClassVar[str] = "freeze layers"
    item: str
    layers: int

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        current = reset(item, frozen_mask(item.rest.shape, self.layers, item.open_faces))
        return model.with_(replace(item, frozen=self.layers, current=current))

    def lost(self, model: Model) -> int:
        """Count the control points that go back to rest."""
        item = model.lattice(self.item)
        moved = (item.current.control_points != item.rest.control_points).any(axis=-1)
        changed = moved | (item.current.weights != item.rest.weights)
        return int((changed & frozen_mask(item.rest.shape, self.layers, item.open_faces)).sum())

    def label(self, model: Model) -> str:
        lost, text = (
            self.lost(model),
            f"Freeze {self.layers} layer{'' if self.layers == 1 else 's'}",
        )
        return f"{text}, reset {lost} point{'' if lost == 1 else 's'}" if lost else text


@dataclass(frozen=True)
class InsertKnots(Command):
    """Insert knots in one direction; the deformed shape stays."""

    verb: ClassVar[str] = "insert knots"
    item: str
    axis: int
    knots: Numbers

    def apply(self, model: Model) -> Model:
        return refined(model, self.item, lambda net: net.insert_knots(self.axis, self.knots))

    def label(self, model: Model) -> str:
        knots = ", ".join(f"{knot:g}" for knot in self.knots)
        return f"Insert {knots} in {DIRECTIONS[self.axis]}"


@dataclass(frozen=True)
class ElevateDegree(Command):
    """Raise the degree of one direction; the deformed shape stays."""

    verb: ClassVar[str] = "elevate degree"
    item: str
    axis: int
    times: int = 1

    def apply(self, model: Model) -> Model:
        return refined(model, self.item, lambda net: net.elevate_degree(self.axis, self.times))

    def label(self, model: Model) -> str:
        degree = model.lattice(self.item).rest.degrees[self.axis] + self.times
        return f"Degree {degree} in {DIRECTIONS[self.axis]}"


@dataclass(frozen=True)
class RemoveKnots(Command):
    """Remove knots of one direction; the shape may move by up to `tolerance`."""

    verb: ClassVar[str] = "remove knots"
    item: str
    axis: int
    knots: Numbers
    tolerance: float = 0.0

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        rest = item.rest.remove_knots(self.axis, self.knots)
        current = rest
        if item.deformed:
            current = item.current.remove_knots(self.axis, self.knots, self.tolerance)
        frozen_mask(rest.shape, item.frozen, item.open_faces)
        # a saved shape is kept as well as it can be
        shapes = {
            name: shape.remove_knots(self.axis, self.knots, np.inf)
            for name, shape in item.shapes.items()
        }
        return model.with_(replace(item, rest=rest, current=current, shapes=shapes))

    def label(self, model: Model) -> str:
        knots = ", ".join(f"{knot:g}" for knot in self.knots)
        return f"Remove {knots} from {DIRECTIONS[self.axis]}"
