"""Evaluation of a lattice and of its derivatives at parametric points, in NumPy.

This is the reference for the kernels: plain sums over the control points that live at
each parameter, with the quotient rule for weights.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.knots import numbers
from ffdstudio.errors import InputError

if TYPE_CHECKING:
    from ffdstudio.engine.lattice import Lattice


def evaluate(lattice: Lattice, uvw: ArrayLike, derivative: Sequence[int] | None = None) -> Array:
    """See `Lattice.evaluate`."""
    order = tuple(derivative) if derivative is not None else (0,) * lattice.dimension
    if len(order) != lattice.dimension or min(order) < 0 or sum(order) > 2:
        raise InputError(
            f"a derivative needs {lattice.dimension} orders of at least 0 and a sum of at most 2, "
            f"got {order}"
        )
    u = checked_parameters(lattice, uvw)
    if lattice.frame is None or lattice.reference is None:
        return spline(lattice, u, order)
    out = lattice.frame.world(u, order)
    rest = lattice.reference
    if not (
        np.array_equal(lattice.control_points, rest.control_points)
        and np.array_equal(lattice.weights, rest.weights)
    ):
        out += spline(lattice, u, order) - spline(rest, u, order)
    return out


def spline(lattice: Lattice, u: Array, order: Sequence[int]) -> Array:
    """The spline of the control points alone, whatever frame it moves."""
    net = lattice.homogeneous
    if (lattice.weights == 1).all():
        return _combine(lattice, net[..., :3], u, order)
    return _rational(lattice, net, u, order)


def checked_parameters(lattice: Lattice, uvw: ArrayLike) -> Array:
    """(n, d) float64 parameters inside the domain, else `InputError`."""
    u = numbers(uvw, "parametric coordinates")
    if u.ndim != 2 or u.shape[1] != lattice.dimension:
        raise InputError(
            f"parametric coordinates must be an array (n, {lattice.dimension}), got {u.shape}"
        )
    low, high = lattice.domain.T
    if not ((u >= low) & (u <= high)).all():
        raise InputError(f"parametric coordinates must lie in {low} to {high}")
    return u


def support(
    lattice: Lattice, u: Array, order: Sequence[int]
) -> Iterator[tuple[NDArray[np.intp], Array]]:
    """Yield (flat index, basis product), each (n,), of every control point at each parameter."""
    parts = [
        direction.functions(u[:, k], order[k]) for k, direction in enumerate(lattice.directions)
    ]
    for offset in product(*(range(p + 1) for p in lattice.degrees)):
        index = np.zeros(len(u), dtype=np.intp)
        value = np.ones(len(u))
        for k, (numbers_of, values) in enumerate(parts):
            index = index * lattice.shape[k] + numbers_of[:, offset[k]]
            value = value * values[:, offset[k]]
        yield index, value


def _combine(lattice: Lattice, net: Array, u: Array, order: Sequence[int]) -> Array:
    flat = net.reshape(-1, net.shape[-1])
    total = np.zeros((len(u), flat.shape[1]))
    for index, value in support(lattice, u, order):
        total += value[:, None] * flat[index]
    return total


def _rational(lattice: Lattice, net: Array, u: Array, order: Sequence[int]) -> Array:
    """R = N / W and its derivatives: R_a = (N_a - W_a R) / W, and once more for the second."""

    def part(*orders: Sequence[int]) -> tuple[Array, Array]:
        both = _combine(lattice, net, u, np.sum(orders, axis=0, dtype=int))
        return both[:, :3], both[:, 3:]

    none = (0,) * lattice.dimension
    n, w = part(none)
    point = n / w
    steps = [
        np.eye(lattice.dimension, dtype=int)[k] for k in range(len(order)) for _ in range(order[k])
    ]
    if not steps:
        return point
    n_a, w_a = part(steps[0])
    first = (n_a - w_a * point) / w
    if len(steps) == 1:
        return first
    n_b, w_b = part(steps[1])
    second = (n_b - w_b * point) / w
    n_ab, w_ab = part(steps[0], steps[1])
    return (n_ab - w_a * second - w_b * first - w_ab * point) / w
