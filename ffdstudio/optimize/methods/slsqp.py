"""Sequential quadratic programming for constrained costs (SciPy's SLSQP, by Kraft 1988).

1. SciPy asks for value, gradient and constraints in separate calls: the problem remembers the
   last trial, so that each point is evaluated once.
2. SLSQP begins with a unit Hessian. The cost is scaled so that its first step moves the surface
   as far as a first step may, and keeps that scale on finer levels: whitened variables have the
   same curvature there.
3. Its own test of convergence hopes for more than a cost with a kink can give: it is ended when
   the cost has stood still for some iterations.
4. A box keeps the quadratic programs from proposing shapes that fold over. An end that lies on
   it is no solution of the problem, and told.
"""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Relation
from ffdstudio.optimize.ending import CONVERGED, Ending, Reason
from ffdstudio.optimize.methods.base import MethodSpec, Trigger
from ffdstudio.optimize.methods.problem import Memory, Problem, Trial

PATIENCE, STILL = 6, 1e-7
MUCH = 1e6
FARTHEST = 5.0  # first moves in each variable


class _Still(Exception):
    """The cost does not change any more."""


def slsqp(problem: Problem, z: Array, memory: Memory) -> Ending:
    """Minimise under the problem's constraints."""
    from scipy.optimize import minimize

    start = problem.gradient(z)
    memory.begin(start)
    if memory.scale is None and start.slope.any():
        memory.scale = problem.longest(start.slope)
    scale = memory.scale or 1.0
    size = min(abs(start.value), scale * memory.steepest**2)  # what a first step may hope for
    reach = np.array([FARTHEST * problem.longest(e) for e in np.eye(problem.size)])
    worst = start.value + MUCH * max(abs(start.value), 1.0)  # SciPy cannot go back from infinity
    seen: list[Trial] = [start]

    def report(x: Array) -> None:
        trial = problem.gradient(np.array(x))
        if not np.isfinite(trial.value):  # SciPy goes on from there, nobody else does
            return
        problem.report(trial)
        seen.append(trial)
        last = [trial.value for trial in seen[1:][-PATIENCE:]]
        still = STILL * memory.reference_decrease(trial.value)
        if len(last) == PATIENCE and max(last) - min(last) <= still:
            raise _Still

    solve: Any = minimize  # its stubs know no scaled functions
    ended = CONVERGED
    with contextlib.suppress(_Still):
        found = solve(
            lambda x: scale * min(problem.gradient(x).value, worst),
            z,
            jac=lambda x: scale * problem.gradient(x).slope,
            method="SLSQP",
            bounds=list(zip(z - reach, z + reach, strict=True)),
            constraints=_constraints(problem),
            callback=report,
            options={"maxiter": 500, "ftol": 1e-9 * scale * max(size, 1e-12)},
        )
        ended = CONVERGED
        if not found.success:
            ended = Ending(Reason.STALLED, _words(found.message))
    reached = seen[-1].z
    if (np.abs(reached - z) >= (1 - 1e-6) * reach).any():
        return Ending(Reason.STALLED, "the shape has moved as far as one level of slsqp may")
    return ended


def _words(message: str) -> str:
    """SciPy's message as the end of a sentence."""
    return message.strip().rstrip(".").lower()


def _constraints(problem: Any) -> list[dict[str, Any]]:
    parts: list[dict[str, Any]] = []
    for kind in Relation:
        if problem.constraint_count(kind):
            parts.append(
                {
                    "type": kind.value,
                    "fun": lambda x, k=kind: problem.constraints(x, k)[0],
                    "jac": lambda x, k=kind: problem.constraints(x, k)[1],
                }
            )
    return parts


class Slsqp(MethodSpec, frozen=True, tag="slsqp"):
    """Sequential quadratic programming, which keeps constraints."""

    title = "SLSQP (constraints)"
    constraints = True
    trigger = Trigger(slope=0.7)

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return slsqp(problem, z, memory)
