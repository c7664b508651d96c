"""Candidate knots, their new basis functions on the surface, and the guards.

1. A guard is not a nicety: without surface points on both sides of a new knot within its span,
   without a least span or with too many variables for the points, fits blow up.
2. The function that a knot brings is one B-spline of the refined direction times all functions
   of the others; only its part outside the present space matters, so any new one will do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.basis import basis
from ffdstudio.engine.evaluate import support
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.rows import free_lines
from ffdstudio.optimize.variables.space import DesignSpace, Insertion, new_function


@dataclass(frozen=True)
class Guards:
    """What a refinement must respect.

    Attributes
    ----------
    least_span : float
        Shortest knot span, as a fraction of the range.
    points_beside : int
        Surface points that a new knot needs on both sides within its span.
    points_per_variable : float
        Fit points for each variable.
    """

    least_span: float = 1e-3
    points_beside: int = 2
    points_per_variable: float = 4.0


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
    level: Level, axes: tuple[int, ...], positions: int, row_wise: bool, guards: Guards
) -> list[Candidate]:
    """All candidates of the given directions that pass the guards."""
    space, found = level.space, []
    room = len(level.points) / guards.points_per_variable - space.size
    for axis in axes:
        if not space.rules.refinable(axis):
            continue
        blocks = _Blocks(level, axis)
        lines: list[int | None] = [None]
        if row_wise:
            lines = list(free_lines(space.rest, space.rules, axis))
        for line in lines:
            own = own_knots(space, axis, line)
            u = level.parameters[:, axis]
            for knot in positions_in(own, space.rest.knots[axis], u, positions, guards):
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
    own, u = own_knots(level.space, new.axis, new.line), level.parameters[:, new.axis]
    k = int(np.searchsorted(own, new.knot))
    knots = positions_in(own[k - 1 : k + 1], own[:0], u, positions, guards)
    return blocks_of(level, [replace(new, knot=knot) for knot in knots]) if knots else []


def own_knots(space: DesignSpace, axis: int, line: int | None) -> Array:
    """Knots that a new one would join: the line's own, or the lattice's."""
    if line is None or space.own is None:
        return space.rest.knots[axis]
    return space.own[line]


def positions_in(own: Array, common: Array, u: Array, count: int, guards: Guards) -> list[float]:
    """`count` places in each knot span, and knots that other lines have there already."""
    ends, found = np.unique(own), []
    least = guards.least_span * np.ptp(u[np.isfinite(u)])
    u = np.unique(u[np.isfinite(u)])
    for low, high in pairwise(ends):
        inner = common[(common > low) & (common < high)]
        even = low + (high - low) * np.arange(1, count + 1) / (count + 1)
        for knot in np.unique(np.concatenate([even, inner])):
            left, right = ((u > low) & (u < knot)).sum(), ((u > knot) & (u < high)).sum()
            if min(knot - low, high - knot) >= least and min(left, right) >= guards.points_beside:
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
        first, values = basis(finer, self.degree, self.u)
        offset = index - first
        along = np.where(
            (offset >= 0) & (offset <= self.degree) & self.inside,
            np.take_along_axis(values, np.clip(offset, 0, self.degree)[:, None], axis=1)[:, 0],
            0.0,
        )
        fields = along[:, None, None] * self.lines[line]
        return fields.reshape(-1, fields.shape[2])
