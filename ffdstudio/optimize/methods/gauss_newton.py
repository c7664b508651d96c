"""Gauss-Newton within a trust region, for the least squares of residuals.

1. A step solves the residuals made linear, by a singular value decomposition: values below 1e-6
   of the largest are cut off, and a step that leaves the trust region is damped (Levenberg 1944,
   Marquardt 1963) until it fits. The region grows and shrinks with the ratio of the decrease
   that is found to the one that was expected (More 1978; Nocedal and Wright, algorithm 4.1).
2. A distance to a surface does not feel points that slide along it. Displacements in all
   directions are then nearly undetermined, and small residuals ask for huge ones. So the
   displacement itself is made small beside the residuals (Tikhonov), in a norm that knows folds.
   Its factor vanishes with the power 3/2 of the residual: with the first power a reachable
   target would be approached at a constant rate only, with the second one points that are
   already near slide and fold.
3. Where the lattice carries meshes, a mild cost keeps control points near that the residuals
   hardly feel: they would go as far as a chord, and turn the mesh inside out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.ending import CONVERGED, STALLED, Ending
from ffdstudio.optimize.methods.base import MethodSpec, Trigger
from ffdstudio.optimize.methods.problem import Memory, Problem, Trial
from ffdstudio.optimize.methods.problem import parts as linear

RANK = 1e-6
ENOUGH = 1e-6  # a share of the cost: an iteration that gains less is the last
SLOW = 1e-2  # the same where points may slide: they could creep for ever
PULL = 10.0  # what a displacement costs at a residual as large as the surface, see 2
FARTHEST = 10.0  # first moves of the surface that a step may make
SHRUNK, SUFFICIENT = 12, 1e-4  # trials of a step, and the share of a decrease that will do
ROUNDING = 1e-13  # of the extent: residuals that mean nothing


class QuadraticModel(NamedTuple):
    """Least squares |matrix step - right|^2 by its singular values."""

    right: Array
    sigma: Array
    directions: Array

    @classmethod
    def of(cls, matrix: Array, right: Array) -> QuadraticModel:
        """Decompose, and cut small values off."""
        u, sigma, vt = np.linalg.svd(matrix, full_matrices=False)
        kept = sigma > RANK * sigma[0] if sigma[0] > 0 else np.zeros(len(sigma), dtype=bool)
        return cls(u[:, kept].T @ right, sigma[kept], vt[kept])

    def step(self, damping: float) -> Array:
        """Damped solution."""
        return (self.right * self.sigma / (self.sigma**2 + damping)) @ self.directions

    def within(self, radius: float) -> Array:
        """Longest solution within a radius; damping by bisection of its logarithm."""
        step = self.step(0.0)
        if np.linalg.norm(step) <= radius:
            return step
        low, high = -16.0, 16.0  # decades around the largest singular value squared
        for _ in range(60):
            middle = 0.5 * (low + high)
            step = self.step(self.sigma[0] ** 2 * 10**middle)
            low, high = (middle, high) if np.linalg.norm(step) > radius else (low, middle)
        return self.step(self.sigma[0] ** 2 * 10**high)

    def decrease(self, step: Array) -> float:
        """Decrease of half the sum of squares that a step is expected to bring."""
        after = self.sigma * (self.directions @ step) - self.right
        return 0.5 * float(self.right @ self.right - after @ after)


class Extra(NamedTuple):
    """Rows beside the residuals: what displacements cost, half the square of rows z + values."""

    rows: Array
    values: Array

    @classmethod
    def of(cls, problem: Problem, here: Trial, cost: Array | None) -> Extra:
        """What points that slide cost, see 2, and control points where meshes follow, see 3."""
        rows, values = np.zeros((0, len(here.z))), np.zeros(0)
        if cost is not None:
            size = float(np.linalg.norm(linear(here)[0]) / problem.extent)
            rows = np.sqrt(PULL * size**1.5) * cost
            values = np.zeros(len(cost))
        mild = problem.control_cost(here)
        if mild is None:
            return cls(rows, values)
        return cls(np.vstack([rows, mild[0]]), np.concatenate([values, mild[1]]))

    def merit(self, trial: Trial) -> float:
        """Cost with that of displacements."""
        return trial.value + 0.5 * float(np.sum((self.rows @ trial.z + self.values) ** 2))


def gauss_newton(problem: Problem, z: Array, memory: Memory) -> Ending:
    """Minimise half the sum of squares of the residuals."""
    here, radius = problem.residuals(z), np.inf
    if not np.isfinite(here.value):
        return STALLED
    while True:
        cost = problem.displacement_cost(here)
        extra = Extra.of(problem, here, cost)
        model = _model(here, extra)
        whole = model.step(0.0)
        expected = model.decrease(whole)
        if expected <= 0.5 * (ROUNDING * problem.extent) ** 2:
            return CONVERGED
        farthest = FARTHEST * problem.longest(whole) * float(np.linalg.norm(whole))
        found, radius = _better(problem, here, model, min(radius, farthest), extra)
        if found is None:
            return CONVERGED if expected <= ENOUGH * here.value else STALLED
        gained, here = 1 - found.value / here.value, found
        problem.report(here)
        if gained <= (ENOUGH if cost is None else SLOW) or (
            cost is None and expected <= 1e-4 * here.value
        ):
            return CONVERGED


def _model(here: Trial, extra: Extra) -> QuadraticModel:
    """Linear least squares around a trial."""
    residuals, jacobian = linear(here)
    values = extra.rows @ here.z + extra.values
    return QuadraticModel.of(
        np.vstack([jacobian, extra.rows]), -np.concatenate([residuals, values])
    )


def _better(
    problem: Problem, here: Trial, model: QuadraticModel, radius: float, extra: Extra
) -> tuple[Trial | None, float]:
    """Trial of less cost within the region, which shrinks until there is one; and the region."""
    for _ in range(SHRUNK):
        step = model.within(radius)
        length = float(np.linalg.norm(step))
        trial = problem.residuals(here.z + step)
        if not np.isfinite(trial.value):
            share = problem.reach(here.z, step)
            radius = length * (share if share < 1 else 0.25)
            continue
        ratio = (extra.merit(here) - extra.merit(trial)) / model.decrease(step)
        if ratio > SUFFICIENT and trial.value < here.value:
            if ratio > 0.75:
                return trial, max(radius, 2 * length)
            return trial, radius if ratio > 0.25 else 0.5 * length
        radius = 0.25 * length
    return None, radius


class GaussNewton(MethodSpec, frozen=True, tag="gauss-newton"):
    """Gauss-Newton within a trust region: for distances, without constraints."""

    title = "Gauss-Newton"
    residuals = True
    trigger = Trigger()

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return gauss_newton(problem, z, memory)
