"""Relocation of knots: each inserted knot in turn moves to the best place there is.

1. Without its knot a space is coarser; the gain of a candidate there is exactly what the knot is
   worth at that place, so one frame serves all places.
2. What is compared is the distance to the displacement that the cost asks for (`wanted`).
   The space at the end does not contain the one before: the caller keeps the better result.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.optimize.refine.candidates import Guards, beside, blocks_of, candidates
from ffdstudio.optimize.refine.indicators import GainState
from ffdstudio.optimize.refine.sensitivity import Sensitivity, Wanted
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.rows import row_basis
from ffdstudio.optimize.variables.space import DesignSpace, Insertion, joined


def relocated(
    first: DesignSpace,
    insertions: list[Insertion],
    level: Level,
    sensitivity: Sensitivity,
    z: Array,
    guards: Guards,
    sweeps: int = 20,
    positions: int = 19,
) -> tuple[Level, list[Insertion]]:
    """Level with inserted knots at better places, at the shape nearest to the wanted one.

    Parameters
    ----------
    first : DesignSpace
        The space before any insertion, at rest.
    insertions : list of Insertion
        What made the level's space from it.
    sweeps, positions : int
        Rounds over all knots at most, and places tried in the span of each.
    """
    rest = level.body.embedding.points
    wanted = sensitivity.wanted(level.flat(level.at(z) - rest))
    places = list(insertions)
    for _ in range(sweeps):
        before = list(places)
        for k in range(len(places)):
            places[k] = _best_place(first, places, k, level, sensitivity, wanted, guards, positions)
        if places == before:
            break
    return nearest_level(level, with_knots(first, places), sensitivity, wanted), places


def present_level(level: Level, space: DesignSpace, sensitivity: Sensitivity, z: Array) -> Level:
    """Level of another space at its shape nearest to that of a level at z."""
    rest = level.body.embedding.points
    present = sensitivity.measure(level.flat(level.at(z) - rest)[:, None])[:, 0]
    around_rest = replace(space, lattice=space.rest)
    return nearest_level(level, around_rest, sensitivity, present)


def nearest_level(
    level: Level, space: DesignSpace, sensitivity: Sensitivity, wanted: Array
) -> Level:
    """Level of a space at rest, at its shape nearest to a measured displacement."""
    points = level.body.embedding.points.copy()
    plain = Level(level.body, space, points)
    target = Wanted(plain, sensitivity, wanted)
    y = np.linalg.lstsq(plain.fields, target.nearest, rcond=None)[0]
    points[:, plain.coordinates] += (plain.fields @ y).reshape(-1, len(plain.coordinates))
    return Level(level.body, space.around(y), points)


def with_knots(first: DesignSpace, insertions: list[Insertion]) -> DesignSpace:
    """Space after several insertions, made at once where rules or rows give the basis."""
    if first.fixed.any():
        space = first
        for new in insertions:
            space = space.refined(new)[0]
        return space
    rest = first.rest
    insertions = _joined(rest, insertions)
    for axis in range(rest.dimension):
        columns = [new.knot for new in insertions if new.axis == axis and new.line is None]
        rest = rest.insert_knots(axis, columns)
    rows = [new for new in insertions if new.line is not None]
    return _with_rows(rest, first, rows) if rows else DesignSpace.of(rest, first.rules)


def _joined(rest: Lattice, insertions: list[Insertion]) -> list[Insertion]:
    """Insertions in which knots that differ by rounding are one."""
    known, found = list(rest.knots), []
    for new in insertions:
        new = replace(new, knot=joined(known[new.axis], new.knot))
        known[new.axis] = np.append(known[new.axis], new.knot)
        found.append(new)
    return found


def _with_rows(rest: Lattice, first: DesignSpace, rows: list[Insertion]) -> DesignSpace:
    axis = rows[0].axis
    own = [rest.knots[axis]] * (rest.weights.size // rest.shape[axis])
    for new in rows:
        assert new.line is not None
        own[new.line] = np.sort(np.append(own[new.line], new.knot))
    knots = {new.knot for new in rows} - set(rest.knots[axis].tolist())
    rest = rest.insert_knots(axis, sorted(knots))
    basis = row_basis(rest, first.rules, axis, tuple(own))
    fixed = np.zeros(rest.shape, dtype=bool)
    return DesignSpace(rest, rest, first.rules, fixed, basis, False, tuple(own))


def _best_place(
    first: DesignSpace,
    places: list[Insertion],
    k: int,
    level: Level,
    sensitivity: Sensitivity,
    wanted: Array,
    guards: Guards,
    positions: int,
) -> Insertion:
    others = places[:k] + places[k + 1 :]
    coarse = Level(level.body, with_knots(first, others), level.body.embedding.points)
    state = GainState(Wanted(coarse, sensitivity, wanted))
    mine = places[k]
    found = candidates(coarse, (mine.axis,), 3, mine.line is not None, guards, (mine.line,))
    found += beside(coarse, mine, positions, guards)
    here = blocks_of(coarse, [mine])[0]
    gains = state.gains([*found, here])
    best = int(np.argmax(gains))
    if best == len(found) or gains[best] <= (1 + 1e-3) * gains[-1]:
        return mine
    return replace(mine, knot=found[best].insertion.knot)
