"""The command that takes over an iterate of a study."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
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


def in_space_of(lattice: Lattice, finer: Lattice) -> Lattice:
    """Return a lattice with knots inserted until it is in the space of a finer one.

    Raises
    ------
    InputError
        If that one is no refinement of it.
    """
    refined = with_knots_of(lattice, finer)
    if not refined.same_space(finer):
        raise InputError("the iterate belongs to a lattice of other knots or degrees")
    return refined


def with_knots_of(lattice: Lattice, other: Lattice) -> Lattice:
    """Return a lattice with those knots of another one inserted that it does not have.

    Lattices of other degrees or ranges have no knots in common; nothing is inserted then.
    """
    if lattice.degrees != other.degrees or not np.array_equal(lattice.domain, other.domain):
        return lattice
    for axis in range(lattice.dimension):
        missing = _missing(lattice.knots[axis], other.knots[axis])
        lattice = lattice.insert_knots(axis, missing) if len(missing) else lattice
    return lattice


def _missing(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    values, counts = np.unique(fine, return_counts=True)
    have = np.array([(coarse == value).sum() for value in values])
    return np.repeat(values, np.maximum(counts - have, 0))
