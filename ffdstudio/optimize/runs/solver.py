"""The problem that a method sees on one level: trials, counts, budget, constraints."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.optimize.budget import Budget, BudgetSpent, Counts
from ffdstudio.optimize.constraint_values import Slack, Slacks
from ffdstudio.optimize.constraints.base import Relation
from ffdstudio.optimize.ending import Reason
from ffdstudio.optimize.followers.group import Followers
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.methods.minimax import largest
from ffdstudio.optimize.methods.problem import Trial, parts
from ffdstudio.optimize.objectives.base import Evaluation, Request, never
from ffdstudio.optimize.objectives.failures import NotFinite
from ffdstudio.optimize.objectives.stream import evaluated, streamed
from ffdstudio.optimize.refine.sensitivity import Adjoint, Differences, Residuals, Sensitivity
from ffdstudio.optimize.variables.level import Level

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.study import Task

FIRST_MOVE = 0.02  # of the extent: how far a first step may move the surface
DIFFERENCE = 1e-5  # of the extent: how far a finite difference moves the surface
MILD = 1e-8  # of the Hessian: what displacements of control points cost where meshes follow
ACTIVE = 1e-6  # slack below which an inequality counts as active


class LevelProblem:
    """See `methods.problem.Problem`."""

    def __init__(self, level: Level, task: Task, counts: Counts, method: MethodSpec) -> None:
        self.level, self.task, self.counts = level, task, counts
        self.size = level.size
        self.constrained, self.largest = method.constraints, method.largest
        self._least_squares = method.residuals
        self.on_trial: Callable[[Trial], None] = lambda trial: None
        self.on_report: Callable[[Trial], None] = lambda trial: None
        self.on_difference: Callable[[list[float], float], None] = lambda y, value: None
        self.stopped: Callable[[], bool] = never
        self.budget = Budget()
        self.measures: dict[str, float] = {}
        self.slacks = Slacks(task.constraints, counts)
        self.followers = Followers(task.followers)
        self._last: Trial | None = None
        seen = level.body.embedding.points[level.body.surface.mass > 0]
        self.extent = float(np.ptp(seen, axis=0).max())

    # ---- trials -----------------------------------------------------------------------------

    def value(self, z: Array) -> Trial:
        """Cost alone."""
        if self._last is not None and np.array_equal(self._last.z, z):
            return self._last
        return self._evaluated(z, gradient=False)

    def gradient(self, z: Array) -> Trial:
        """Cost and gradient, by finite differences if the objective has none."""
        last = self._last
        if last is not None and last.gradient is not None and np.array_equal(last.z, z):
            return last
        if not self.task.objective.abilities.gradient:
            here = self.value(z)
            return self._by_differences(z) if np.isfinite(here.value) else here
        return self._evaluated(z, gradient=True)

    def residuals(self, z: Array) -> Trial:
        """Cost with residuals and their derivatives."""
        trial = self.gradient(z)
        if np.isfinite(trial.value):
            parts(trial)
        return trial

    def start(self, reached: Trial | None) -> Trial:
        """First trial of a level: the shape that the coarser one reached, not evaluated again."""
        z = np.zeros(self.size)
        if reached is None:
            return self.residuals(z) if self.largest else self.value(z)
        trial = Trial(z, reached.value, None, reached.surface, reached.residuals)
        if reached.surface is not None:
            trial.gradient = self.level.pull(reached.surface)
        if reached.by_points is not None:
            trial.by_points = reached.by_points
            trial.jacobian = trial.by_points @ self.level.shapes
        self._last = trial
        self._share(self.level.at(z))
        return trial

    def _share(self, points: Array) -> None:
        """Let constraints know which flows the cost has solved about a shape."""
        self.slacks.share(points, self.task.objective.abilities.angles)

    def longest(self, direction: Array) -> float:
        """Multiple of a direction that moves no point by more than a fiftieth of the extent."""
        move = float(np.abs(self.level.moves @ direction).max())
        return FIRST_MOVE * self.extent / move if move > 0 else np.inf

    def displacement_cost(self, trial: Trial) -> Array | None:
        """See `methods.problem.Problem`: needed where points may slide along a target.

        On a surface in 3D they do so with one direction as well, where it is nearly tangential;
        on sections the vertical direction alone needs no help with two rows, and a mild
        regularisation of bending with three or more.
        """
        spatial = self.level.space.rest.dimension == 3
        felt = 3 if spatial else len(self.level.coordinates)
        sliding = len(parts(trial)[0]) < felt * self.task.seen_points
        if sliding:
            return self.level.displacement_cost
        shape = self.level.space.rest.shape
        return self.level.bending_cost if len(shape) == 2 and shape[1] > 2 else None

    def control_cost(self, trial: Trial) -> tuple[Array, Array] | None:
        """See `methods.problem.Problem`: the mean square, small against the Hessian."""
        if not any(body.walls is None for body in self.task.followers):
            return None
        white, space = self.level.white, self.level.space
        by_variables = parts(trial)[1] @ white.inverse
        size = np.sqrt(MILD / max(space.size, 1)) * float(np.linalg.norm(by_variables, 2))
        moved = (space.basis @ white.matrix, space.displacements.ravel())
        return size * moved[0], size * moved[1]

    def report(self, trial: Trial) -> None:
        """Hear of an iterate."""
        self.on_report(trial)

    def better(self, trial: Trial, other: Trial) -> bool:
        """Whether a trial is to be kept: SLSQP's iterates alone tell, for they are feasible."""
        free = not (self.constrained and self.task.constraints)
        return free and self.merit(trial) < self.merit(other)

    def merit(self, trial: Trial) -> float:
        """What the method makes small: the cost, or the largest residual."""
        return largest(trial) if self.largest and np.isfinite(trial.value) else trial.value

    def _evaluated(self, z: Array, gradient: bool) -> Trial:
        self.budget.check_evaluation(self.counts.evaluations)
        if self.task.followers and not self.followers.valid(self._lattice(z)):
            return self._refused(z)
        points = self.level.at(z)
        variables = (self.level.white.matrix @ z).tolist()
        try:
            found = evaluated(
                self.task.objective, Request(points, gradient, variables, self.stopped)
            )
        except NotFinite:
            if self._last is None:
                raise
            return self._without_value(z)
        self._count(found)
        return self._trial(z, points, found)

    def reach(self, z: Array, step: Array) -> float:
        """See `methods.problem.Problem`."""
        if not self.task.followers:
            return 1.0
        return self.followers.reach(self._lattice(z), self._lattice(z + step))

    def _lattice(self, z: Array) -> Lattice:
        return self.level.space.at(self.level.white.matrix @ z)

    def _refused(self, z: Array) -> Trial:
        """Trial of a shape that turns cells inside out: worse than any, and never evaluated."""
        self._last = Trial(np.array(z), np.inf, np.zeros(self.size))
        return self._last

    def _without_value(self, z: Array) -> Trial:
        """Trial of a shape whose cost is no number: worse than any, so that steps get shorter."""
        self.counts.evaluations += 1
        self.counts.flow += 1
        self._last = Trial(np.array(z), np.inf, np.zeros(self.size))
        self.on_trial(self._last)
        return self._last

    def _count(self, found: Evaluation) -> None:
        self.counts.evaluations += 1
        self.counts.flow += found.flow
        self.counts.adjoint += found.adjoint

    def _trial(self, z: Array, points: Array, found: Evaluation) -> Trial:
        trial = Trial(np.array(z), found.value)
        if found.gradient is not None:
            trial.surface, trial.gradient = found.gradient, self.level.pull(found.gradient, z)
        if found.residuals is not None and found.sensitivity is not None:
            trial.residuals = found.residuals
            trial.by_points = self.level.columns(found.sensitivity)
            trial.jacobian = trial.by_points @ self.level.shapes_at(z)
        self._share(points)
        self._penalise(trial, points)
        missed = {f"violation: {k}": v for k, v in self.slacks.violations(points).items()}
        self._last, self.measures = trial, {**found.measures, **missed}
        self.on_trial(trial)
        return trial

    def _by_differences(self, z: Array) -> Trial:
        here = self.value(z)
        steps = np.array([DIFFERENCE / FIRST_MOVE * self.longest(e) for e in np.eye(self.size)])
        variables = (self.level.white.matrix @ (z + np.diag(steps)).T).T
        fields = self.level.shapes_at(z) * steps
        here.gradient = self._differences(here, fields, variables.tolist()) / steps
        return here

    def _differences(
        self, here: Trial, fields: Array, variables: list[list[float]] | None
    ) -> Array:
        """Changes of the cost by columns of displacements, with the design variables of each."""
        count = fields.shape[1]
        allowed = self.budget.allowed(count, self.counts.evaluations)
        shifted, values = islice(self._shifted(here, fields, variables), allowed), []
        with closing(streamed(self.task.objective, shifted, self.stopped)) as stream:
            for request, found in stream:
                self._count(found)
                values.append(found.value + self._penalty(request.points))
                self.on_difference(request.variables or [], values[-1])
        if allowed < count:
            raise BudgetSpent(Reason.EVALUATIONS)
        return np.array(values) - here.value

    def _shifted(
        self, here: Trial, fields: Array, variables: list[list[float]] | None
    ) -> Iterator[Request]:
        points = self.level.at(here.z)
        for k, column in enumerate(fields.T):
            moved = points.copy()
            moved[:, self.level.coordinates] += column.reshape(-1, len(self.level.coordinates))
            here_too = None if variables is None else variables[k]
            yield Request(moved, False, here_too, self.stopped)

    # ---- constraints ------------------------------------------------------------------------

    def constraint_count(self, kind: Relation) -> int:
        """Number of constraints of a kind."""
        return sum(c.kind == kind for c in self.task.constraints)

    def constraints(self, z: Array, kind: Relation) -> Slack:
        """Slacks of a kind and their derivatives by the variables."""
        points = self.level.at(z)
        return Slack(
            lambda: self.slacks.values(points, kind),
            lambda: self._pulled(self.slacks.rows(points, kind), z),
        )

    def _pulled(self, rows: Array, z: Array) -> Array:
        by_point = rows.reshape(len(rows), -1, 3)[:, :, self.level.coordinates]
        return by_point.reshape(len(rows), -1) @ self.level.shapes_at(z)

    def _penalty(self, points: Array) -> float:
        """Half the squared violations, for methods that know no constraints."""
        if self.constrained or not self.task.constraints:
            return 0.0
        equal, least = self._missed(points)
        return 0.5 * self.task.penalty * float(equal @ equal + least @ least)

    def _missed(self, points: Array) -> tuple[Array, Array]:
        equal, least = (self.slacks.values(points, kind) for kind in Relation)
        return equal, np.minimum(least, 0.0)

    def _penalise(self, trial: Trial, points: Array) -> None:
        if self.constrained or not self.task.constraints:
            return
        trial.value += self._penalty(points)
        trial.residuals = trial.jacobian = trial.by_points = None
        if trial.surface is not None:
            equal, least = self._missed(points)
            by_equal, by_least = (self.slacks.rows(points, kind) for kind in Relation)
            slope = self.task.penalty * (equal @ by_equal + least @ by_least)
            trial.surface = trial.surface + slope.reshape(-1, 3)
            trial.gradient = self.level.pull(trial.surface, trial.z)

    # ---- what a refinement wants to know ----------------------------------------------------

    def sensitivity(self, trial: Trial, level: Level | None = None) -> Sensitivity:
        """Derivatives along surface functions: of the cost, or the Lagrangian if constrained."""
        if trial.gradient is None:
            trial = self.gradient(trial.z)
        if trial.surface is None:
            return Differences(self.level, lambda functions: self._along(trial, functions))
        slopes = self.level.body.metric.slopes
        if trial.by_points is not None and (self._least_squares or not slopes):
            return Residuals(self.level, parts(trial)[0], trial.by_points)
        return Adjoint(level or self.level, trial.surface - self._multiplied(trial))

    def _along(self, here: Trial, functions: Array) -> Array:
        """Finite differences of the cost along functions on the surface."""
        size = np.abs(functions).max(axis=0)
        steps = DIFFERENCE * self.extent / np.where(size > 0, size, 1.0)
        return self._differences(here, functions * steps, None) / steps

    def _multiplied(self, trial: Trial) -> Any:
        """Gradient of the active constraints times their first-order multipliers."""
        if not (self.constrained and self.task.constraints):
            return 0.0
        from scipy.optimize import lsq_linear

        points = self.level.at(trial.z)
        equal = self.slacks.values(points, Relation.EQUAL)
        by_equal = self.slacks.rows(points, Relation.EQUAL)
        by_least = self.slacks.rows(points, Relation.LEAST)
        by_least = by_least[self.slacks.values(points, Relation.LEAST) <= ACTIVE]
        rows = np.vstack([by_equal, by_least])
        if not len(rows):
            return 0.0
        lower = np.concatenate([np.full(len(equal), -np.inf), np.zeros(len(by_least))])
        found = lsq_linear(self._pulled(rows, trial.z).T, trial.slope, bounds=(lower, np.inf))
        return (found.x @ rows).reshape(-1, 3)
