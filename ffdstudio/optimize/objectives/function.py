"""A Python function as an objective."""

from __future__ import annotations

import importlib
import math
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.consent import Order, require
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request, Start
from ffdstudio.optimize.objectives.failures import EvaluationError, NotFinite
from ffdstudio.optimize.objectives.identity import module_files
from ffdstudio.optimize.objectives.stream import evaluated
from ffdstudio.optimize.spec.fields import Processes, Text, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape


class PythonFunction(Objective):
    """A function of the (n, 3) points.

    Parameters
    ----------
    function : callable or str
        Returns the cost, or (cost, (n, 3) gradient). As text "module:function", which lets
        finite differences run in processes of their own.
    processes : int
        Processes for finite differences; 1 stays in this one.

    Examples
    --------
    >>> area = PythonFunction(lambda points: float(np.ptp(points[:, 1])))
    >>> area.evaluate(np.array([[0.0, 1, 0], [0, 3, 0]]), gradient=False).value
    2.0
    """

    def __init__(
        self, function: Callable[[Array], Any] | str, gradient: bool = False, processes: int = 1
    ) -> None:
        self.function = named(function) if isinstance(function, str) else function
        self.name = function if isinstance(function, str) else None
        self.abilities = Abilities(gradient=gradient, batch=processes)
        if processes > 1 and self.name is None:
            raise InputError('several processes need a function by name, as "module:function"')

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        points = request.points
        return checked(_call(self.function, points), points, self.abilities.gradient)

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `Objective`: functions by name get processes, others are evaluated at once."""
        if self.abilities.batch == 1:
            with super().starting() as start:
                yield start
            return
        name, gradient = self.name or "", self.abilities.gradient
        with _spawned(self.abilities.batch) as pool:
            yield lambda request: pool.submit(_in_process, name, gradient, request.points)


def named(name: str) -> Callable[[Array], Any]:
    """Function by "module:function"."""
    module, colon, attribute = name.partition(":")
    try:
        function = getattr(importlib.import_module(module), attribute) if colon else None
    except (ImportError, AttributeError) as error:
        raise InputError(f"cannot import the function {name}: {error}") from error
    except SystemExit as end:
        raise InputError(f"{name}: its module called sys.exit({end.code!r})") from end
    except Exception as error:  # somebody else's module: whatever it may be
        cause = f"{type(error).__name__}: {error}"
        raise InputError(f"cannot import the function {name}: {cause}") from error
    if not callable(function):
        raise InputError(f'{name!r} must read "module:function"')
    result: Callable[[Array], Any] = function
    return result


def _call(function: Callable[[Array], Any], points: Array) -> Any:
    try:
        return function(points)
    except Exception as error:  # somebody else's code: anything may come out of it
        raise EvaluationError(f"the objective failed, {type(error).__name__}: {error}") from error


def checked(result: Any, points: Array, differentiable: bool) -> Evaluation:
    """Evaluation from what a function returned."""
    value, gradient = result if isinstance(result, tuple) else (result, None)
    try:
        if isinstance(value, bool | np.bool_ | str | bytes):
            raise TypeError
        number = float(value)
        rows = None if gradient is None else np.asarray(gradient, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise EvaluationError(f"the objective returned {value!r}, no number") from error
    if not math.isfinite(number):
        raise NotFinite(f"the objective returned {number}, no finite number")
    if differentiable and (rows is None or rows.shape != points.shape):
        raise EvaluationError(f"the objective must return a gradient of shape {points.shape}")
    if differentiable and rows is not None and not np.isfinite(rows).all():
        raise EvaluationError("the objective returned a gradient that is not finite")
    return Evaluation(number, rows if differentiable else None, flow=1, adjoint=int(differentiable))


@contextmanager
def _spawned(count: int) -> Iterator[Executor]:
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"))
    try:
        yield pool
    except BrokenProcessPool as error:
        raise EvaluationError("a process of the objective died") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _in_process(name: str, gradient: bool, points: Array) -> Evaluation:
    """What a spawned process does."""
    return evaluated(PythonFunction(name, gradient), Request(points, False))


class FunctionSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="function"):
    """Ask a Python function of the points, by finite differences if it gives no gradient."""

    title = "Ask a Python function"
    runs_code = True

    name: Annotated[
        Text, says("Function", "module:function; the module may lie beside the case file")
    ]
    gradient: Annotated[bool, says("Returns a gradient", "whether it returns (cost, gradient)")] = (
        False
    )
    processes: Annotated[
        Processes, says("Processes", "for finite differences")
    ] = 1  # fmt: skip

    def require(self, place: Place) -> None:
        """See `ObjectiveSpec`."""
        require(Order("function", (self.name,), place.source), place.consent)

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`; spawned processes look beside the case file too."""
        self.require(place)
        beside = str(place.beside.resolve())
        if beside not in sys.path:
            sys.path.append(beside)
        return PythonFunction(self.name, self.gradient, self.processes)

    def files(self, shape: Shape, place: Place) -> list[Path]:
        """See `ObjectiveSpec`."""
        return module_files(self.name)
