"""Quantities of a section seen from where it lies, and from the mesh around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values, measured
from ffdstudio.optimize.geometry.chord import Chord


class InChords(Quantity):
    """A quantity that is told in chords, seen from the mesh's units."""

    def __init__(self, inner: Quantity, chord: Chord) -> None:
        self.inner, self.chord, self.angles = inner, chord, inner.angles

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        values, rows = self.inner(self.chord.local(points))
        return Values(values, rows / self.chord.length)

    def values(self, points: Array) -> Array:
        """See `Quantity`."""
        return measured(self.inner, self.chord.local(points), derivatives=False).values


class OnNodes(Quantity):
    """A quantity of some of the points, seen from all of them: a section within its mesh."""

    def __init__(self, inner: Quantity, nodes: NDArray[np.int64]) -> None:
        self.inner, self.nodes, self.angles = inner, nodes, inner.angles

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        values, rows = self.inner(points[self.nodes])
        part = rows.toarray() if hasattr(rows, "toarray") else np.asarray(rows)
        whole = np.zeros((len(values), len(points), 3))
        shares = part.reshape(len(values), -1, 3)
        for k, node in enumerate(self.nodes):  # the trailing edge comes first and last
            whole[:, node] += shares[:, k]
        return Values(values, whole.reshape(len(values), -1))

    def values(self, points: Array) -> Array:
        """See `Quantity`."""
        return measured(self.inner, points[self.nodes], derivatives=False).values
