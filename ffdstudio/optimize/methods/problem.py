"""What a method sees of a study."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.ending import CONVERGED, STALLED, Ending

SMALL = 1e-4  # of the steepest gradient
ROUNDING = 1e-12  # of the cost: its values are no more exact


@dataclass
class Trial:
    """The cost at variables z.

    `gradient` is by the variables; `surface` is the (n, 3) derivative by the points that a
    quasi-Newton memory stores, if the objective has one. Residuals have their derivatives by
    the variables in `jacobian`, and by the points (those coordinates that move) in `by_points`.
    """

    z: Array
    value: float
    gradient: Array | None = None
    surface: Array | None = None
    residuals: Array | None = None
    jacobian: Array | None = None
    by_points: Any = None

    @property
    def slope(self) -> Array:
        """The gradient of a trial that was asked for with one."""
        assert self.gradient is not None
        return self.gradient


def parts(trial: Trial) -> tuple[Array, Array]:
    """Residuals of a trial and their derivatives by the variables.

    Raises
    ------
    InputError
        If the objective has none.
    """
    if trial.residuals is None or trial.jacobian is None:
        raise InputError("this method needs an objective with residuals: use lbfgs or slsqp")
    return trial.residuals, trial.jacobian


@dataclass
class Memory:
    """Pairs of a quasi-Newton method, and conjugate directions; both outlive a refinement.

    A pair is the step and the differences of the gradient: by the variables, and on the
    surface, from where they carry over into any finer space exactly. `scale` turns a gradient
    into a step for methods that begin each level with a unit Hessian; `steepest` is the largest
    gradient and `highest` the largest cost that a level has begun with, `fall` what the last
    round of conjugate directions has gained.
    """

    pairs: list[tuple[Array, Array, Array | None]] = field(default_factory=list)
    directions: Array | None = None
    curvatures: Array | None = None
    scale: float | None = None
    steepest: float = 0.0
    highest: float = -np.inf
    fall: float = np.inf

    def begin(self, start: Trial) -> None:
        """Note the cost and the gradient that a level begins with."""
        self.highest = max(self.highest, start.value)
        if start.gradient is not None:
            self.steepest = max(self.steepest, float(np.linalg.norm(start.gradient)))

    def reference_decrease(self, value: float) -> float:
        """What a decrease of the cost is compared with, see `reference_decrease`."""
        return reference_decrease(value, self.highest)


class Problem(Protocol):
    """Variables and a cost; constraints are the matter of `slsqp` alone."""

    @property
    def size(self) -> int:
        """Number of variables."""
        ...

    def value(self, z: Array) -> Trial:
        """Cost alone."""
        ...

    def gradient(self, z: Array) -> Trial:
        """Cost and gradient."""
        ...

    def residuals(self, z: Array) -> Trial:
        """Cost with residuals and their derivatives by the variables."""
        ...

    @property
    def extent(self) -> float:
        """Length of the surface that nothing is small against."""
        ...

    def displacement_cost(self, trial: Trial) -> Array | None:
        """(k, size) factor C of what displacements cost, |C z|^2; None if residuals fix them."""
        ...

    def control_cost(self, trial: Trial) -> tuple[Array, Array] | None:
        """(k, size) rows and (k,) values at z = 0 of what control points that move cost.

        Mild: where the cost does not need them. None if the lattice carries no mesh.
        """
        ...

    def longest(self, direction: Array) -> float:
        """Multiple of a direction that moves the surface as far as a first step may.

        Infinite for a direction that moves nothing.
        """
        ...

    def reach(self, z: Array, step: Array) -> float:
        """Share of a step that leaves the cells of meshes that follow valid, at most 1."""
        ...

    def report(self, trial: Trial) -> None:
        """Hear of an iterate; may raise to end the method."""
        ...


def reference_decrease(value: float, first: float) -> float:
    """What a decrease of a cost is compared with.

    The cost itself, or the decrease since the beginning if that is less: a cost may be negative
    or far from zero at its least, drag or minus the lift for example.
    """
    return min(abs(value), max(first - value, 0.0))


def ended(problem: Problem, here: Trial, memory: Memory) -> Ending:
    """Why a method ends that finds no step that makes the cost less: a small gradient, or none.

    The gradient is small beside the steepest that the study has met, or if a first move along
    it would change the cost by no more than the rounding of its values.
    """
    size = float(np.linalg.norm(here.slope))
    move = problem.longest(here.slope) * size**2 if size else 0.0
    small = size <= SMALL * memory.steepest or move <= ROUNDING * abs(here.value)
    return CONVERGED if small else STALLED


def carried_directions(memory: Memory, matrix: Array) -> tuple[Array | None, Array | None]:
    """Conjugate directions in a finer space: first the new ones, then those known.

    In orthonormal variables the complement of the old space is conjugate to it as far as the
    metric resembles the Hessian; its curvatures are guessed to be the usual one.
    """
    if memory.directions is None or memory.curvatures is None:
        return None, None
    new = np.linalg.qr(matrix, mode="complete")[0][:, matrix.shape[1] :]
    known = memory.directions @ matrix.T
    known /= np.linalg.norm(known, axis=1)[:, None]
    usual = float(np.median(memory.curvatures))
    curvatures = np.concatenate([np.full(new.shape[1], usual), memory.curvatures])
    return np.vstack([new.T, known])[: len(matrix)], curvatures[: len(matrix)]
