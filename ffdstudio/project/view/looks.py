"""What the colour of a body may tell of its shape, point by point.

A look is a function of where the points were and are; the catalog names them. Both are for
every frame of a drag: no loops over points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.project.view.shading import Shading

LookName = Literal["shaded", "matte", "displacement", "curvature", "reflection"]
CURVED = 98.0  # percentile of |curvature| at the end of the scale: an edge is no measure


def displacement(rest: Array, now: Array, _shading: Shading | None) -> Array:
    """(m,) how far each point has moved.

    Examples
    --------
    >>> displacement(np.zeros((2, 3)), np.array([[0, 0, 0], [0, 3, 4.0]]), None)
    array([0., 5.])
    """
    return np.asarray(np.linalg.norm(now - rest, axis=1))


def curvature(_rest: Array, now: Array, shading: Shading | None) -> Array:
    """(m,) mean curvature of a surface, positive where it bulges towards its normals.

    Along an edge from a to b the normal turns by (n_b - n_a) . (b - a) / |b - a|^2; the mean of
    that over the edges of a point is the mean of the normal curvatures around it.
    """
    if shading is None:
        return np.zeros(len(now))
    normals = shading.normals(now)
    corners, sizes = shading.connectivity, np.diff(shading.offsets)
    ahead = np.arange(1, len(corners) + 1)
    ahead[shading.offsets[1:][sizes > 0] - 1] = shading.offsets[:-1][sizes > 0]
    a, b = corners, corners[ahead]
    places = now[shading.rows]
    step = places[b] - places[a]
    square = np.einsum("ij,ij->i", step, step)
    turn = np.einsum("ij,ij->i", normals[b] - normals[a], step)
    along = np.divide(turn, square, out=np.zeros_like(turn), where=square > 0)
    count = len(now)
    ends = np.concatenate([shading.rows[a], shading.rows[b]])
    total = np.bincount(ends, np.concatenate([along, along]), count)
    return np.asarray(total / np.maximum(np.bincount(ends, minlength=count), 1))


@dataclass(frozen=True)
class Look:
    """A look: its title, what it is of, and whether its scale has both signs."""

    title: str
    values: Callable[[Array, Array, Shading | None], Array] | None = None
    signed: bool = False
    percentile: float = 100.0

    def limit(self, values: Array) -> float:
        """End of the scale for these values: 1, 2 or 5 times a power of ten."""
        size = np.abs(values)
        return rounded_up(float(np.percentile(size, self.percentile)) if len(size) else 0.0)


LOOKS: dict[LookName, Look] = {
    "shaded": Look("Shaded"),
    "matte": Look("Matte"),
    "displacement": Look("Displacement", displacement),
    "curvature": Look("Mean curvature", curvature, True, CURVED),
    "reflection": Look("Reflection lines"),
}


def rounded_up(value: float) -> float:
    """1, 2 or 5 times a power of ten that is not less than a value; 0 of nothing.

    Examples
    --------
    >>> rounded_up(0.013), rounded_up(5.0), rounded_up(0.0)
    (0.02, 5.0, 0.0)
    """
    if not value > 0 or not np.isfinite(value):
        return 0.0
    power = 10.0 ** float(np.floor(np.log10(value)))
    ends = [float(f"{n * power:.12g}") for n in (1, 2, 5, 10)]
    return next(end for end in ends if end >= value * (1 - 1e-12))
