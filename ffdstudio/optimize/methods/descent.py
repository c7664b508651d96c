"""Gradient methods: limited-memory BFGS and conjugate gradients."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.ending import CONVERGED, Ending
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.methods.line_search import search
from ffdstudio.optimize.methods.problem import Memory, Problem, Trial, ended

DEPTH = 40  # pairs
STILL = 1e-9  # of the cost or its decrease so far: an iteration that gains less is the last


def lbfgs(problem: Problem, z: Array, memory: Memory) -> Ending:
    """L-BFGS (Nocedal 1980; Nocedal and Wright, algorithm 7.4), from whatever memory there is."""
    here = problem.gradient(z)
    memory.begin(here)
    while here.slope.any():
        direction = -_times_inverse(here.slope, memory)
        if not direction @ here.slope < 0:
            memory.pairs.clear()
            direction = -here.slope
        first = 1.0 if memory.pairs else min(1.0, problem.longest(direction))
        found = search(problem, here, direction, first)
        if found is None and memory.pairs:
            memory.pairs.clear()
            continue
        if found is None:
            return ended(problem, here, memory)
        _remember(memory, here, found)
        gained, here = here.value - found.value, found
        problem.report(here)
        if gained <= STILL * memory.reference_decrease(here.value):
            return CONVERGED
    return CONVERGED


def _times_inverse(gradient: Array, memory: Memory) -> Array:
    """Two loops over the pairs: the inverse Hessian's estimate times the gradient."""
    q, shares = gradient.copy(), []
    for s, y, _ in reversed(memory.pairs):
        share = (s @ q) / (s @ y)
        shares.append(share)
        q -= share * y
    if memory.pairs:
        s, y, _ = memory.pairs[-1]
        q *= (s @ y) / (y @ y)
    for (s, y, _), share in zip(memory.pairs, reversed(shares), strict=True):
        q += (share - (y @ q) / (s @ y)) * s
    return q


def _remember(memory: Memory, old: Trial, new: Trial) -> None:
    s, y = new.z - old.z, new.slope - old.slope
    if s @ y > 1e-10 * np.linalg.norm(s) * np.linalg.norm(y):
        surface = None
        if new.surface is not None and old.surface is not None:
            surface = new.surface - old.surface
        memory.pairs.append((s, y, surface))
        del memory.pairs[:-DEPTH]


def conjugate_gradients(problem: Problem, z: Array, memory: Memory) -> Ending:
    """Non-linear conjugate gradients (Polak and Ribiere, restarted when beta < 0)."""
    here = problem.gradient(z)
    memory.begin(here)
    direction, step, steepest = -here.slope, 0.0, True
    while here.slope.any():
        first = step or min(1.0, problem.longest(direction))
        found = search(problem, here, direction, first, curvature=0.1)
        if found is None and not steepest:
            direction, step, steepest = -here.slope, 0.0, True
            continue
        if found is None:
            return ended(problem, here, memory)
        taken = np.linalg.norm(found.z - here.z) / np.linalg.norm(direction)
        gained, change = here.value - found.value, found.slope - here.slope
        beta = max(0.0, float(found.slope @ change) / float(here.slope @ here.slope))
        following = -found.slope + beta * direction
        slope = float(here.slope @ direction)
        here = found
        problem.report(here)
        if gained <= STILL * memory.reference_decrease(here.value):
            return CONVERGED
        steepest = not following @ here.slope < 0
        if steepest:
            following = -here.slope
        # the next step is expected to lower the cost as the last one did
        step = float(taken) * slope / float(here.slope @ following)
        direction = following
    return CONVERGED


class Lbfgs(MethodSpec, frozen=True, tag="lbfgs"):
    """Limited-memory BFGS: for costs with a gradient."""

    title = "L-BFGS"

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return lbfgs(problem, z, memory)


class ConjugateGradients(MethodSpec, frozen=True, tag="cg"):
    """Non-linear conjugate gradients (Polak and Ribiere)."""

    title = "Conjugate gradients"

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return conjugate_gradients(problem, z, memory)
