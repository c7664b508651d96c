"""Inversion of many points: closed form where there is one, else the search in cells."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.engine.inversion.affine import AffineMap
from ffdstudio.engine.inversion.net import Net, along_axes
from ffdstudio.engine.knots import Array
from ffdstudio.errors import InputError
from ffdstudio.threads import for_each

if TYPE_CHECKING:
    from ffdstudio.engine.lattice import Lattice

METHODS = ("newton", "secant", "octree", "golden")
ON_FACE = 1e-9  # of the diagonal: a point this little outside a face counts as on it
ROUNDING = 8e-15  # of the diagonal: no method can be asked for less than this
CHUNK = 8192


class Inversion(NamedTuple):
    """Result for n points; a point outside has NaN parameters and an infinite residual."""

    parameters: Array  # (n, d)
    inside: NDArray[np.bool_]  # (n,)
    residual: Array  # (n,) |R(u) - x| along the lattice's axes
    iterations: NDArray[np.int16]  # (n,) evaluations of R; 0 in closed form

    @classmethod
    def empty(cls, count: int, dimension: int) -> Inversion:
        """All points outside."""
        return cls(
            np.full((count, dimension), np.nan),
            np.zeros(count, dtype=bool),
            np.full(count, np.inf),
            np.zeros(count, dtype=np.int16),
        )


def invert(lattice: Lattice, points: Array, method: str, tolerance: float) -> Inversion:
    """Parametric coordinates of (n, 3) points; see `ffdstudio.embed`."""
    if method not in METHODS:
        raise InputError(f"method must be one of {', '.join(METHODS)}, got {method!r}")
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise InputError(f"the tolerance must be a positive number, got {tolerance}")
    net = Net.of(lattice)
    result = Inversion.empty(len(points), lattice.dimension)
    affine = AffineMap.of(net)
    if affine is not None:
        _invert_affine(affine, net, points, result)
    else:
        _search(net, points, METHODS.index(method), tolerance, result)
    return result


def _invert_affine(affine: AffineMap, net: Net, points: Array, result: Inversion) -> None:
    low, high = net.domain

    def chunk(part: slice) -> None:
        y = along_axes(points[part], net.axes)
        u, away, residual = affine.invert(y, low, high)
        inside = away <= ON_FACE * net.diagonal
        result.inside[part] = inside
        result.parameters[part][inside] = u[inside]
        result.residual[part][inside] = residual[inside]

    for_each(chunk, _chunks(len(points)))


def _search(net: Net, points: Array, method: int, tolerance: float, result: Inversion) -> None:
    from ffdstudio.engine.inversion import kernels
    from ffdstudio.engine.inversion.bins import sort_into_bins
    from ffdstudio.engine.inversion.cells import cut

    padded = net.padded()
    flat = padded.points.reshape(-1, 3)
    centre = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    padded = padded._replace(points=padded.points - centre)
    slack = ON_FACE * net.diagonal
    cells = cut(padded)
    bins = sort_into_bins(cells, slack)
    axes = np.zeros((3, 3))
    axes[: net.dimension] = net.axes
    centre[net.dimension :] = 0.0  # the padding lies around 0, and every point lies at 0 in it
    knots = tuple(np.array(u) for u in padded.knots)  # all writeable: one type for numba
    weights = padded.weights[..., None]
    homogeneous = np.concatenate([padded.points * weights, weights], axis=-1)
    frames = (
        cells.span, cells.middle, cells.half, cells.centre, cells.inverse, cells.low, cells.high,
        cells.bend,
    )  # fmt: skip

    def chunk(part: slice) -> None:
        kernels.invert_points(
            method, homogeneous, knots, padded.degrees, frames, bins, points[part],
            axes, centre, max(tolerance, ROUNDING) * net.diagonal, slack,
            *(array[part] for array in result),
        )  # fmt: skip

    for_each(chunk, _chunks(len(points)))


def _chunks(count: int) -> list[slice]:
    return [slice(first, min(first + CHUNK, count)) for first in range(0, count, CHUNK)]
