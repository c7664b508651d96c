"""Commands around saved shapes: states of a lattice kept by name."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.project.commands.base import Command, reset
from ffdstudio.project.model import LatticeItem, Model


@dataclass(frozen=True)
class SaveShape(Command):
    """Keep the present state of a lattice under a name; an older one is replaced."""

    verb: ClassVar[str] = "save shape"
    item: str
    name: str

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        if not self.name.strip():
            raise InputError("a name needs at least one letter")
        return model.with_(replace(item, shapes={**item.shapes, self.name: item.current}))

    def label(self, model: Model) -> str:
        return f"Save shape {self.name}"


@dataclass(frozen=True)
class RemoveShape(Command):
    """Forget a saved shape."""

    verb: ClassVar[str] = "remove shape"
    item: str
    name: str

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        _shape(item, self.name)
        shapes = {name: shape for name, shape in item.shapes.items() if name != self.name}
        return model.with_(replace(item, shapes=shapes))

    def label(self, model: Model) -> str:
        return f"Remove shape {self.name}"


@dataclass(frozen=True)
class BlendShapes(Command):
    """Rest plus the sum of saved shapes' displacements, each times a factor.

    Positions and weights both count as displacements from the rest; frozen layers stay.
    One shape with factor 1 restores it bit for bit.
    """

    verb: ClassVar[str] = "blend shapes"
    item: str
    factors: tuple[tuple[str, float], ...]

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        current = blended(item, self.factors)
        kept = reset(replace(item, current=current), item.frozen_mask)
        return model.with_(replace(item, current=kept))

    def label(self, model: Model) -> str:
        return "Shape " + " + ".join(f"{factor:g} {name}" for name, factor in self.factors)


def blended(item: LatticeItem, factors: tuple[tuple[str, float], ...]) -> Lattice:
    """Lattice of `BlendShapes`, before frozen layers are taken care of."""
    chosen = [(_shape(item, name), factor) for name, factor in factors if factor != 0]
    if len(chosen) == 1 and chosen[0][1] == 1:
        return chosen[0][0]
    points, weights = item.rest.control_points.copy(), item.rest.weights.copy()
    for shape, factor in chosen:
        points += factor * (shape.control_points - item.rest.control_points)
        weights += factor * (shape.weights - item.rest.weights)
    return item.rest.moved(points, weights)


def _shape(item: LatticeItem, name: str) -> Lattice:
    if name not in item.shapes:
        raise InputError(f"{item.name} has no saved shape {name}")
    return item.shapes[name]
