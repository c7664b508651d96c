"""Constraints on the shape, with exact derivatives by the points.

A constraint is a function of the points with a lower and an upper limit; equal limits make it
an equation. Values are scaled by the caller's units: chord 1 for airfoils.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError


class Relation(StrEnum):
    """Whether a constraint is an equation or an inequality, in SciPy's words."""

    EQUAL = "eq"
    LEAST = "ineq"


class Values(NamedTuple):
    """(k,) values and (k, 3 n) derivatives by the coordinates; None if nobody asked for them."""

    values: Array
    derivatives: Any


class Quantity(ABC):
    """Something measured on a shape.

    Attributes
    ----------
    angles : tuple of float
        Angles of attack, in degrees, of the flows that it needs: its derivatives cost an adjoint
        solve each and are had apart.
    """

    angles: tuple[float, ...] = ()

    @abstractmethod
    def __call__(self, points: Array) -> Values:
        """Values and derivatives at (n, 3) points."""

    def values(self, points: Array) -> Array:
        """(k,) values alone."""
        return self(points).values


def measured(quantity: Quantity, points: Array, derivatives: bool = True) -> Values:
    """Values, without derivatives if those cost something and are not wanted."""
    if not derivatives and quantity.angles:
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
    def kind(self) -> Relation:
        """Whether it is an equation or an inequality."""
        equal = self.lower is not None and self.lower == self.upper
        return Relation.EQUAL if equal else Relation.LEAST

    def slack(self, points: Array, derivatives: bool = True) -> Values:
        """Values that have to be 0 (an equation) or at least 0 (an inequality)."""
        values, rows = measured(self.quantity, points, derivatives)
        rows = rows.toarray() if hasattr(rows, "toarray") else rows
        signs = [(1.0, self.lower), (-1.0, None if self.kind is Relation.EQUAL else self.upper)]
        parts = [(sign, limit) for sign, limit in signs if limit is not None]
        slack = np.concatenate([sign * (values - limit) for sign, limit in parts])
        if rows is None:
            return Values(slack, None)
        return Values(slack, np.vstack([sign * np.asarray(rows) for sign, _ in parts]))

    def missed(self, slack: Array) -> float:
        """Largest distance by which the constraint is missed, from its slack."""
        return float(np.abs(slack).max() if self.kind is Relation.EQUAL else max(0.0, -slack.min()))

    def violation(self, points: Array) -> float:
        """Largest distance by which the constraint is missed."""
        return self.missed(self.slack(points, derivatives=False).values)
