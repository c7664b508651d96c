"""Fits by the largest residual: linear programs with the residuals made linear.

The step is cut where that fails, so the largest residual never rises.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.ending import CONVERGED, STALLED, Ending
from ffdstudio.optimize.methods.base import MethodSpec, Trigger
from ffdstudio.optimize.methods.problem import Memory, Problem, Trial, parts

SMALL = 1e-4  # a share of the largest residual that is not worth another step
ROUNDING = 1e-12  # the same of the first one: the residuals mean nothing any more


def minimax(problem: Problem, z: Array, memory: Memory) -> Ending:
    """Make the largest residual small: a linear program for each step."""
    here = problem.residuals(z)
    if not np.isfinite(here.value):
        return STALLED
    least = ROUNDING * largest(here)
    while True:
        residuals, jacobian = parts(here)
        step, expected = _program(residuals, jacobian)
        found = _shortened(problem, here, step)
        if found is None:
            return CONVERGED if largest(here) <= (1 + SMALL) * expected + least else STALLED
        gained, here = largest(here) - largest(found), found
        problem.report(here)
        if gained <= SMALL * largest(here) or largest(here) <= (1 + SMALL) * expected:
            return CONVERGED


def largest(trial: Trial) -> float:
    """Largest size of a residual."""
    return float(np.abs(parts(trial)[0]).max())


def _program(residuals: Array, jacobian: Array) -> tuple[Array, float]:
    """Step with the least t such that |residuals + jacobian step| <= t, and t."""
    from scipy.optimize import linprog

    count, size = jacobian.shape
    scale = np.abs(residuals).max() or 1.0
    ones = np.ones((count, 1))
    upper = np.block([[jacobian, -ones], [-jacobian, -ones]])
    bounds = [(None, None)] * size + [(0, None)]
    cost = np.concatenate([np.zeros(size), [1.0]])
    right = np.concatenate([-residuals, residuals]) / scale
    found = linprog(cost, A_ub=upper, b_ub=right, bounds=bounds, method="highs")
    if found.x is None:
        return np.zeros(size), float(scale)
    return scale * found.x[:-1], scale * float(found.x[-1])


def _shortened(problem: Problem, here: Trial, step: Array) -> Trial | None:
    trial = problem.residuals(here.z + step)
    if not np.isfinite(trial.value):  # cells inside out: as far as they allow
        step = problem.reach(here.z, step) * step
    for fraction in (1.0, 0.5, 0.25, 0.1, 0.02):
        trial = problem.residuals(here.z + fraction * step)
        if np.isfinite(trial.value) and largest(trial) < largest(here):
            return trial
    return None


class Minimax(MethodSpec, frozen=True, tag="minimax"):
    """Linear programs that make the largest residual small: for distances, without constraints."""

    title = "Least largest error"
    residuals = True
    largest = True
    trigger = Trigger()

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return minimax(problem, z, memory)
