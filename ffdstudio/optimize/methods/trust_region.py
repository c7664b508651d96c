"""A trust-region interior-point method (SciPy's trust-constr: Byrd, Hribar and Nocedal 1999).

1. Each iteration minimises a quadratic model within a region that grows where the model is right.
   It needs more evaluations than SLSQP, and stands costs whose gradient is not exact.
2. The cost is scaled so that the first step moves the surface as far as a first step may, and the
   first radius is that step: whitened variables have the same curvature on all levels.
3. It is ended when the cost has stood still for some iterations; as of `slsqp`, see there.
"""

from __future__ import annotations

import contextlib
from functools import partial
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Relation
from ffdstudio.optimize.ending import CONVERGED, STALLED, Ending
from ffdstudio.optimize.methods.base import MethodSpec, Trigger
from ffdstudio.optimize.methods.problem import Memory, Problem

PATIENCE, STILL = 6, 1e-7
MOST = 500
MET = 1e-8  # violation at which a shape counts as allowed


class _Still(Exception):
    """The cost does not change any more."""


def trust_region(problem: Problem, z: Array, memory: Memory) -> Ending:
    """Minimise under the problem's constraints."""
    from scipy.optimize import BFGS, minimize

    start = problem.gradient(z)
    memory.begin(start)
    if memory.scale is None and start.slope.any():
        memory.scale = problem.longest(start.slope)
    scale = memory.scale or 1.0
    radius = scale * float(np.linalg.norm(start.slope)) or 1.0
    seen = [start.value]

    def report(x: Array, state: Any) -> None:
        trial = problem.gradient(np.array(x))
        problem.report(trial)
        seen.append(trial.value)
        last = seen[-PATIENCE:]
        allowed = state.constr_violation <= MET
        if (
            allowed
            and len(last) == PATIENCE
            and np.ptp(last) <= STILL * memory.reference_decrease(trial.value)
        ):
            raise _Still

    solve: Any = minimize  # its stubs know no scaled functions
    with contextlib.suppress(_Still):
        found = solve(
            lambda x: scale * problem.gradient(x).value,
            z,
            jac=lambda x: scale * problem.gradient(x).slope,
            hess=BFGS(),
            method="trust-constr",
            constraints=_constraints(problem),
            callback=report,
            options={"maxiter": MOST, "initial_tr_radius": radius, "gtol": 1e-9, "xtol": 1e-10},
        )
        return CONVERGED if found.status in (1, 2) else STALLED
    return CONVERGED


def _constraints(problem: Any) -> list[Any]:
    from scipy.optimize import BFGS, NonlinearConstraint

    parts = []
    for kind in Relation:
        if problem.constraint_count(kind):
            value, slope = partial(_part, problem, kind, 0), partial(_part, problem, kind, 1)
            upper = 0.0 if kind is Relation.EQUAL else np.inf
            parts.append(NonlinearConstraint(value, 0.0, upper, jac=slope, hess=BFGS()))
    return parts


def _part(problem: Any, kind: Relation, part: int, x: Array) -> Array:
    """Slacks of a kind of constraint, or their derivatives."""
    found: Array = problem.constraints(x, kind)[part]
    return found


class TrustRegion(MethodSpec, frozen=True, tag="trust-region"):
    """Interior points within a trust region, which keeps constraints; patient with rough costs."""

    title = "Trust region (constraints)"
    constraints = True
    trigger = Trigger(slope=0.7)

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """See `MethodSpec`."""
        return trust_region(problem, z, memory)
