"""Candidate knots, their new basis functions on the surface, and the guards.

1. A guard is not a nicety: without surface points on both sides of a new knot within its span,
   without a least span or with too many variables for the points, fits blow up.
2. The function that a knot brings is one B-spline of the refined direction times all functions
   of the others; only its part outside the present space matters, so any new one will do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.evaluate import support
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.rows import free_lines
from ffdstudio.optimize.variables.space import DesignSpace, Insertion, new_function

POINTS_PER_VARIABLE = 2.0


@dataclass(frozen=True)
class Guards:
    """What a refinement must respect.

    Attributes
    ----------
    least_span : float
        Shortest knot span, as a fraction of the range.
    points_beside : int
        Surface points that a new knot needs on both sides within its span.
    least_share : float
        Share of the surface (of its arc length, or of the points of a fit) that a knot needs on
        both sides within its span: knots pile up at a thin trailing edge otherwise.
    points_per_variable : float
        Points for each variable; static lattices are held to it as well.
    """

    least_span: float = 1e-3
    points_beside: int = 2
    least_share: float = 2.5e-3
    points_per_variable: float = POINTS_PER_VARIABLE


@dataclass(frozen=True, eq=False)
class Candidate:
    """A knot and the functions, (n * coordinates, k), that it would bring.

    `span` numbers the knot span that it lies in.
    """

    insertion: Insertion
    functions: Array
    span: int

    @property
    def size(self) -> int:
        """Variables that it would bring."""
        return int(self.functions.shape[1])

    @property
    def place(self) -> tuple[int, int | None, int]:
        """Direction, line and span: a cycle inserts one knot in each."""
        return self.insertion.axis, self.insertion.line, self.span


def candidates(
    level: Level,
    axes: tuple[int, ...],
    positions: int,
    row_wise: bool,
    guards: Guards,
    only: tuple[int | None, ...] | None = None,
) -> list[Candidate]:
    """All candidates of the given directions that pass the guards, on request of some lines."""
    space, found = level.space, []
    room = int(level.on_surface.sum()) / guards.points_per_variable - space.size
    for axis in axes:
        if not space.rules.refinable(axis) or space.rest.periodic[axis]:
            continue
        blocks = _Blocks(level, axis)
        lines: list[int | None] = [None]
        if row_wise:
            lines = list(free_lines(space.rest, space.rules, axis))
        if only is not None:
            lines = [line for line in lines if line in only]
        for line in lines:
            own = own_knots(space, axis, line)
            covered = Covered.of(level, axis)
            for knot in positions_in(own, space.rest.knots[axis], covered, positions, guards):
                functions = blocks.of(own, knot, line)
                if functions.shape[1] <= room:
                    span = int(np.searchsorted(own, knot))
                    found.append(Candidate(Insertion(axis, knot, line), functions, span))
    return found


def blocks_of(level: Level, insertions: list[Insertion]) -> list[Candidate]:
    """Candidates of one direction, guards aside."""
    blocks, found = _Blocks(level, insertions[0].axis), []
    for new in insertions:
        own = own_knots(level.space, new.axis, new.line)
        functions = blocks.of(own, new.knot, new.line)
        found.append(Candidate(new, functions, int(np.searchsorted(own, new.knot))))
    return found


def beside(level: Level, new: Insertion, positions: int, guards: Guards) -> list[Candidate]:
    """Other places in the span of a knot that is not in the level's space."""
    own, covered = own_knots(level.space, new.axis, new.line), Covered.of(level, new.axis)
    k = int(np.searchsorted(own, new.knot))
    knots = positions_in(
        own[k - 1 : k + 1], level.space.rest.knots[new.axis], covered, positions, guards
    )  # fmt: skip
    return blocks_of(level, [replace(new, knot=knot) for knot in knots]) if knots else []


def own_knots(space: DesignSpace, axis: int, line: int | None) -> Array:
    """Knots that a new one would join: the line's own, or the lattice's."""
    if line is None or space.own is None:
        return space.rest.knots[axis]
    return space.own[line]


class Covered(NamedTuple):
    """Where points lie along a direction: different parameters, and the surface's share below.

    `share[i]` is the share of the surface below ``u[i]``.
    """

    u: Array
    share: Array

    @classmethod
    def of(cls, level: Level, axis: int) -> Self:
        """Of the surface's points of a level."""
        own = level.on_surface
        u, mass = level.parameters[own, axis], level.body.surface.mass[own]
        inside = np.isfinite(u)
        places, index = np.unique(u[inside], return_inverse=True)
        each = np.bincount(index, mass[inside])
        return cls(places, (np.cumsum(each) - each) / each.sum())

    def admits(self, low: float, knot: float, high: float, guards: Guards) -> bool:
        """Whether enough of the surface lies on both sides of a knot within its span."""
        ends = np.searchsorted(self.u, [low, knot, high], side="right")
        inner = np.searchsorted(self.u, [knot, high], side="left")
        count = min(inner[0] - ends[0], inner[1] - ends[1])
        below = np.interp([low, knot, high], self.u, self.share)
        return bool(count >= guards.points_beside and np.diff(below).min() >= guards.least_share)


def positions_in(
    own: Array, common: Array, covered: Covered, count: int, guards: Guards
) -> list[float]:
    """`count` places in each knot span, and knots that other lines have there already.

    A place hardly beside a knot that others have is that knot: lines share columns, and two
    knots that differ by rounding are none.
    """
    ends, found = np.unique(own), []
    least = guards.least_span * np.ptp(covered.u)
    for low, high in pairwise(ends):
        inner = common[(common > low) & (common < high)]
        even = low + (high - low) * np.arange(1, count + 1) / (count + 1)
        if inner.size:
            even = even[np.abs(even[:, None] - inner).min(axis=1) >= least]
        for knot in np.unique(np.concatenate([even, inner])):
            wide = min(knot - low, high - knot) >= least
            if wide and covered.admits(low, knot, high, guards):
                found.append(float(knot))
    return found


class _Blocks:
    """Functions of the other directions at the points, by line, direction and coordinate."""

    def __init__(self, level: Level, axis: int) -> None:
        self.level, self.axis = level, axis
        self.degree = level.space.rest.degrees[axis]
        self.layers = level.space.rules.layers(level.space.rest.dimension)[axis]
        inside = level.body.embedding.inside
        self.u = np.where(inside, level.parameters[:, axis], level.space.rest.knots[axis][0])
        self.inside = inside
        self.lines: dict[int | None, Array] = {}

    def _fields(self, line: int | None) -> Array:
        """(n, coordinates, k): what a unit function along the axis moves in the others."""
        space, axis = self.level.space, self.axis
        shape = list(space.rest.shape)
        mask = space.rules.movable(space.rest.shape).take([shape[axis] // 2], axis=axis)
        if line is not None:
            chosen = np.zeros(mask.size, dtype=bool)
            chosen[line] = True
            mask &= np.moveaxis(chosen.reshape(np.moveaxis(mask, axis, 0).shape), 0, axis)
        columns = space.rules.basis(mask)
        across = self._across()
        parts = [across @ columns[k::3].toarray() for k in self.level.coordinates]
        return np.stack(parts, axis=1)

    def _across(self) -> Array:
        """(n, lines) products of the functions of the other directions over the weight."""
        lattice, inside = self.level.space.lattice, self.inside
        numbers = np.moveaxis(np.arange(lattice.weights.size).reshape(lattice.shape), self.axis, 0)
        line_of = np.empty(lattice.weights.size, dtype=np.intp)
        line_of[numbers.reshape(len(numbers), -1)] = np.arange(numbers[0].size)
        rows, u = np.flatnonzero(inside), self.level.parameters[inside]
        out, weight = np.zeros((len(inside), numbers[0].size)), np.zeros(len(u))
        for index, value in support(lattice, u, (0,) * lattice.dimension):
            np.add.at(out, (rows, line_of[index]), value)  # those along the axis sum to 1
            weight += value * lattice.weights.ravel()[index]
        out[rows] /= weight[:, None]
        return out

    def of(self, own: Array, knot: float, line: int | None) -> Array:
        """Functions that a knot would bring to one line or all."""
        if line not in self.lines:
            self.lines[line] = self._fields(line)
        index = new_function(own, self.degree, knot, self.layers)
        finer = np.sort(np.append(own, knot))
        along = one_function(finer[index : index + self.degree + 2], self.u)
        along[~self.inside] = 0.0
        fields = along[:, None, None] * self.lines[line]
        return fields.reshape(-1, fields.shape[2])


def one_function(knots: Array, u: Array) -> Array:
    """Values of one B-spline by its own knots, zero outside (Cox and de Boor).

    Parameters
    ----------
    knots : numpy.ndarray
        (degree + 2,).
    u : numpy.ndarray
        (n,) parameters; the last knot counts as inside.

    Examples
    --------
    >>> one_function(np.array([0.0, 1.0, 2.0]), np.array([0.5, 1.0, 1.5, 2.5]))
    array([0.5, 1. , 0.5, 0. ])
    """
    count = len(knots) - 1
    last = max(j for j in range(count) if knots[j + 1] > knots[j])
    values = [((u >= knots[j]) & (u < knots[j + 1])).astype(np.float64) for j in range(count)]
    values[last][u == knots[-1]] = 1.0
    for degree in range(1, count):
        for j in range(count - degree):
            left, right = knots[j + degree] - knots[j], knots[j + degree + 1] - knots[j + 1]
            rising = (u - knots[j]) / left * values[j] if left else 0.0
            falling = (knots[j + degree + 1] - u) / right * values[j + 1] if right else 0.0
            values[j] = np.zeros(len(u)) + rising + falling
    result: Array = values[0]
    return result
