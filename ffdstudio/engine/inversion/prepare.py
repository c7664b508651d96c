"""What a search needs of a net: made once a lattice, however many bodies are embedded.

1. Points and parameters are told from the net's centre and from the first knots: a lattice far
   from the origin loses no digits, neither in space nor in the parameters.
2. A lattice is an immutable value, so what was made for it is kept in it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.inversion.bins import Bins, sort_into_bins
from ffdstudio.engine.inversion.cells import Bent, cut
from ffdstudio.engine.inversion.cutting import BEND
from ffdstudio.engine.inversion.pieces import Pieces
from ffdstudio.engine.inversion.tangle import refuse_tangled
from ffdstudio.errors import InputError

if TYPE_CHECKING:
    from ffdstudio.engine.inversion.net import Net
    from ffdstudio.engine.lattice import Lattice

FLAT = 1e-9  # of the diagonal: a net without more extent than this has no inside


class Prepared(NamedTuple):
    """A net cut into cells that are sorted into bins; see `kernels.invert_points`."""

    spline: tuple[Array, tuple[Array, ...], tuple[int, ...]]  # homogeneous net, knots, degrees
    frames: tuple[NDArray[np.generic], ...]
    bins: Bins
    axes: Array  # (3, 3)
    centre: Array  # (3,)
    start: Array  # (d,) first knots
    slack: float
    regular: float  # bend up to which the map is one-to-one in a cell
    longest: int  # cells in the longest list of a bin
    bent: Bent  # what it takes to halve cells further
    pieces: Pieces | None  # None where points are searched for one by one


def prepared(lattice: Lattice, net: Net) -> Prepared:
    """Return what a search in a lattice needs.

    Raises
    ------
    InputError
        If the net has no extent in some direction of its axes, or is folded as a whole.
    """
    if "prepared" not in lattice.memo:
        _check_extent(net)
        refuse_tangled(lattice)
        lattice.memo["prepared"] = _prepare(net)
    made: Prepared = lattice.memo["prepared"]
    return made


def _prepare(net: Net) -> Prepared:
    padded = net.padded()
    flat = padded.points.reshape(-1, 3)
    centre = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    knots = tuple(u - u[0] for u in padded.knots)  # new arrays, writeable: one type for numba
    padded = padded._replace(points=padded.points - centre, knots=knots)
    cells, bent, pieces = cut(padded)
    bins = sort_into_bins(cells, net.slack)
    axes = np.zeros((3, 3))
    axes[: net.dimension] = net.axes
    centre[net.dimension :] = 0.0  # the padding lies around 0, and every point lies at 0 in it
    weights = padded.weights[..., None]
    homogeneous = np.concatenate([padded.points * weights, weights], axis=-1)
    frames = (
        cells.span, cells.middle, cells.half, cells.centre, cells.inverse, cells.low, cells.high,
        cells.bend,
    )  # fmt: skip
    return Prepared(
        (homogeneous, knots, padded.degrees), frames, bins, axes, centre,
        net.domain[0], net.slack, BEND, max(1, int(np.diff(bins.first).max())), bent, pieces,
    )  # fmt: skip


def _check_extent(net: Net) -> None:
    flat = net.points.reshape(-1, net.dimension)
    extent = np.linalg.svd(flat - flat.mean(axis=0), compute_uv=False)
    if len(extent) < net.dimension or not extent.min() > FLAT * net.diagonal:
        raise InputError(
            "the lattice is flat: its control points have no extent in one of the directions "
            "that its axes span, so no point lies inside"
        )
