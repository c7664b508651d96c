"""Coarsening: the inserted knot goes that the shape misses least.

The coarser space does not hold the shape that was reached; the nearest one in the metric of the
sensitivity takes its place, and the caller decides by its cost. Knots of the first lattice stay.
"""

from __future__ import annotations

from collections.abc import Sequence

from ffdstudio.aliases import Array
from ffdstudio.optimize.refine.relocate import nearest_level, with_knots
from ffdstudio.optimize.refine.sensitivity import Sensitivity, Wanted
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.space import DesignSpace, Insertion


def coarsened(
    first: DesignSpace,
    insertions: Sequence[Insertion],
    level: Level,
    sensitivity: Sensitivity,
    z: Array,
) -> tuple[Level, Insertion]:
    """Level without one of the inserted knots, and that knot.

    Parameters
    ----------
    first : DesignSpace
        The space before any insertion, at rest.
    insertions : sequence of Insertion
        What made the level's space from it.
    """
    rest = level.body.embedding.points
    shape = sensitivity.measure(level.flat(level.at(z) - rest)[:, None])[:, 0]

    def missed(k: int) -> float:
        plain = Level(level.body, without(k), rest)
        return Wanted(plain, sensitivity, shape).distance

    def without(k: int) -> DesignSpace:
        return with_knots(first, [*insertions[:k], *insertions[k + 1 :]])

    k = min(range(len(insertions)), key=missed)
    return nearest_level(level, without(k), sensitivity, shape), insertions[k]
