"""Conjugate directions (Powell 1964), the method of the paper: no gradients.

1. The first directions are the variables themselves. With metric-orthonormal variables they are
   nearly conjugate from the start.
2. Each direction remembers its curvature. With it, one trial gives the slope, and one more the
   value at the least point of the parabola: two evaluations a line instead of three or more.
   The trial is sized by what the last round has gained, for a cost need not end near zero.
3. After a round the total step replaces the direction of the largest decrease, by Powell's
   criterion that keeps the set from becoming dependent (Brent 1973, chapter 7).
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.ending import CONVERGED, Ending
from ffdstudio.optimize.methods.base import MethodSpec, Trigger
from ffdstudio.optimize.methods.problem import Memory, Problem, Trial

SHORTENED = 8  # times that a step is cut where the cost is no number
SEEN = 1e-9  # of the cost: changes that rounding does not hide


def conjugate_directions(problem: Problem, z: Array, memory: Memory) -> Ending:
    """Minimise by lines along a set of directions that becomes conjugate."""
    here = problem.value(z)
    memory.begin(here)
    if memory.directions is None or memory.curvatures is None:
        memory.directions, memory.curvatures = np.eye(problem.size), np.zeros(problem.size)
    directions, curvatures = memory.directions, memory.curvatures
    while True:
        start, largest, which = here, 0.0, 0
        for k in range(problem.size):
            before = here.value
            size = curvatures[k], memory.fall
            here, curvatures[k] = least_on_line(problem, here, directions[k], *size)
            if before - here.value > largest:
                largest, which = before - here.value, k
        memory.fall = start.value - here.value
        if memory.fall <= 1e-8 * memory.reference_decrease(start.value):
            return CONVERGED
        here = _extend(problem, start, here, largest, which, memory)
        problem.report(here)


def _extend(
    problem: Problem,
    start: Trial,
    here: Trial,
    largest: float,
    which: int,
    memory: Memory,
) -> Trial:
    """Try the total step of a round as a direction."""
    directions, curvatures = memory.directions, memory.curvatures
    assert directions is not None
    assert curvatures is not None
    total = here.z - start.z
    length = float(np.linalg.norm(total))
    beyond = problem.value(here.z + total)
    if beyond.value >= start.value:
        return here
    fall = start.value - here.value - largest
    bend = start.value - 2 * here.value + beyond.value
    if 2 * bend * fall**2 >= largest * (start.value - beyond.value) ** 2:
        return beyond if beyond.value < here.value else here
    here, curvature = least_on_line(problem, here, total / length, bend / length**2, memory.fall)
    directions[which], directions[-1] = directions[-1].copy(), total / length
    curvatures[which], curvatures[-1] = curvatures[-1], curvature
    return here


def least_on_line(
    problem: Problem, here: Trial, direction: Array, curvature: float, fall: float
) -> tuple[Trial, float]:
    """Least point along a direction by parabolas; also the curvature that was found."""
    step, first = _first_trial(problem, here, direction, curvature, fall)
    if step == 0:
        return here, curvature
    known = [(0.0, here), (step, first)]
    if curvature <= 0:
        t = 2 * step if first.value < here.value else -step
        second = problem.value(here.z + t * direction)
        if not np.isfinite(second.value):
            return min(here, first, key=lambda trial: trial.value), 0.0
        known.append((t, second))
        curvature = _curvature(known)
    best = min((trial for _, trial in known), key=lambda trial: trial.value)
    if curvature <= 0:
        return best, 0.0
    slope = (first.value - here.value) / step - 0.5 * curvature * step
    fall = 0.5 * slope**2 / curvature
    if best.value - (here.value - fall) <= 1e-3 * fall:
        return best, curvature  # not worth another evaluation
    least = -slope / curvature
    trial = problem.value(here.z + least * direction)
    if not np.isfinite(trial.value):
        return best, curvature
    if abs(trial.value - (here.value - fall)) > 0.1 * fall:  # the parabola was wrong
        better = _curvature([(0.0, here), (step, first), (least, trial)])
        curvature = better if better > 0 else curvature
    return min(best, trial, key=lambda trial: trial.value), curvature


def _curvature(known: list[tuple[float, Trial]]) -> float:
    """Second derivative of the parabola through three points, the first at 0."""
    (_, start), (a, at_a), (b, at_b) = known
    slopes = (at_a.value - start.value) / a, (at_b.value - start.value) / b
    return 2 * (slopes[1] - slopes[0]) / (b - a) if a != b else 0.0


def _first_trial(
    problem: Problem, here: Trial, direction: Array, curvature: float, fall: float
) -> tuple[float, Trial]:
    """A step and its trial, shortened until the cost is a number; 0 if it never is."""
    step = _first_step(problem, here, direction, curvature, fall)
    for _ in range(SHORTENED if np.isfinite(step) else 0):
        first = problem.value(here.z + step * direction)
        if np.isfinite(first.value):
            return step, first
        step *= 0.25
    return 0.0, here


def _first_step(
    problem: Problem, here: Trial, direction: Array, curvature: float, fall: float
) -> float:
    """Step that would change the cost by a hundredth, or a small move of the surface.

    A hundredth of the cost, or of what the last round has gained if that is less; but no less
    than what the rounding of the cost lets be seen.
    """
    most = 0.1 * problem.longest(direction)
    if curvature <= 0:
        return most
    left = max(min(abs(here.value), fall), SEEN * abs(here.value), 1e-300)
    return min(most, float(np.sqrt(0.02 * left / curvature)))


class Powell(MethodSpec, frozen=True, tag="powell"):
    """Conjugate directions, the method of the paper: no gradients."""

    title = "Conjugate directions (Powell)"
    trigger = Trigger(iterations=1)

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return conjugate_directions(problem, z, memory)
