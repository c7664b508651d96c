"""The protocol of objectives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Evaluation:
    """What an objective says about a shape.

    Attributes
    ----------
    value : float
        The cost.
    gradient : numpy.ndarray, optional
        (n, 3) derivative of the cost by the coordinates of the points.
    residuals : numpy.ndarray, optional
        (m,) with cost = |residuals|^2 / 2, for Gauss-Newton methods.
    sensitivity : scipy.sparse array, optional
        (m, 3 n) derivative of the residuals by the coordinates.
    flow, adjoint : int
        Solves that were spent.
    measures : dict
        Further numbers for the record (lift, moment, ...).
    """

    value: float
    gradient: Array | None = None
    residuals: Array | None = None
    sensitivity: Any = None
    flow: int = 0
    adjoint: int = 0
    measures: dict[str, float] = field(default_factory=dict)


class Objective(Protocol):
    """Anything with a value for points, and its gradient if it can.

    `differentiable` says whether gradients come; without, finite differences over the design
    variables take their place.
    """

    differentiable: bool

    def evaluate(self, points: Array, gradient: bool = True) -> Evaluation:
        """Evaluate at (n, 3) points; with `gradient` also what derives from it."""
        ...


@runtime_checkable
class TakesVariables(Protocol):
    """An objective that is told the design variables before an evaluation.

    None stands for a shape that the variables cannot describe: a refinement asks what new
    control points would bring.
    """

    variables: list[float] | None


@runtime_checkable
class Stoppable(Protocol):
    """An objective that takes its time, and looks in between whether the study is stopped."""

    stopped: Callable[[], bool]
