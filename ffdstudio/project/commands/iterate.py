"""The command that takes over an iterate of a study."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ffdstudio.engine import Lattice
from ffdstudio.engine.spaces import in_space_of
from ffdstudio.project.commands.base import Command
from ffdstudio.project.model import Model


@dataclass(frozen=True, eq=False)
class UseIterate(Command):
    """Give a lattice the knots, control points and weights that a study has found."""

    verb: ClassVar[str] = "use iterate"
    item: str
    current: Lattice
    note: str = ""

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        rest = in_space_of(item.rest, self.current)
        shapes = {name: in_space_of(shape, self.current) for name, shape in item.shapes.items()}
        coarser = item.coarser if rest is item.rest else item.rest
        new = replace(item, rest=rest, current=self.current, shapes=shapes, coarser=coarser)
        return model.with_(new)

    def label(self, model: Model) -> str:
        return f"Use {self.note}" if self.note else "Use iterate"
