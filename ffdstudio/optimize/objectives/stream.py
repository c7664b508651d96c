"""Many evaluations, a few at a time: what finite differences need.

1. A shape is made when there is room for it, so that neither memory nor the disk holds a mesh
   for each variable.
2. Results come in the order of the shapes, whichever ends first: a study stays deterministic.
3. When one fails, those that run beside it end and count before the failure is told; nothing
   that was paid for is lost.
4. A stop ends what runs at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from typing import Any, NamedTuple, Protocol, runtime_checkable

from ffdstudio.optimize.control import Stopped
from ffdstudio.optimize.objectives.base import (
    Array,
    Evaluation,
    Objective,
    Stoppable,
    TakesVariables,
)
from ffdstudio.optimize.objectives.process import POLL
from ffdstudio.optimize.objectives.remembered import EvaluationError


class Job(NamedTuple):
    """A shape to be evaluated without its gradient.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3).
    variables : list of float or None
        Design variables; None if they cannot describe the shape.
    """

    points: Array
    variables: list[float] | None


Start = Callable[[Job], "Future[Evaluation]"]
Waiting = deque[tuple[Job, "Future[Evaluation]"]]


@runtime_checkable
class Concurrent(Protocol):
    """An objective that can begin an evaluation and go on."""

    def starting(self) -> AbstractContextManager[Start]:
        """Function that begins an evaluation; leaving by an exception ends all of them."""
        ...


def streamed(
    objective: Objective, jobs: Iterable[Job]
) -> Generator[tuple[Job, Evaluation], None, None]:
    """Evaluate jobs, as many at the same time as the objective's `processes`.

    Raises
    ------
    EvaluationError
        If one fails, after those that ran beside it.
    Stopped
        If the study is stopped.
    """
    count = max(1, getattr(objective, "processes", 1))
    stopped = objective.stopped if isinstance(objective, Stoppable) else _never
    waiting: Waiting = deque()
    with starting(objective) as start:
        for job in jobs:
            while _running(waiting) >= count or len(waiting) >= 2 * count:
                _await(waiting, stopped)
                yield from _ready(waiting, stopped)
            if stopped():
                raise Stopped
            waiting.append((job, start(job)))
            yield from _ready(waiting, stopped)
        yield from _drained(waiting, stopped)


def _never() -> bool:
    return False


def _running(waiting: Waiting) -> int:
    return sum(not future.done() for _, future in waiting)


def _await(waiting: Waiting, stopped: Callable[[], bool]) -> None:
    """Wait until the first of the line, or any that runs, has ended."""
    running = [future for _, future in waiting if not future.done()]
    while running and not wait(running, POLL, FIRST_COMPLETED).done:
        if stopped():
            raise Stopped


def _ready(waiting: Waiting, stopped: Callable[[], bool]) -> Iterator[tuple[Job, Evaluation]]:
    while waiting and waiting[0][1].done():
        if waiting[0][1].exception() is not None:
            yield from _drained(waiting, stopped)  # raises
            return
        job, future = waiting.popleft()
        yield job, future.result()


def _drained(waiting: Waiting, stopped: Callable[[], bool]) -> Iterator[tuple[Job, Evaluation]]:
    """All that were begun; the first failure is raised behind them, see 3."""
    failure: EvaluationError | None = None
    while waiting:
        while not waiting[0][1].done():
            _await(waiting, stopped)
        job, future = waiting.popleft()
        try:
            found = future.result()
        except EvaluationError as error:
            failure = failure or error
            continue
        yield job, found
    if failure is not None:
        raise failure


# ---- how evaluations are begun -------------------------------------------------------------


@contextmanager
def starting(objective: Objective) -> Iterator[Start]:
    """See `Concurrent`; functions by name get processes, all others are evaluated at once."""
    from ffdstudio.optimize.objectives.function import PythonFunction

    if isinstance(objective, Concurrent):
        with objective.starting() as start:
            yield start
    elif isinstance(objective, PythonFunction) and objective.processes > 1:
        with _spawned(objective) as start:
            yield start
    else:
        yield lambda job: _at_once(objective, job)


def _at_once(objective: Objective, job: Job) -> Future[Evaluation]:
    future: Future[Evaluation] = Future()
    if isinstance(objective, TakesVariables):
        objective.variables = job.variables
    try:
        future.set_result(evaluated(objective, job.points, False))
    except EvaluationError as error:
        future.set_exception(error)
    return future


def evaluated(objective: Objective, points: Array, gradient: bool) -> Evaluation:
    """Evaluate; a function that ends Python, as scripts do, has failed."""
    try:
        return objective.evaluate(points, gradient)
    except SystemExit as end:
        raise EvaluationError(f"the objective called sys.exit({end.code!r})") from end


@contextmanager
def _spawned(function: Any) -> Iterator[Start]:
    from multiprocessing import get_context

    pool: Executor = ProcessPoolExecutor(function.processes, mp_context=get_context("spawn"))
    try:
        yield lambda job: pool.submit(_named, function.name, function.differentiable, job.points)
    except BrokenProcessPool as error:
        raise EvaluationError("a process of the objective died") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _named(name: str, differentiable: bool, points: Array) -> Evaluation:
    """What a spawned process does."""
    from ffdstudio.optimize.objectives.function import PythonFunction

    return evaluated(PythonFunction(name, differentiable), points, False)
