"""Fits: Gauss-Newton for the least squares of residuals, linear programs for their largest.

Both solve for the step with the residuals made linear; the step is cut where that fails, so
the cost never rises. Small singular values are cut off: the rank guard.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ffdstudio.optimize.methods.problem import Array, Memory, Problem, Trial, parts

RANK = 1e-10


def gauss_newton(problem: Problem, z: Array, memory: Memory) -> None:
    """Gauss-Newton with a rank-revealing solve."""
    here = problem.residuals(z)
    while True:
        residuals, jacobian = parts(here)
        step = np.asarray(np.linalg.lstsq(jacobian, -residuals, rcond=RANK)[0], dtype=np.float64)
        expected = 0.5 * float(residuals @ residuals - np.sum((residuals + jacobian @ step) ** 2))
        found = _shortened(problem, here, step, lambda trial: trial.value)
        if found is None:
            return
        gained, here = here.value - found.value, found
        problem.report(here)
        if expected <= 1e-4 * here.value or gained <= 1e-6 * here.value:
            return


def minimax(problem: Problem, z: Array, memory: Memory) -> None:
    """Make the largest residual small: a linear program for each step."""
    here = problem.residuals(z)
    while True:
        residuals, jacobian = parts(here)
        step, expected = _program(residuals, jacobian)
        found = _shortened(problem, here, step, largest)
        if found is None:
            return
        gained, here = largest(here) - largest(found), found
        problem.report(here)
        if gained <= 1e-4 * largest(here) or largest(here) <= (1 + 1e-4) * expected:
            return


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


def _shortened(
    problem: Problem, here: Trial, step: Array, measure: Callable[[Trial], float]
) -> Trial | None:
    for fraction in (1.0, 0.5, 0.25, 0.1, 0.02):
        trial = problem.residuals(here.z + fraction * step)
        if measure(trial) < measure(here):
            return trial
    return None
