"""A motion of the lattice as polynomials in local coordinates, one set for each cell.

1. In a knot span a spline is a polynomial. In the centred coordinate t of the span, -1 at its
   left and 1 at its right end, the coefficients stay small: the error is below 1e-13 of the
   net up to degree 10, where t in [0, 1] loses three digits at degree 5.
2. The displacement R' - R = (dN - R dW) / (W + dW) is built from differences of the
   control points, so nothing cancels, and where nothing changes it is exactly zero. dN and N
   are measured from a control point of the cell.
3. A cell whose weights are all alike is polynomial, whatever its weights; a cell whose
   weights stay as they are needs one denominator and no N.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import AnyArray, Array
from ffdstudio.engine.direction import Direction
from ffdstudio.engine.lattice import Lattice

PLAIN, FIXED, CHANGED = 3, 4, 8  # kinds of cell: the number of polynomials each needs


class Motion(NamedTuple):
    """A change of control points and weights at a state of a lattice.

    The displacement of a point is ``(dN - R dW) / (W + step * dW)``; a step of 1 gives the
    difference of two states, 0 the derivative.
    """

    points: Array  # (control points, 3) of the state
    weights: Array  # (control points,) of the state
    d_points: Array
    d_weights: Array
    step: float = 1.0

    @classmethod
    def between(cls, rest: Lattice, current: Lattice) -> Motion:
        """From a lattice at rest to its current state."""
        old, new = rest.control_points.reshape(-1, 3), current.control_points.reshape(-1, 3)
        w = rest.weights.ravel()
        return cls(old, w, new - old, current.weights.ravel() - w)

    @property
    def changed(self) -> NDArray[np.bool_]:
        """(control points,) which of them change."""
        result: NDArray[np.bool_] = (self.d_points != 0).any(axis=1) | (self.d_weights != 0)
        return result


class Places(NamedTuple):
    """What the functions of one direction are at each place (see `spans`)."""

    control: NDArray[np.intp]  # (places, p + 1) control points whose functions live there
    matrix: Array  # (places, p + 1, p + 1): coefficient of t^row by function
    ends: Array  # (places, 2) parameters of the ends

    @classmethod
    def of(cls, direction: Direction) -> Places:
        """Functions of a direction; constant polynomials where the place is a knot."""
        degree, line = direction.degree, direction.breaks
        low = np.repeat(line, 2)[:-1]
        high = np.repeat(line, 2)[1:]
        middle = np.where(low == high, low, 0.5 * low + 0.5 * high)
        matrix = np.empty((len(low), degree + 1, degree + 1))
        for m in range(degree + 1):
            index, values = direction.functions(middle, m)
            matrix[:, m] = values * ((0.5 * (high - low)) ** m / factorial(m))[:, None]
        return cls(index, matrix, np.stack([low, high], axis=1))


class PolynomialCells(NamedTuple):
    """The cells that hold points, each with its control points and functions.

    Cells run along the last axis, so that NumPy's loops are long.
    """

    ends: Array  # (d, 2, cells) parameters
    control: NDArray[np.intp]  # (terms, cells) flat control point numbers
    alive: NDArray[np.bool_]  # (terms, cells) whether the function is not identically zero
    matrices: list[Array]  # d times (p + 1, p + 1, cells)

    @classmethod
    def of(cls, lattice: Lattice, places: NDArray[np.intp]) -> PolynomialCells:
        """Cells at (cells, d) places."""
        control = np.zeros((1, len(places)), dtype=np.intp)
        alive = np.ones((1, len(places)), dtype=bool)
        matrices, ends = [], []
        for k, direction in enumerate(lattice.directions):
            line = Places.of(direction)
            matrix = line.matrix[places[:, k]]
            one = line.control[places[:, k]].T
            control = _outer(control * lattice.shape[k], one, np.add)
            alive = _outer(alive, (matrix != 0).any(axis=1).T, np.logical_and)
            matrices.append(matrix.transpose(1, 2, 0).copy())
            ends.append(line.ends[places[:, k]].T)
        return cls(np.array(ends), control, alive, matrices)

    def part(self, numbers: NDArray[np.intp]) -> PolynomialCells:
        """Pick some of the cells."""
        return PolynomialCells(
            self.ends[..., numbers],
            self.control[:, numbers],
            self.alive[:, numbers],
            [matrix[..., numbers] for matrix in self.matrices],
        )

    def touched(self, chosen: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Numbers of the cells in which a chosen control point has any influence."""
        return np.flatnonzero((chosen[self.control] & self.alive).any(axis=0))

    def local(self, points: Array) -> Array:
        """(3, terms, cells) control points seen from the first one that counts in the cell."""
        net = points.T[:, self.control]
        origin = self.alive.argmax(axis=0)
        return net - net[:, origin, np.arange(len(origin))][:, None]

    def polynomials(self, values: Array) -> Array:
        """(cells, fields, p + 1, ...) coefficients from (fields, terms, cells) control values."""
        shape = [len(matrix) for matrix in self.matrices]
        table = values.reshape(len(values), *shape, -1)
        for k, matrix in enumerate(self.matrices):
            table = _transform(table, matrix, k + 1)
        return np.ascontiguousarray(np.moveaxis(table, -1, 0))

    def to_control(self, moments: Array) -> Array:
        """(fields, terms, cells) from (cells, fields, p + 1, ...): `polynomials` transposed."""
        table = np.moveaxis(moments, 0, -1)
        for k, matrix in enumerate(self.matrices):
            table = _transform(table, matrix.transpose(1, 0, 2), k + 1)
        return table.reshape(len(table), -1, table.shape[-1])


class CoefficientTable(NamedTuple):
    """Polynomials of a motion for some cells, as the kernels read them."""

    ends: Array  # (cells, d, 2) parameters at the ends of each cell
    kinds: NDArray[np.int64]  # (cells,) PLAIN, FIXED or CHANGED
    mask: NDArray[np.int64]  # (cells,) bit k set where coordinate k moves
    coefficients: Array  # (cells, fields, p + 1, q + 1, r + 1): dN, W, N, dW

    @classmethod
    def of(cls, cells: PolynomialCells, motion: Motion) -> CoefficientTable:
        """Table of all the cells."""
        kinds = _kinds(cells, motion)
        values = _control_values(cells, motion, kinds)
        moving = (values[:3] != 0) & cells.alive
        if len(values) == CHANGED:
            moving |= (values[4:7] != 0) & cells.alive & (kinds == CHANGED)
        mask = np.array([1, 2, 4]) @ moving.any(axis=1)
        ends = np.ascontiguousarray(cells.ends.transpose(2, 0, 1))
        return cls(ends, kinds, mask, cells.polynomials(values))


def _kinds(cells: PolynomialCells, motion: Motion) -> NDArray[np.int64]:
    old = motion.weights[cells.control]
    new = old + motion.d_weights[cells.control]
    changed = ((old != new) & cells.alive).any(axis=0)
    alike = _alike(old, cells.alive)
    alike &= _alike(new, cells.alive) if motion.step == 1 else ~changed
    return np.where(alike, PLAIN, np.where(changed, CHANGED, FIXED))


def _alike(values: Array, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
    low = np.where(alive, values, np.inf).min(axis=0)
    result: NDArray[np.bool_] = low == np.where(alive, values, -np.inf).max(axis=0)
    return result


def _control_values(cells: PolynomialCells, motion: Motion, kinds: NDArray[np.int64]) -> Array:
    """(fields, terms, cells) what the polynomials interpolate: dN, W, N, dW."""
    move = motion.d_points.T[:, cells.control]
    fields = int(kinds.max(initial=PLAIN))
    if fields == PLAIN:
        return move
    values = np.empty((fields, *cells.control.shape))
    w, dw = motion.weights[cells.control], motion.d_weights[cells.control]
    values[:3] = (w + motion.step * dw) * move
    values[3] = w
    if fields == CHANGED:
        local = cells.local(motion.points)
        values[:3] += dw * local
        values[4:7] = w * local
        values[7] = dw
    plain = kinds == PLAIN
    values[:3, :, plain] = move[:, :, plain]
    return values


def _transform(table: Array, matrices: Array, axis: int) -> Array:
    """Multiply the matrix of each cell with the table of the cell along `axis`.

    Summed term by term: a matrix product of the library may round otherwise when other cells
    stand beside, and two bodies that share a node would come apart.
    """
    moved = np.moveaxis(table, axis, 0)
    wide = matrices.reshape(*matrices.shape[:2], *(1,) * (table.ndim - 2), -1)
    out = wide[:, 0] * moved[0]
    for i in range(1, len(moved)):
        out += wide[:, i] * moved[i]
    return np.moveaxis(out, 0, axis)


def _outer(left: AnyArray, right: AnyArray, combine: np.ufunc) -> AnyArray:
    """Combine all pairs of rows, the right one running fastest."""
    result: AnyArray = combine(left[:, None], right[None]).reshape(
        len(left) * len(right), left.shape[-1]
    )
    return result


def padded(degrees: Sequence[int]) -> tuple[int, int, int]:
    """Three degrees; a missing direction has degree 0."""
    p, q, r = (*degrees, 0, 0)[:3]
    return p, q, r
