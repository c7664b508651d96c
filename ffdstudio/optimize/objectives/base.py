"""What every objective is: asked for shapes, it says what they cost and what it can do besides.

1. What an objective can do is declared (`Abilities`); nobody looks for methods it may have.
2. All that an evaluation needs comes with the `Request`, so that an objective has no state of
   the study, and a wrapper changes the request, asks what it wraps and changes the answer.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ffdstudio.aliases import Array


def never() -> bool:
    """Nobody stops the study."""
    return False


@dataclass(frozen=True)
class Abilities:
    """What an objective can do.

    Attributes
    ----------
    gradient : bool
        Whether gradients come; without, finite differences over the design variables do.
    residuals : bool
        Whether the cost is half a sum of squares whose parts come too.
    batch : int
        Evaluations that pay at the same time.
    angles : tuple of float
        Angles of attack, in degrees, of the flows that it solves.
    response : bool
        Whether it can tell how its flow answers to the points.
    """

    gradient: bool = True
    residuals: bool = False
    batch: int = 1
    angles: tuple[float, ...] = ()
    response: bool = False


class Request(NamedTuple):
    """A shape to be evaluated.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3).
    gradient : bool
        Whether its derivatives are wanted, of an objective that has them.
    variables : list of float or None
        Design variables; None if they cannot describe the shape: a refinement asks what new
        control points would bring.
    stopped : callable
        Whether the study is stopped; an objective that takes its time asks in between.
    """

    points: Array
    gradient: bool = True
    variables: list[float] | None = None
    stopped: Callable[[], bool] = never


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


class Response(NamedTuple):
    """How what an objective looks at answers to the points, whatever its target is.

    Attributes
    ----------
    matrix : numpy.ndarray or scipy.sparse array
        (m, 3 n) derivative by the coordinates of the points.
    solves : int
        What it has cost, in solves of the flow.
    """

    matrix: Any
    solves: int


Start = Callable[[Request], "Future[Evaluation]"]


class Objective(ABC):
    """Anything with a value for points."""

    abilities: Abilities = Abilities()

    @abstractmethod
    def answer(self, request: Request) -> Evaluation:
        """Evaluate a shape."""

    def evaluate(self, points: Array, gradient: bool = True) -> Evaluation:
        """Evaluate (n, 3) points; with `gradient` also what derives from it."""
        return self.answer(Request(points, gradient))

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """Function that begins an evaluation; leaving by an exception ends all of them.

        By default an evaluation is made at once.
        """
        from ffdstudio.optimize.objectives.stream import at_once

        yield lambda request: at_once(self, request)

    def response(self, points: Array) -> Response | None:
        """How the flow answers to the points, for the metric of that name; None if untold."""
        return None

    def pressures(self, points: Array) -> Mapping[str, Mapping[str, tuple[Array, Array]]]:
        """Pressure curves (x, Cp) by their name, of each flow by its name, for plots."""
        return {}
