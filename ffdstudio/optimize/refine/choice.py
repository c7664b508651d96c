"""Which knots a cycle of refinement inserts, and when a cycle is due."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.catalog.indicators import indicator_named
from ffdstudio.optimize.methods.problem import reference_decrease
from ffdstudio.optimize.refine.candidates import Candidate, Guards, candidates
from ffdstudio.optimize.refine.indicators import GainState
from ffdstudio.optimize.refine.sensitivity import Sensitivity
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.space import Insertion


@dataclass(frozen=True)
class Refinement:
    """How a lattice is refined.

    Attributes
    ----------
    indicator : {"gain", "interval", "gradient"}
    axes : tuple of int
        Directions that get knots; the one that gains most per variable is chosen.
    variables : int
        Number of variables at the end.
    positions : int
        Candidate places in each knot span.
    insertions : int
        Knots a cycle.
    row_wise : bool
        A new knot frees one line of control points only.
    iterations : int, optional
        Cycle due after so many iterations on a level; else when the method has converged.
    slope : float, optional
        Cycle due when an iteration lowers the cost by less than this factor, for example 0.8:
        by less than a fifth of the cost or of its decrease so far.
    share : float, optional
        Cycle due when the present space holds less than this share of the gradient energy that
        it and the best candidate hold together.
    least_gain : float
        No candidate gains more than this fraction of the cost or of its decrease so far: the
        refinement has ended.
    rounds : int
        Rounds of insertions in a cycle, all by the same gradient: spans that a round has made
        are halved by the next.
    relocate : int
        How often the inserted knots move to better places once all are in; True is once. With
        the metric of a flow its response is taken anew there, so that the shape that the cost
        asks for is a whole Gauss-Newton step.
    sweeps, places : int
        Rounds over all knots of a relocation, and places that are tried in a span.
    coarsen : float, optional
        At the end take inserted knots out again, those that are missed least, as long as the
        cost stays within (1 + coarsen) times what was reached or within the budget's tolerance.
    """

    indicator: str = "gain"
    axes: tuple[int, ...] = (0,)
    variables: int = 70
    positions: int = 5
    insertions: int = 1
    row_wise: bool = False
    iterations: int | None = None
    slope: float | None = None
    share: float | None = None
    least_gain: float = 1e-9
    rounds: int = 1
    relocate: int = 0
    sweeps: int = 20
    places: int = 19
    coarsen: float | None = None
    guards: Guards = field(default_factory=Guards)

    @classmethod
    def for_flows(cls, variables: int) -> Self:
        """What has proved best for pressures: all knots after the first iteration, then moves.

        Rounds that each may halve every span of every row insert all knots by the gradient of
        the first iterate; after one more iteration they are moved by a whole Gauss-Newton step,
        and once more when that has been taken. Calibrated on eleven sections and frozen.

        Examples
        --------
        >>> Refinement.for_flows(40).row_wise
        True
        """
        return cls(
            variables=variables, iterations=1, insertions=variables, rounds=9, row_wise=True,
            relocate=2, sweeps=2, places=9,
        )  # fmt: skip

    def __post_init__(self) -> None:
        indicator_named(self.indicator)
        if self.positions < 1 or self.insertions < 1:
            raise InputError("a refinement needs at least one position a span and one insertion")
        if self.coarsen is not None and not 0 <= self.coarsen < np.inf:
            raise InputError(f"coarsen must be at least 0, got {self.coarsen}")


@dataclass(frozen=True)
class Ranking:
    """Candidates with what they are worth, the best first."""

    candidates: Sequence[Candidate]
    scores: Array

    @property
    def best(self) -> float:
        """The largest score, 0 without candidates."""
        return float(self.scores[0]) if len(self.scores) else 0.0


def rank(level: Level, sensitivity: Sensitivity, settings: Refinement) -> Ranking:
    """Rank all candidates per variable that they bring."""
    found = [c for c in _all(level, settings) if level.space.size + c.size <= settings.variables]
    if not found:
        return Ranking([], np.zeros(0))
    scores = indicator_named(settings.indicator).scores(level, sensitivity, found)
    scores = scores / np.array([c.size for c in found])
    order = np.argsort(-scores, kind="stable")
    return Ranking([found[k] for k in order], scores[order])


def choose(
    level: Level, sensitivity: Sensitivity, settings: Refinement, cost: float
) -> list[Insertion]:
    """Knots of one cycle; empty if nothing is gained or allowed any more."""
    ranking = rank(level, sensitivity, settings)
    if not ranking.candidates or ranking.best <= settings.least_gain * cost:
        return []
    if indicator_named(settings.indicator).greedy:
        return _greedy(level, sensitivity, settings, ranking)
    return _one_a_span(level, settings, ranking)


def limit(level: Level, settings: Refinement) -> str:
    """Which guard leaves no candidate, in words; empty if it is none of them."""
    left, guards = settings.variables - level.space.size, settings.guards
    if any(c.size <= left for c in _all(level, settings)):
        return ""
    freed = replace(settings, guards=replace(guards, points_per_variable=1e-9))
    sizes = [c.size for c in _all(level, freed)]
    if sizes and min(sizes) > left:
        return ""
    reason = (
        f"{guards.points_per_variable:g} points a variable are needed, and there are "
        f"{int(level.on_surface.sum())}"
        if sizes
        else f"a knot needs {guards.points_beside} points and {guards.least_share:.2%} of the "
        "surface on both sides within its span"
    )
    return f"growth ended at {level.space.size} of {settings.variables} variables: {reason}"


def _all(level: Level, settings: Refinement) -> list[Candidate]:
    return candidates(level, settings.axes, settings.positions, settings.row_wise, settings.guards)


def _greedy(
    level: Level, sensitivity: Sensitivity, settings: Refinement, ranking: Ranking
) -> list[Insertion]:
    """The best candidate, then the best beside it, and so on: one a span and line."""
    state, chosen = GainState(sensitivity), [ranking.candidates[0]]
    left = list(ranking.candidates)
    while len(chosen) < settings.insertions:
        state.accept(chosen[-1])
        left = [c for c in left if c.place != chosen[-1].place]
        if not left or not _room(level, settings, [*chosen, left[0]]):
            break
        scores = state.gains(left) / np.array([c.size for c in left])
        chosen.append(left[int(np.argmax(scores))])
    return [c.insertion for c in chosen]


def _one_a_span(level: Level, settings: Refinement, ranking: Ranking) -> list[Insertion]:
    chosen: list[Candidate] = []
    halved = indicator_named(settings.indicator).middle
    for c in ranking.candidates:
        if c.place in {other.place for other in chosen}:
            continue
        if len(chosen) == settings.insertions or not _room(level, settings, [*chosen, c]):
            break
        middle = [o for o in ranking.candidates if o.place == c.place]
        chosen.append(middle[len(middle) // 2] if halved else c)
    return [c.insertion for c in chosen]


def _room(level: Level, settings: Refinement, chosen: Sequence[Candidate]) -> bool:
    return level.space.size + sum(c.size for c in chosen) <= settings.variables


def due(
    settings: Refinement,
    iterations: int,
    values: Sequence[float],
    first: float,
    gradient: Array | None,
    best_gain: Callable[[], float],
) -> bool:
    """Whether one of the triggers asks for a cycle; `first` is the cost at the very start."""
    if settings.iterations is not None and iterations >= settings.iterations:
        return True
    if settings.slope is not None and len(values) > 1:
        least = (1 - settings.slope) * reference_decrease(
            values[-2], first + values[-2] - values[-1]
        )
        if values[-2] - values[-1] < least:
            return True
    if settings.share is None or gradient is None:
        return False
    held = float(gradient @ gradient)
    return held < settings.share * (held + best_gain())
