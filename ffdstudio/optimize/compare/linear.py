"""Optimization in any linear space of displacements, counted as studies count: CST and modes."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.budget import Budget, BudgetSpent
from ffdstudio.optimize.catalog.metrics import metric_named
from ffdstudio.optimize.ending import Ending
from ffdstudio.optimize.flow.panel import forget_flows
from ffdstudio.optimize.methods.descent import lbfgs
from ffdstudio.optimize.methods.problem import Memory, Trial
from ffdstudio.optimize.objectives.base import Objective, Request
from ffdstudio.optimize.runs.solver import FIRST_MOVE
from ffdstudio.optimize.variables.metrics import Surface, Whitening

UPRIGHT = np.array([1])  # displacements are along y


class LinearProblem:
    """A cost over vertical displacements of a section; see `methods.problem.Problem`.

    Attributes
    ----------
    path : list of (int, float)
        Solves that were spent, and the cost, after each evaluation.
    """

    def __init__(self, objective: Objective, points: Array, fields: Array, metric: str) -> None:
        forget_flows()
        self.objective, self.points = objective, points
        self.path: list[tuple[int, float]] = []
        self.solves, self.evaluations, self.budget = 0, 0, Budget()
        surface, chosen = Surface.curve(points), metric_named(metric)
        if chosen.responds and (response := objective.response(points)) is not None:
            surface = surface._replace(response=response.matrix)
            self.solves = response.solves
        white = Whitening.of(chosen.measure(surface, UPRIGHT) @ fields, plain=chosen.plain)
        self.shapes = fields @ white.matrix
        self.extent = float(np.ptp(points, axis=0).max())
        self._last: Trial | None = None

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.shapes.shape[1])

    def value(self, z: Array) -> Trial:
        """Cost, with its gradient: it costs one solve more and is always asked for next."""
        return self.gradient(z)

    residuals = value

    def gradient(self, z: Array) -> Trial:
        """Cost and gradient."""
        if self._last is not None and np.array_equal(self._last.z, z):
            return self._last
        self.budget.check_evaluation(self.evaluations)
        moved = self.points.copy()
        moved[:, 1] += self.shapes @ z
        found = self.objective.answer(Request(moved))
        assert found.gradient is not None
        self.evaluations += 1
        self.solves += found.flow + found.adjoint
        self.path.append((self.solves, found.value))
        self._last = Trial(np.array(z), found.value, found.gradient[:, 1] @ self.shapes)
        return self._last

    def displacement_cost(self, trial: Trial) -> Array | None:
        """None: the pressures fix all."""
        return None

    def control_cost(self, trial: Trial) -> tuple[Array, Array] | None:
        """None: no mesh follows."""
        return None

    def reach(self, z: Array, step: Array) -> float:
        """All the way: no mesh follows."""
        return 1.0

    def longest(self, direction: Array) -> float:
        """Multiple of a direction that moves the surface as far as a first step may."""
        move = float(np.abs(self.shapes @ direction).max())
        return FIRST_MOVE * self.extent / move if move > 0 else np.inf

    def report(self, trial: Trial) -> None:
        """Nothing waits for an iterate."""


def minimised(problem: LinearProblem, evaluations: int) -> Ending:
    """Run L-BFGS from no displacement until it ends or the evaluations are spent."""
    problem.budget = Budget(evaluations)
    try:
        return lbfgs(problem, np.zeros(problem.size), Memory())
    except BudgetSpent as spent:
        return spent.ending
