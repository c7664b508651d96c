"""What an inversion finds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices


class Inversion(NamedTuple):
    """Result for n points; a point outside has NaN parameters and an infinite residual."""

    parameters: Array  # (n, d)
    inside: NDArray[np.bool_]  # (n,)
    residual: Array  # (n,) |R(u) - x| along the lattice's axes
    iterations: NDArray[np.int16]  # (n,) evaluations of R; 0 in closed form

    @classmethod
    def unfilled(cls, count: int, dimension: int) -> Inversion:
        """Room for what a search fills for each point."""
        return cls(
            np.empty((count, dimension)), np.empty(count, bool), np.empty(count),
            np.zeros(count, np.int16),
        )  # fmt: skip

    @classmethod
    def empty(cls, count: int, dimension: int) -> Inversion:
        """All points outside."""
        return cls(
            np.full((count, dimension), np.nan),
            np.zeros(count, dtype=bool),
            np.full(count, np.inf),
            np.zeros(count, dtype=np.int16),
        )

    def part(self, rows: slice) -> Inversion:
        """Views of some rows, to be filled."""
        return Inversion(
            self.parameters[rows], self.inside[rows], self.residual[rows], self.iterations[rows]
        )

    def put(self, rows: Indices, other: Inversion) -> None:
        """Write the rows of another one into some rows of this."""
        self.parameters[rows], self.inside[rows] = other.parameters, other.inside
        self.residual[rows], self.iterations[rows] = other.residual, other.iterations
