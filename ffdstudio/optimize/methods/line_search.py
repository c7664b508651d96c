"""A line search for the strong Wolfe conditions (Nocedal and Wright, algorithms 3.5 and 3.6)."""

from __future__ import annotations

import math

from ffdstudio.aliases import Array
from ffdstudio.optimize.methods.problem import Problem, Trial

SUFFICIENT = 1e-4


def search(
    problem: Problem, start: Trial, direction: Array, step: float, curvature: float = 0.9
) -> Trial | None:
    """Trial along a direction that satisfies the conditions, or the best one found.

    None if no step makes the cost smaller: the gradient is at its rounding.
    """
    slope0 = float(start.slope @ direction)
    if not slope0 < 0:
        return None
    low, at_low, high, best, limit = 0.0, start, None, start, math.inf
    for _ in range(20):
        trial = problem.gradient(start.z + step * direction)
        if not math.isfinite(trial.value):  # cells inside out, or a solver that gave up
            limit = step = _shorter(problem, start, direction, low, step, step < limit)
            continue
        slope = float(trial.slope @ direction)
        if trial.value < best.value:
            best = trial
        sufficient = trial.value <= start.value + SUFFICIENT * step * slope0
        if not sufficient or trial.value >= at_low.value:
            high, at_high = step, trial
        elif abs(slope) <= -curvature * slope0:
            return trial
        else:
            if high is None and slope < 0 and step >= limit:
                return trial
            if high is None and slope < 0:
                following = _beyond(low, at_low, step, trial, direction)
                low, at_low, step = step, trial, min(following, limit)
                continue
            if high is None or slope * (high - low) >= 0:
                high, at_high = low, at_low
            low, at_low = step, trial
        if abs(high - low) <= 1e-12 * max(abs(high), abs(low)):
            break
        step = _between(low, at_low, high, at_high, direction)
    return best if best is not start else None


def _shorter(
    problem: Problem, start: Trial, direction: Array, low: float, step: float, first: bool
) -> float:
    """Step before which a trial has no value: as far as cells allow, or half the way."""
    share = problem.reach(start.z + low * direction, (step - low) * direction) if first else 1.0
    return low + (share if share < 1 else 0.5) * (step - low)


def _between(a: float, at_a: Trial, b: float, at_b: Trial, direction: Array) -> float:
    """Least point of the cubic between a and b, kept off the ends."""
    new = _cubic(a, at_a, b, at_b, direction)
    least, most = sorted((a + 0.1 * (b - a), a + 0.9 * (b - a)))
    return min(max(new, least), most) if math.isfinite(new) else 0.5 * (a + b)


def _beyond(a: float, at_a: Trial, b: float, at_b: Trial, direction: Array) -> float:
    """Least point of the cubic past b, at most four times as far."""
    new = _cubic(a, at_a, b, at_b, direction)
    least, most = b + 0.1 * (b - a), b + 4.0 * (b - a)
    return min(max(new, least), most) if math.isfinite(new) and new > b else most


def _cubic(a: float, at_a: Trial, b: float, at_b: Trial, direction: Array) -> float:
    """Least point of the cubic through values and slopes at a and b, NaN if there is none."""
    slope_a, slope_b = float(at_a.slope @ direction), float(at_b.slope @ direction)
    d1 = slope_a + slope_b - 3 * (at_a.value - at_b.value) / (a - b)
    square = d1 * d1 - slope_a * slope_b
    if square < 0:
        return math.nan
    d2 = math.copysign(math.sqrt(square), b - a)
    below = slope_b - slope_a + 2 * d2
    return b - (b - a) * (slope_b + d2 - d1) / below if below else math.nan
