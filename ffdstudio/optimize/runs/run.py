"""One run of a study: from level to level, each trial recorded.

1. A method is ended by an exception at one of its reports or evaluations: a refinement is due,
   the budget is spent, the user stops. What was reached is never lost.
2. The matrices are small: BLAS on one thread is faster, and by a factor of ten where other
   processes want the cores as well.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.optimize.budget import BudgetSpent, Counts
from ffdstudio.optimize.catalog.metrics import metric_named
from ffdstudio.optimize.control import Stopped
from ffdstudio.optimize.ending import CONVERGED, DUE, STALLED, STOPPED, Ending, Reason
from ffdstudio.optimize.flow.panel import forget_flows
from ffdstudio.optimize.followers.group import Followers
from ffdstudio.optimize.methods.problem import (
    Memory,
    Trial,
    carried_directions,
    reference_decrease,
)
from ffdstudio.optimize.objectives.failures import EvaluationError
from ffdstudio.optimize.refine.candidates import Guards
from ffdstudio.optimize.refine.choice import choose, due, limit, rank
from ffdstudio.optimize.refine.coarsen import coarsened
from ffdstudio.optimize.refine.relocate import present_level, relocated
from ffdstudio.optimize.runs.interruptions import Over, asking
from ffdstudio.optimize.runs.record import Log, Record, RunHistory, pack
from ffdstudio.optimize.runs.responding import responding
from ffdstudio.optimize.runs.solver import LevelProblem
from ffdstudio.optimize.variables.level import EmbeddedBody, Level
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.space import DesignSpace, Insertion
from ffdstudio.optimize.variables.weights import first_level

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.study import Study

Listener = Callable[[Record], None]
ALLOWED = 1e-6  # violation of a constraint that counts as met at the end
MET = 1e-8  # violation of a constraint that a coarser lattice may have


class _RefinementDue(Exception):
    """A trigger asks for a cycle of refinement."""


class _Kept(NamedTuple):
    """What to go back to."""

    level: Level
    best: Trial
    inserted: list[Insertion]
    problem: LevelProblem
    memory: Memory


class Run:
    """One run of a study; `to_the_end` does it."""

    def __init__(self, study: Study, history: RunHistory, listener: Listener | None) -> None:
        self.task, self.refinement, self.budget = study.task, study.refinement, study.budget
        self.study, self.history = study, history
        self._log = Log(study.folder, study.resume)
        self._listener, self._began = listener, time.perf_counter()
        forget_flows()
        self._number, self._iteration = 0, 0
        self.counts, self.memory = Counts(), Memory()
        body = EmbeddedBody(self.task.embedding, self._surface(), metric_named(self.task.metric))
        self.level = first_level(body, self.task.rules, self.task.current, self.task.knots)
        self._check_points()
        self._inserted, self._growing = list(self.task.knots), True
        self._reached: Trial | None = None
        self._limit = ""
        self._cautious: Callable[[], Level] | None = None
        self._moving, self._moves = bool(self.refinement and self.refinement.relocate), 0
        self._followers = Followers(self.task.followers)
        self._followers.begin(self.level.space.lattice)
        self.best: Trial

    def to_the_end(self) -> None:
        """Run until the study has ended or is stopped."""
        from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

        try:
            with threadpool_limits(1, user_api="blas"):  # see 2
                ending = self._coarsened(self._levels_or_over())
        finally:
            self._log.close()
        best, ending = self.best, self._in_full(ending)
        self._record("end", best.value, y=self._y(best.z), note=str(ending), ending=ending)
        self._log.close()

    def _check_points(self) -> None:
        """Refuse more variables than the points can tell apart: adaptive or not, all the same."""
        guards = Guards() if self.refinement is None else self.refinement.guards
        seen = int((self.task.surface.mass > 0).sum()) * len(self.level.coordinates)
        if self.level.space.size * guards.points_per_variable > seen:
            raise InputError(
                f"{self.level.space.size} variables need {guards.points_per_variable:g} points "
                f"each, and the surface has {seen // len(self.level.coordinates)}: take fewer "
                "control points"
            )

    def _surface(self) -> Surface:
        """The surface, with the response of the flow at the start where the metric needs it."""
        task = self.task
        if not metric_named(task.metric).responds or task.surface.response is not None:
            return task.surface
        points = task.embedding.points
        if task.current is not None:
            body = EmbeddedBody(task.embedding, task.surface)
            points = first_level(body, task.rules, task.current, task.knots).points
        return self._responding(task.surface, points)

    def _responding(self, surface: Surface, points: Array) -> Surface:
        found, solves = responding(self.task, surface, points)
        self.counts.flow += solves
        return found

    def _levels_or_over(self) -> Ending:
        try:
            return self._levels()
        except Over as over:
            return self._ended(over.ending)

    def _levels(self) -> Ending:
        """Go from level to level; returns why the study ended."""
        kept: _Kept | None = None
        while True:
            ending, over = self._one_level(), True
            if ending.on_a_level and kept is None:
                over = not self._refine()
            if (
                over
                and kept is not None
                and self.problem.merit(kept.best) < self.problem.merit(self.best)
            ):
                self._go_back(kept)
                kept, over = None, not ending.on_a_level  # where it was left it goes on
                self._moving, self._reached = False, self.best
            if not over:
                continue
            if self._moving and ending.on_a_level and self._inserted:
                kept = self._relocate()
                continue
            return self._ended(CONVERGED if ending.reason is Reason.DUE else ending)

    def _in_full(self, ending: Ending) -> Ending:
        """Why the study ended, with constraints that are not met and a guard that ended growth."""
        if self._violation() > ALLOWED:
            if ending == CONVERGED and self.problem.constrained:
                ending = STALLED
            ending = replace(ending, missed=True)
        return replace(ending, growth=self._limit)

    def _coarsened(self, before: Ending) -> Ending:
        """Remove knots as long as the cost allows it; returns why the study ended."""
        settings = self.refinement
        if settings is None or settings.coarsen is None or not before.well:
            return before
        self._growing = False
        merit = self.problem.merit(self.best)
        allowed = merit + settings.coarsen * self._worth(merit)
        allowed = max(allowed, self.budget.tolerance or 0.0)
        violation = max(MET, self._violation())
        while self._inserted:
            kept = self._kept()
            ended = self._remove()
            merit = self.problem.merit(self.best)
            if ended.well and merit <= allowed and self._violation() <= violation:
                self._ended(ended)
                continue
            self._go_back(kept)
            return self._ended(before if ended.well else ended)
        return before

    def _remove(self) -> Ending:
        """Remove a knot and run the method; returns why that ended."""
        first, z = DesignSpace.of(self.task.embedding.lattice, self.task.rules), self.best.z
        try:
            with asking():
                sensitivity = self.problem.sensitivity(self.best)
                self.level, gone = coarsened(first, self._inserted, self.level, sensitivity, z)
        except Over as over:
            return over.ending
        self._inserted = [c for c in self._inserted if c is not gone]
        self._begin_anew(f"removed: {_told(gone)}")
        return self._one_level()

    def _worth(self, merit: float) -> float:
        first = self.history.iterates[0].cost
        return abs(merit) if self.problem.largest else reference_decrease(merit, first)

    def _violation(self) -> float:
        points = self.level.at(self.best.z)
        return max(self.problem.slacks.violations(points).values(), default=0.0)

    def _kept(self) -> _Kept:
        return _Kept(self.level, self.best, self._inserted, self.problem, self.memory)

    def _go_back(self, kept: _Kept) -> None:
        self.level, self.best, self._inserted, self.problem, self.memory = kept

    def _begin_anew(self, note: str) -> None:
        """Record a level that does not hold the shape before: nothing is carried into it."""
        self.memory, self._number, self._reached = Memory(), self._number + 1, None
        lattice = self.level.space.lattice
        self._record("refinement", self.best.value, note=note, lattice=lattice)

    def _one_level(self) -> Ending:
        """Run the method on the present level; returns what ended it."""
        try:
            start = self._open_level()
            return self.study.method.minimise(self.problem, start, self.memory)
        except _RefinementDue:
            return DUE
        except BudgetSpent as spent:
            return spent.ending
        except Stopped:
            if not self.history.iterates:
                raise EvaluationError("stopped before the start was evaluated") from None
            return STOPPED
        except EvaluationError as failed:
            if not self.history.iterates:
                raise
            return Ending(Reason.FAILED, str(failed))

    def _relocate(self) -> _Kept:
        """Move the inserted knots; returns what to go back to if that does not help."""
        settings, kept, self._left = self.refinement, self._kept(), self.best
        assert settings is not None
        first, z = DesignSpace.of(self.task.embedding.lattice, self.task.rules), self.best.z
        with asking():
            level = self._refreshed(z)
            sensitivity = self.problem.sensitivity(self.best, level)
            z = z if level is self.level else np.zeros(level.size)
            self.level, self._inserted = relocated(
                first, self._inserted, level, sensitivity, z, settings.guards, settings.sweeps,
                settings.places,
            )  # fmt: skip
        space = self.level.space
        self._cautious = lambda: present_level(level, space, sensitivity, z)
        self._moves += 1
        self._moving = self._moves < settings.relocate
        self._begin_anew("relocated: " + ", ".join(_told(c) for c in self._inserted))
        return kept

    def _refreshed(self, z: Array) -> Level:
        """The present level around its present shape, in the metric of the flow there."""
        body = self.level.body
        if not body.metric.responds:
            return self.level
        points = self.level.at(z)
        fresh = EmbeddedBody(body.embedding, self._responding(body.surface, points), body.metric)
        return Level(fresh, self.level.space.around(self.level.white.matrix @ z), points)

    def _ended(self, ending: Ending) -> Ending:
        last = self.history.iterates[-1]
        if self.best is not self._last or last.level != self._number:
            self._iterate(self.best)  # what a stopped line search had found, or was better before
        return ending

    def _problem(self) -> LevelProblem:
        problem = LevelProblem(self.level, self.task, self.counts, self.study.method)
        problem.stopped = self.study.control.stopping
        problem.on_trial = self._evaluated
        problem.on_report = self._reported
        problem.on_difference = self._differenced
        problem.budget = self.budget
        return problem

    def _open_level(self) -> Array:
        self._values: list[float] = []
        self.problem = self._problem()
        self.best = self.problem.start(self._reached)
        self._be_cautious()
        if self._number == 0:
            self._iterate(self.best)
            self.study.control.check()
        self._values = [self.best.value]
        if self._number == 0 and not self.task.constraints:
            self.budget.check_cost(self.best.value)
        return self.best.z

    def _be_cautious(self) -> None:
        """Take the shape that was left, in the moved lattice, where the step made it worse."""
        make, self._cautious = self._cautious, None
        if make is not None and self.problem.merit(self.best) > self.problem.merit(self._left):
            self.level = make()
            self.problem = self._problem()
            self.best = self.problem.start(None)

    def _refine(self) -> list[Insertion]:
        settings = self.refinement
        if settings is None or self.level.space.size >= settings.variables:
            return []
        z = self.best.z
        with asking():
            sensitivity = self.problem.sensitivity(self.best)
            chosen = choose(self.level, sensitivity, settings, self._worth(self.best.value))
        self._limit = "" if chosen else limit(self.level, settings)
        self._inserted = [*self._inserted, *chosen]
        if chosen:
            self.level, carried = self.level.refined(chosen, z)
            carried = self._more(carried)
            self._reached = self.best
            self._carry(carried)
            self._number += 1
            note = ", ".join(_told(c) for c in chosen)
            lattice = self.level.space.lattice
            self._record("refinement", self.best.value, note=note, lattice=lattice)
        return chosen

    def _more(self, carried: Array) -> Array:
        """Further rounds of a cycle by the same gradient; the map of steps into the last level."""
        settings, surface = self.refinement, self.best.surface
        assert settings is not None
        for _ in range(settings.rounds - 1):
            if surface is None or self.level.space.size >= settings.variables:
                break
            with asking():
                sensitivity = self.problem.sensitivity(self.best, self.level)
                chosen = choose(self.level, sensitivity, settings, self._worth(self.best.value))
            if not chosen:
                break
            self._inserted = [*self._inserted, *chosen]
            self.level, further = self.level.refined(chosen, np.zeros(self.level.size))
            carried = further @ carried
        return carried

    def _carry(self, matrix: Array) -> None:
        """Take the memory into the finer space: steps by insertion, gradients by pulling back."""
        if not self.study.method.carry_memory:
            self.memory = Memory()
            return
        pairs: list[tuple[Array, Array, Array | None]] = [
            (matrix @ s, self.level.pull(surface), surface)
            for s, _, surface in self.memory.pairs
            if surface is not None
        ]
        plain = self.level.body.metric.plain
        directions = (None, None) if plain else carried_directions(self.memory, matrix)
        known = self.memory
        self.memory = Memory(pairs, *directions, scale=known.scale, steepest=known.steepest)
        self.memory.highest, self.memory.fall = known.highest, known.fall

    # ---- what the problem tells -------------------------------------------------------------

    def _evaluated(self, trial: Trial) -> None:
        gradient = np.nan if trial.gradient is None else float(np.linalg.norm(trial.gradient))
        self._record("evaluation", trial.value, gradient, y=self._y(trial.z))
        if self.problem.better(trial, getattr(self, "best", trial)):
            self.best = trial
        if self.history.iterates:  # where the study began is always an iterate
            self.study.control.check()

    def _differenced(self, y: list[float], cost: float) -> None:
        self._record("evaluation", cost, y=y)
        if self.history.iterates:
            self.study.control.check()

    def _reported(self, trial: Trial) -> None:
        self.best = trial
        self._iteration += 1
        self._iterate(trial)
        self._values.append(trial.value)
        self.study.control.wait()
        self.budget.check_iterate(self._iteration, trial.value)
        if self._refinement_due(trial):
            raise _RefinementDue

    def _refinement_due(self, trial: Trial) -> bool:
        settings = self.refinement
        full = settings is None or self.level.space.size >= settings.variables
        full = full and not self._moving
        if settings is None or full or not self._growing:
            return False

        first = self.history.iterates[0].cost

        def best_gain() -> float:
            return rank(self.level, self.problem.sensitivity(trial), settings).best

        return due(settings, len(self._values) - 1, self._values, first, trial.gradient, best_gain)

    def _iterate(self, trial: Trial) -> None:
        lattice = self.level.space.at(self.level.white.matrix @ trial.z)
        gradient = np.nan if trial.gradient is None else float(np.linalg.norm(trial.gradient))
        measures = dict(self.problem.measures)
        if self.task.monitor is not None:
            measures |= self.task.monitor(lattice)
        measures |= self._followers.figures(lattice)
        self._last = trial
        self._record("iterate", trial.value, gradient, self._y(trial.z), measures, lattice)

    def _y(self, z: Array) -> list[float]:
        return list((self.level.white.matrix @ z).tolist())

    def _record(
        self,
        kind: str,
        cost: float,
        gradient: float = np.nan,
        y: list[float] | None = None,
        measures: dict[str, float] | None = None,
        lattice: Lattice | None = None,
        note: str = "",
        ending: Ending | None = None,
    ) -> None:
        record = Record(
            kind, self.counts.evaluations, self._iteration, self._number, self.level.space.size,
            float(cost), gradient, self.counts.flow, self.counts.adjoint,
            self._log.elapsed + time.perf_counter() - self._began, y or [], measures or {},
            None if lattice is None else pack(lattice), note, ending,
        )  # fmt: skip
        self._log.add(record)
        self.history.records.append(record)
        if self._listener is not None:
            self._listener(record)


def _told(new: Insertion) -> str:
    where = "" if new.line is None else f" in line {new.line}"
    return f"{'ijk'[new.axis]} = {new.knot:.6g}{where}"
