"""Sections wherever they lie and however long they are, told in chords.

Everything aerodynamic is meant for x from 0 to 1 and y from the trailing edge's middle: the
coefficients of the panel method, the distance to a tabulated section, Kulfan's tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.optimize.constraints import Values, measured
from ffdstudio.optimize.objectives.base import Evaluation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chord:
    """Where a section lies: its coordinates in chords are ``(x - origin) / length``."""

    x: float
    y: float
    length: float

    @classmethod
    def of(cls, contour: Array) -> Chord:
        """Chord of (n, 2+) points in Selig's order.

        Examples
        --------
        >>> Chord.of(np.array([[3.0, 1.1], [1.0, 1.0], [3.0, 0.9]]))
        Chord(x=1.0, y=1.0, length=2.0)
        """
        low, high = contour[:, 0].min(), contour[[0, -1], 0].max()
        middle = 0.5 * (contour[0, 1] + contour[-1, 1])
        tiny = 1e-9 * (high - low)  # so that a unit chord stays exactly one
        x, y = (0.0 if abs(v) < tiny else float(v) for v in (low, middle))
        return cls(x, y, float(high - x))

    @property
    def unit(self) -> bool:
        """Whether nothing has to be changed."""
        return self == Chord(0.0, 0.0, 1.0)

    @property
    def origin(self) -> Array:
        """(3,) nose's abscissa and trailing edge's height."""
        return np.array([self.x, self.y, 0.0])

    def local(self, points: Array) -> Array:
        """(n, 3) points in chords."""
        return (points - self.origin) / self.length

    def world(self, points: Array) -> Array:
        """(n, 3) points in the units of the mesh, from chords."""
        return points * self.length + self.origin


@dataclass
class InChords:
    """An objective or a quantity that is told in chords, seen from the mesh's units."""

    inner: Any
    chord: Chord

    def __post_init__(self) -> None:
        self.differentiable: bool = getattr(self.inner, "differentiable", True)

    def evaluate(self, points: Array, gradient: bool = True) -> Evaluation:
        """See `Objective`."""
        found = self.inner.evaluate(self.chord.local(points), gradient)
        changed: dict[str, Any] = {
            name: value / self.chord.length
            for name in ("gradient", "sensitivity")
            if (value := getattr(found, name)) is not None
        }
        return replace(found, **changed)

    def __call__(self, points: Array) -> Values:
        """See `constraints.Quantity`."""
        values, rows = self.inner(self.chord.local(points))
        return Values(values, rows / self.chord.length)

    @property
    def angles(self) -> tuple[float, ...]:
        """Angles of attack of the flows that are solved; see `constraints.Aerodynamic`."""
        return tuple(getattr(self.inner, "angles", ()))

    def values(self, points: Array) -> Array:
        """Values of a quantity alone; see `constraints.Aerodynamic`."""
        return measured(self.inner, self.chord.local(points), derivatives=False).values


def plain(objective: Any) -> Any:
    """What an objective in chords is made of; any other as it is."""
    return objective.inner if isinstance(objective, InChords) else objective


@dataclass
class OnNodes:
    """A quantity of some of the points, seen from all of them: a section within its mesh."""

    inner: Any
    nodes: NDArray[np.int64]

    def __call__(self, points: Array) -> Values:
        """See `constraints.Quantity`."""
        values, rows = self.inner(points[self.nodes])
        part = rows.toarray() if hasattr(rows, "toarray") else np.asarray(rows)
        whole = np.zeros((len(values), len(points), 3))
        shares = part.reshape(len(values), -1, 3)
        for k, node in enumerate(self.nodes):  # the trailing edge comes first and last
            whole[:, node] += shares[:, k]
        return Values(values, whole.reshape(len(values), -1))

    @property
    def angles(self) -> tuple[float, ...]:
        """Angles of attack of the flows that are solved; see `constraints.Aerodynamic`."""
        return tuple(getattr(self.inner, "angles", ()))

    def values(self, points: Array) -> Array:
        """Values alone; see `constraints.Aerodynamic`."""
        return measured(self.inner, points[self.nodes], derivatives=False).values
