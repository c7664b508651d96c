"""How far a lattice lets a skin move, estimated without looking at cells.

1. A control point moved by t along direction a displaces the mesh by t b(x), b being its basis
   function. The map stays one-to-one while t |db/da| < 1: the smooth limit, which cells that
   follow it reach at the same t or a little later.
2. At that limit the skin has moved by t times the largest b on it. Points whose influence on
   the skin is less than half of the largest are left out: nobody shapes with those.
3. Parameters of a box are coordinates (Greville abscissae), so b and db/da are products of
   basis functions of one direction.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array, Mask
from ffdstudio.engine import Lattice
from ffdstudio.engine.basis import basis

HALF = 0.5  # of the largest influence on the skin
SAMPLES, WORK = 600, 20_000_000  # points of the skin looked at, and products at most


def influence(lattice: Lattice, skin: Array) -> Array:
    """Largest value of each control point's basis function on a skin.

    Parameters
    ----------
    lattice : Lattice
        Undeformed, a box.
    skin : numpy.ndarray
        (n, 3) points; what lies outside the box counts nothing.

    Returns
    -------
    numpy.ndarray
        Of the lattice's shape, within [0, 1].

    Examples
    --------
    >>> influence(Lattice.box([0], [2], shape=(3,), degrees=(1,)), np.array([[0.5, 0, 0]]))
    array([0.5, 0.5, 0. ])
    """
    local = thinned(skin @ lattice.axes.T, int(np.prod(lattice.shape)))
    low, high = lattice.domain.T
    local = local[((local >= low) & (local <= high)).all(axis=1)]
    if not len(local):
        return np.zeros(lattice.shape)
    weights = [_dense(lattice, axis, local[:, axis]) for axis in range(lattice.dimension)]
    best = np.zeros(lattice.shape)
    for rows in np.array_split(np.arange(len(local)), 1 + len(local) * best.size // 4_000_000):
        product = np.ones((len(rows),))
        for axis, values in enumerate(weights):
            product = product[..., None] * values[rows].reshape(-1, *[1] * axis, values.shape[1])
        best = np.maximum(best, product.max(axis=0))
    return best


def reaches(lattice: Lattice, free: Mask, skin: Array) -> Array:
    """(d,) how far the skin can move in each direction of the lattice; the least of its points.

    Parameters
    ----------
    lattice : Lattice
        Undeformed, a box.
    free : numpy.ndarray
        Of the lattice's shape: which control points are not frozen.
    skin : numpy.ndarray
        (n, 3).

    Returns
    -------
    numpy.ndarray
        Zeros where no free point has any influence.

    Examples
    --------
    >>> box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
    >>> reaches(box, np.ones((4, 4), bool), np.array([[0.5, 0.5, 0.0]])).round(3)
    array([0.105, 0.105])
    """
    value = np.where(free, influence(lattice, skin), 0.0)
    chosen = leading(value)
    if not chosen.any():
        return np.zeros(lattice.dimension)
    peaks, slopes = zip(*(_peaks(lattice, axis) for axis in range(lattice.dimension)), strict=True)
    found = []
    for axis in range(lattice.dimension):
        steep = np.ones(())
        for other in range(lattice.dimension):
            steep = np.multiply.outer(steep, slopes[other] if other == axis else peaks[other])
        found.append(float((value[chosen] / steep[chosen]).min()))
    return np.array(found)


def leading(influence: Array) -> Mask:
    """Control points with at least half of the largest influence."""
    return np.asarray((influence > 0) & (influence >= HALF * influence.max(initial=0.0)))


def _peaks(lattice: Lattice, axis: int) -> tuple[Array, Array]:
    """Largest value and largest slope of the basis functions of a direction."""
    low, high = lattice.domain[axis]
    u = np.linspace(low, high, 16 * lattice.shape[axis] + 1)
    return (
        _dense(lattice, axis, u).max(axis=0),
        np.abs(_dense(lattice, axis, u, 1)).max(axis=0),
    )


def _dense(lattice: Lattice, axis: int, u: Array, derivative: int = 0) -> Array:
    """(n, count) values of all basis functions of a direction."""
    first, values = basis(lattice.knots[axis], lattice.degrees[axis], u, derivative)
    out = np.zeros((len(u), lattice.shape[axis]))
    columns: Sequence[int] = range(values.shape[1])
    for column in columns:
        out[np.arange(len(u)), first + column] = values[:, column]
    return out


def thinned(points: Array, size: int) -> Array:
    """Every so many of the points: as many as there is time for."""
    most = int(np.clip(WORK // max(size, 1), 50, SAMPLES))
    return points[:: 1 + (len(points) - 1) // most] if len(points) else points
