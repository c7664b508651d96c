"""Whether a net at rest is tangled, so that points have no place of their own in it.

1. A map that turns neither way inside out has one sign of its Jacobian determinant; both signs
   are the proof of a fold, whatever the bends, weights, collapsed edges or rings.
2. A control point that was pulled too far folds a small part, and the rest is of use. What is
   refused is a net that is folded for a reason: the map that its corners alone span folds as
   well (they are in the wrong order), or a good part of the volume is inside out.
3. A grid of some thousand places at most answers, in milliseconds, whatever the net.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.folds import determinants, knot_spans
from ffdstudio.engine.lattice import Lattice
from ffdstudio.errors import InputError

SHARE = 0.1  # of the volume inside out: more is no pulled control point
TINY = 1e-9  # of the largest determinant: the sign of less is rounding
GAUSS = 4  # places in a knot span of a direction
MOST = 12  # knot spans of a direction


def refuse_tangled(lattice: Lattice) -> None:
    """Raise `InputError` if a lattice at rest is folded as a whole.

    Examples
    --------
    >>> net = [[[0, 0, 0], [1, 1, 0]], [[1, 0, 0], [0, 1, 0]]]
    >>> refuse_tangled(Lattice([1, 1], [[0, 0, 1, 1]] * 2, net))
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: the lattice at rest is folded: 50 % of it is inside out; \
most likely its corners are in the wrong order: first along i, then around the face
    """
    lattice = lattice.clamped()
    share = inside_out(lattice)
    if share == 0 or (share < SHARE and inside_out(_corner_cage(lattice)) == 0):
        return
    raise InputError(
        f"the lattice at rest is folded: {100 * max(share, 0.01):.0f} % of it is inside out; "
        f"{_likely_cause(lattice.dimension)}"
    )


def _likely_cause(dimension: int) -> str:
    if dimension == 1:
        return "its control points run back and forth along its axis"
    cause = "most likely its corners are in the wrong order: first along i, then around the face"
    return cause + (", then likewise at the other end of k" if dimension == 3 else "")


def inside_out(lattice: Lattice) -> float:
    """Share of the volume (area, length) whose orientation is not the prevailing one.

    Examples
    --------
    >>> inside_out(Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 4, 4)))
    0.0
    """
    lattice = lattice.clamped()
    spans, nodes, sizes = zip(*(_places(knots) for knots in lattice.knots), strict=True)
    values = determinants(lattice, list(spans), list(nodes))
    values[np.abs(values) <= TINY * np.abs(values).max()] = 0.0
    volumes = values * _outer(sizes).reshape(values.shape)
    whole, signed = float(np.abs(volumes).sum()), float(volumes.sum())
    both = (values > 0).any() and (values < 0).any()
    return 0.5 * (whole - abs(signed)) / whole if both else 0.0


def _places(knots: Array) -> tuple[Array, Array, Array]:
    """Knot spans (of many only some, the ends among them), places in each, and their shares."""
    spans = knot_spans(knots)
    spans = spans[np.unique(np.linspace(0, len(spans) - 1, MOST).astype(int))]
    nodes, weights = np.polynomial.legendre.leggauss(2 if len(spans) > MOST // 2 else GAUSS)
    return spans, (nodes + 1) / 2, np.multiply.outer(np.diff(spans)[:, 0], weights)


def _outer(sizes: Sequence[Array]) -> Array:
    """(spans, places) products over the directions, in the order of `determinants`."""
    d = len(sizes)
    product = reduce(np.multiply.outer, sizes)
    return np.asarray(product.transpose([*range(0, 2 * d, 2), *range(1, 2 * d, 2)]))


def _corner_cage(lattice: Lattice) -> Lattice:
    """The lattice of degree 1 that the corners of a net span."""
    corners = lattice.control_points[np.ix_(*([0, -1] for _ in lattice.shape))]
    d = lattice.dimension
    return Lattice([1] * d, [[0, 0, 1, 1]] * d, corners, axes=lattice.axes)
