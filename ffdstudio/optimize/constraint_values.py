"""Constraints as a level sees them: each is measured once at a shape, and its solves count.

1. A method asks for values, derivatives and violations of one shape in separate calls; the
   last shape is remembered.
2. Values are had without derivatives, which cost an adjoint solve each where there is a flow.
3. A flow that the cost has solved at the same shape and angle of attack is not solved again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.budget import Counts
from ffdstudio.optimize.constraints import Constraint, Relation, Values


class Slack:
    """Values [0] and derivatives [1] at a shape, each measured when it is asked for: see 2."""

    def __init__(self, *parts: Callable[[], Array]) -> None:
        self._parts = parts

    def __getitem__(self, part: int) -> Array:
        return self._parts[part]()


class Slacks:
    """Slacks of constraints, zero (equations) or not negative (inequalities) where they are met.

    Parameters
    ----------
    constraints : sequence of Constraint
    counts : Counts
        Where their solves are counted.
    """

    def __init__(self, constraints: Sequence[Constraint], counts: Counts) -> None:
        self.constraints, self.counts = constraints, counts
        self._points = np.empty((0, 3))
        self._values: dict[int, Array] = {}
        self._rows: dict[int, Array] = {}
        self._solved: set[float] = set()

    def share(self, points: Array, angles: Sequence[float]) -> None:
        """Hear of the flows that the cost has solved about a shape."""
        self._at(points)
        self._solved.update(angles)

    def values(self, points: Array, kind: Relation) -> Array:
        """(m,) slacks of a kind."""
        return np.concatenate([np.zeros(0), *self._each(points, kind, self._value)])

    def rows(self, points: Array, kind: Relation) -> Array:
        """(m, 3 n) their derivatives by the coordinates."""
        return np.vstack([np.zeros((0, points.size)), *self._each(points, kind, self._row)])

    def violations(self, points: Array) -> dict[str, float]:
        """By how much each constraint is missed, by its name."""
        self._at(points)
        return {
            constraint.name or f"constraint {k}": constraint.missed(self._value(k))
            for k, constraint in enumerate(self.constraints)
        }

    def _each(self, points: Array, kind: Relation, take: Callable[[int], Array]) -> list[Array]:
        self._at(points)
        return [take(k) for k, c in enumerate(self.constraints) if c.kind == kind]

    def _at(self, points: Array) -> None:
        if not np.array_equal(points, self._points):
            self._points = points.copy()
            self._values, self._rows, self._solved = {}, {}, set()

    def _value(self, k: int) -> Array:
        if k not in self._values:
            self._measure(k, derivatives=False)
        return self._values[k]

    def _row(self, k: int) -> Array:
        if k not in self._rows:
            self._measure(k, derivatives=True)
        return self._rows[k]

    def _measure(self, k: int, derivatives: bool) -> None:
        constraint = self.constraints[k]
        angles = set(constraint.quantity.angles)
        found: Values = constraint.slack(self._points, derivatives)
        self.counts.flow += bool(angles - self._solved)
        self.counts.adjoint += bool(angles) and derivatives
        self._solved |= angles
        self._values[k] = found.values
        if found.derivatives is not None:
            self._rows[k] = found.derivatives
