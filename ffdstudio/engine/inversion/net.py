"""What the inversion needs of a lattice: its net along its own axes.

A lattice of fewer directions than space is inverted along its axes alone; the other
coordinates of a point do not matter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ffdstudio.aliases import Array

ON_FACE = 1e-9  # of the diagonal: a point this little outside a face counts as on it
ROUNDED = 4 * np.finfo(float).eps  # of the largest coordinate: and one that rounding puts there

if TYPE_CHECKING:
    from ffdstudio.engine.lattice import Lattice


class Net(NamedTuple):
    """Control points in coordinates along the axes, (..., d), with what belongs to them."""

    degrees: tuple[int, ...]
    knots: tuple[Array, ...]
    points: Array
    weights: Array
    axes: Array
    abscissae: list[Array]
    diagonal: float

    @classmethod
    def of(cls, lattice: Lattice) -> Net:
        """Net of a lattice."""
        return cls(
            lattice.degrees,
            lattice.knots,
            along_axes(lattice.control_points, lattice.axes),
            lattice.weights,
            lattice.axes,
            [lattice.greville(k) for k in range(lattice.dimension)],
            lattice.diagonal,
        )

    @property
    def dimension(self) -> int:
        """Number of directions."""
        return len(self.degrees)

    @property
    def polynomial(self) -> bool:
        """Whether all weights are 1."""
        return bool((self.weights == 1).all())

    @property
    def slack(self) -> float:
        """How far outside a face a point may lie and still count as on it."""
        return max(ON_FACE * self.diagonal, ROUNDED * float(np.abs(self.points).max()))

    @property
    def domain(self) -> tuple[Array, Array]:
        """Lowest and highest parameters, (d,) each."""
        return np.array([u[0] for u in self.knots]), np.array([u[-1] for u in self.knots])

    def padded(self) -> Net:
        """Three directions: missing ones become straight, one diagonal long."""
        if self.dimension == 3:
            return self
        line = np.array([0.0, self.diagonal])
        ends = np.broadcast_to(line[:, None], (*self.points.shape[:-1], 2, 1))
        return Net(
            (*self.degrees, 1),
            (*self.knots, np.repeat(line, 2)),
            np.concatenate([np.repeat(self.points[..., None, :], 2, axis=-2), ends], axis=-1),
            np.repeat(self.weights[..., None], 2, axis=-1),
            self.axes,
            [*self.abscissae, line],
            self.diagonal,
        ).padded()


def along_axes(points: Array, axes: Array) -> Array:
    """Coordinates (..., d) of world points; an unrotated frame keeps their bits."""
    if np.array_equal(axes, np.eye(3)[: len(axes)]):
        return points[..., : len(axes)]
    return points @ axes.T
