"""Volume of a body in 3D."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.limits import ConstraintSpec


class Volume(Quantity):
    """Volume inside a triangulated closed surface (divergence theorem).

    A surface that is open at a symmetry plane through the origin counts as closed there.
    """

    def __init__(self, triangles: NDArray[np.int64]) -> None:
        self.triangles = triangles

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        a, b, c = (points[self.triangles[:, k]] for k in range(3))
        rows = np.zeros_like(points)
        for k, across in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
            np.add.at(rows, self.triangles[:, k], across / 6)
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
        sign = 1.0 if volume >= 0 else -1.0
        return Values(np.array([sign * volume]), sign * rows.reshape(1, -1))


class VolumeLimit(ConstraintSpec, frozen=True, kw_only=True, tag="volume"):
    """Volume inside a closed surface; open at a symmetry plane through the origin counts."""

    title = "Volume"
    needs = "surface"

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        assert shape.triangles is not None
        return Volume(shape.triangles)
