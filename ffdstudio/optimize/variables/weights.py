"""Weights as design variables, beside displacements.

1. A weight is w(y) = lower (upper / lower)^s(y) with s a logistic function, so it stays positive
   and within its bounds whatever a method tries; dw/dy = 1 at y = 0.
2. Points follow weights nonlinearly: the derivative by the variables depends on where they are.
3. Tangents of the displacements' directions alone do not nest under knot insertion, so a lattice
   whose weights are variables is not refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.optimize.variables.level import EmbeddedBody, Level
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import DesignSpace, Insertion


@dataclass(frozen=True, eq=False)
class Bounded:
    """Positive numbers between bounds as functions of free variables, elementwise.

    Examples
    --------
    >>> chart = Bounded.around(np.array([1.0, 2.0]), 0.5, 4.0)
    >>> chart.at(np.zeros(2))
    array([1., 2.])
    >>> chart.at(np.array([-1e3, 1e3]))
    array([0.5, 4. ])
    """

    start: Array
    origin: Array
    scale: Array
    range: float

    @classmethod
    def around(cls, start: Array, lower: float, upper: float) -> Self:
        """Chart with the value `start` and the slope 1 at 0."""
        span = float(np.log(upper / lower))
        share = np.log(start / lower) / span
        origin = np.log(share / (1 - share))
        return cls(start, origin, start * span * share * (1 - share), span)

    def at(self, y: Array) -> Array:
        """Values."""
        shift = _logistic(self.origin + y / self.scale) - _logistic(self.origin)
        return np.asarray(self.start * np.exp(self.range * shift))

    def slope(self, y: Array) -> Array:
        """Derivatives of the values."""
        s = _logistic(self.origin + y / self.scale)
        return self.at(y) * self.range * s * (1 - s) / self.scale


def _logistic(t: Array) -> Array:
    return np.asarray(0.5 + 0.5 * np.tanh(0.5 * t))


@dataclass(frozen=True, eq=False, kw_only=True)
class WeightedSpace(DesignSpace):
    """Variables are displacements first, then weights.

    Attributes
    ----------
    shares : scipy.sparse array
        (control points, k): which weights a variable changes; linked and mirrored ones change
        together.
    chart : Bounded
        Of the weights at `free`.
    free : numpy.ndarray
        Flat indices of the control points whose weights are variables.
    """

    shares: Any = field(repr=False)
    chart: Bounded = field(repr=False)
    free: NDArray[np.intp] = field(repr=False)

    @classmethod
    def of(cls, rest: Lattice, rules: Rules, current: Lattice | None = None) -> Self:
        """Design space of a lattice, see `DesignSpace.of`.

        Raises
        ------
        InputError
            If a weight at the start is not within the bounds.
        """
        plain = DesignSpace.of(rest, rules, current)
        movable = rules.movable(rest.shape) & ~plain.fixed
        free = np.flatnonzero(movable)
        start = plain.lattice.weights.ravel()[free]
        assert rules.weights is not None
        lower, upper = rules.weights
        if not ((start > lower) & (start < upper)).all():
            worst = start[np.argmax(np.maximum(lower - start, start - upper))]
            raise InputError(f"a weight is {worst:g}, not between its bounds {lower:g}, {upper:g}")
        chart = Bounded.around(start, lower, upper)
        return cls(
            plain.rest, plain.lattice, rules, plain.fixed, plain.basis,
            shares=_scalar(rules).basis(movable)[::3][free], chart=chart, free=free,
        )  # fmt: skip

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.basis.shape[1] + self.shares.shape[1])

    def at(self, y: ArrayLike) -> Lattice:
        """Lattice at variables y."""
        moves, changes = np.split(np.asarray(y, dtype=np.float64), [self.basis.shape[1]])
        weights = self.lattice.weights.copy()
        weights.ravel()[self.free] = self.chart.at(self.shares @ changes)
        return super().at(moves).moved(weights=weights)

    def slopes(self, y: Array) -> Any:
        """Sparse (control points that are free, k) derivatives of the weights by variables."""
        from scipy.sparse import diags_array

        changes = self.shares @ y[self.basis.shape[1] :]
        return diags_array(self.chart.slope(changes)) @ self.shares

    def refined(self, new: Insertion) -> tuple[Self, Any]:
        """Refused, see the module."""
        raise InputError("a lattice whose weights are variables is not refined")


def _scalar(rules: Rules) -> Rules:
    """The same rules for one number a control point: x, which a mirror normal to y keeps."""
    mirror = None if rules.mirror is None else (rules.mirror[0], (0.0, 1.0, 0.0))
    return replace(rules, directions=((1.0, 0.0, 0.0),), mirror=mirror)


class WeightedLevel(Level):
    """Level whose points follow the weights as well."""

    space: WeightedSpace

    @classmethod
    def first(cls, body: EmbeddedBody, space: DesignSpace) -> Self:
        """Level of a space whose lattice may already be deformed."""
        return cls(body, space, body.embedding.deform(space.lattice))

    def moving(self) -> NDArray[np.intp]:
        """Coordinates that displacements move, and those that the net extends in."""
        extent = np.ptp(self.space.lattice.control_points.reshape(-1, 3), axis=0)
        return np.union1d(super().moving(), np.flatnonzero(extent > 0))

    def tangent(self, y: Array) -> Array:
        """(n * coordinates, N) derivatives of the points by the variables at y."""
        current = self.space.at(y)
        by_weights = self.body.embedding.weight_jacobian(current)[:, self.coordinates]
        by_weights = by_weights.reshape(-1, current.weights.size)[:, self.space.free]
        moves = self.moved_by(self.space.basis, current)
        return np.hstack([moves, (self.space.slopes(y).T @ by_weights.T).T])

    def shapes_at(self, z: Array) -> Array:
        """(n * coordinates, size) derivatives of the points by z."""
        return self.tangent(self.white.matrix @ z) @ self.white.matrix

    def at(self, z: Array) -> Array:
        """(n, 3) points."""
        return self.body.embedding.deform(self.space.at(self.white.matrix @ z))

    def pull(self, gradient: Array, z: Array | None = None) -> Array:
        """Derivative by z from the (n, 3) derivative by the points, without a matrix."""
        y = self.white.matrix @ (np.zeros(self.size) if z is None else z)
        current, embedding = self.space.at(y), self.body.embedding
        moves = embedding.jacobian_pullback(current, gradient).ravel() @ self.space.basis
        by_weights = embedding.weight_pullback(current, gradient).ravel()[self.space.free]
        return np.concatenate([moves, by_weights @ self.space.slopes(y)]) @ self.white.matrix


def first_level(
    body: EmbeddedBody, rules: Rules, current: Lattice | None, knots: Sequence[Insertion]
) -> Level:
    """Level that a study begins with, some knots being inserted."""
    kinds = (DesignSpace, Level) if rules.weights is None else (WeightedSpace, WeightedLevel)
    space = kinds[0].of(body.embedding.lattice, rules, current)
    for new in knots:
        space = space.refined(new)[0]
    return kinds[1].first(body, space)
