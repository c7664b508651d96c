"""Products with the derivatives of embedded points, without the matrices.

For a mesh of a million points the Jacobian has 64 million entries; an optimizer needs its
product with a step (forward) and that of its transpose with the sensitivities of an objective
(backward). Both go over the points once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio import threads
from ffdstudio.aliases import Array
from ffdstudio.engine.deformation import Deformer, check_space
from ffdstudio.engine.knots import numbers
from ffdstudio.engine.lattice import Lattice
from ffdstudio.engine.polynomials import Motion, PolynomialCells, padded
from ffdstudio.errors import InputError


def jacobian_product(deformer: Deformer, current: Lattice, d_points: ArrayLike) -> Array:
    """(n, 3) motion of the points per motion `d_points` of the control points."""
    check_space(deformer.lattice, current)
    step = _like(d_points, current.control_points, "the motion of the control points")
    nothing = np.zeros(current.weights.size)
    return deformer.displacement(_derivative(current, step.reshape(-1, 3), nothing))


def weight_product(deformer: Deformer, current: Lattice, d_weights: ArrayLike) -> Array:
    """(n, 3) motion of the points per change `d_weights` of the weights."""
    check_space(deformer.lattice, current)
    step = _like(d_weights, current.weights, "the change of the weights")
    nothing = np.zeros((step.size, 3))
    return deformer.displacement(_derivative(current, nothing, step.ravel()))


def jacobian_pullback(deformer: Deformer, current: Lattice, sensitivities: ArrayLike) -> Array:
    """Gradient by the control points, shaped like them, from (n, 3) sensitivities."""
    weighted = not (current.weights == 1).all()
    sums, _ = _pullback(deformer, current, sensitivities, weighted)
    gradient = sums[:, :3] * current.weights.reshape(-1, 1)
    return gradient.reshape(current.control_points.shape)


def weight_pullback(deformer: Deformer, current: Lattice, sensitivities: ArrayLike) -> Array:
    """Gradient by the weights, shaped like them, from (n, 3) sensitivities."""
    _, gradient = _pullback(deformer, current, sensitivities, rational=True)
    return gradient.reshape(current.weights.shape)


def influence(deformer: Deformer, current: Lattice, chosen: NDArray[np.bool_]) -> Array:
    """(n,) share of a common motion of the chosen control points that each point follows."""
    check_space(deformer.lattice, current)
    step = np.zeros((len(chosen), 3))
    step[:, 0] = chosen
    motion = _derivative(current, step, np.zeros(len(chosen)))
    return deformer.displacement(motion, coordinates=1)[:, 0]


def _derivative(current: Lattice, d_points: Array, d_weights: Array) -> Motion:
    points = current.control_points.reshape(-1, 3)
    return Motion(points, current.weights.ravel(), d_points, d_weights, step=0.0)


def _pullback(
    deformer: Deformer, current: Lattice, sensitivities: ArrayLike, rational: bool
) -> tuple[Array, Array]:
    """Sums over the points of B_i s / W, (control points, 3), and of B_i s . (P_i - R) / W.

    The second one is meaningful in the rational form only.
    """
    check_space(deformer.lattice, current)
    s = np.ascontiguousarray(_like(sensitivities, deformer.points, "the sensitivities"))
    points = current.control_points.reshape(-1, 3)
    sums, turns = np.zeros_like(points), np.zeros(len(points))
    for group in deformer.groups(np.ones(len(points), dtype=bool)):
        cells = deformer.cells.part(group)
        local = cells.local(points)
        moments = _moments(deformer, group, cells, current.weights, local, s, rational)
        fields = cells.to_control(moments)
        turn = (local * fields[:3]).sum(axis=0) - fields[3]
        for k in range(3):
            sums[:, k] += _by_control_point(cells, fields[k], len(points))
        turns += _by_control_point(cells, turn, len(points))
    return sums, turns


def _moments(
    deformer: Deformer,
    group: NDArray[np.intp],
    cells: PolynomialCells,
    weights: Array,
    local: Array,
    sensitivities: Array,
    rational: bool,
) -> Array:
    """(cells, 4, p + 1, ...) moments of s / W and s . R / W in local coordinates."""
    from ffdstudio.engine.moments import columns, moments  # numba is paid for by its users only

    order = deformer.order
    p, q, r = padded([len(matrix) - 1 for matrix in cells.matrices])
    count = (q + 1) * (r + 1)
    net = np.empty((0, 4, p + 1, count))
    if rational:
        w = weights.ravel()[cells.control]
        net = cells.polynomials(np.concatenate([w[None], w * local]))
        net = net.reshape(len(group), 4, p + 1, count)
    ends = np.ascontiguousarray(cells.ends.transpose(2, 0, 1))
    pieces, slots = order.pieces(group), order.slots(group)
    kernel = moments(p, q, r, rational)
    shape = (len(group), 4, p + 1, columns(q, r))
    sums: dict[int, Array] = {}

    def sum_pieces(part: tuple[int, int]) -> None:
        sums[part[0]] = own = np.zeros(shape)
        kernel(
            *part, pieces, order.starts, slots, order.order, order.u, ends, net, sensitivities,
            own,
        )  # fmt: skip

    threads.for_each(sum_pieces, deformer.parts(len(pieces)))
    total = np.zeros(shape)
    for first in sorted(sums):  # in one order: the same bits each time, on any number of cores
        total += sums[first]
    return total[..., :count].reshape(len(group), 4, *(len(m) for m in cells.matrices))


def _by_control_point(cells: PolynomialCells, values: Array, count: int) -> Array:
    sums = np.bincount(cells.control.ravel(), values.ravel(), count)
    return np.asarray(sums, dtype=np.float64)


def _like(values: ArrayLike, pattern: Array, name: str) -> Array:
    array = numbers(values, name)
    if array.shape != pattern.shape:
        raise InputError(f"{name} must have the shape {pattern.shape}, got {array.shape}")
    return array
