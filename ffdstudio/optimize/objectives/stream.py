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
from concurrent.futures import FIRST_COMPLETED, Future, wait

from ffdstudio.optimize.control import Stopped
from ffdstudio.optimize.objectives.base import Evaluation, Objective, Request, never
from ffdstudio.optimize.objectives.failures import EvaluationError
from ffdstudio.optimize.objectives.process import POLL

Waiting = deque[tuple[Request, "Future[Evaluation]"]]
Stream = Generator[tuple[Request, Evaluation], None, None]


def streamed(
    objective: Objective, requests: Iterable[Request], stopped: Callable[[], bool] = never
) -> Stream:
    """Evaluate shapes, as many at the same time as the objective's `abilities.batch`.

    Raises
    ------
    EvaluationError
        If one fails, after those that ran beside it.
    Stopped
        If the study is stopped.
    """
    count = max(1, objective.abilities.batch)
    waiting: Waiting = deque()
    with objective.starting() as start:
        for request in requests:
            while _running(waiting) >= count or len(waiting) >= 2 * count:
                _await(waiting, stopped)
                yield from _ready(waiting, stopped)
            if stopped():
                raise Stopped
            waiting.append((request, start(request)))
            yield from _ready(waiting, stopped)
        yield from _drained(waiting, stopped)


def _running(waiting: Waiting) -> int:
    return sum(not future.done() for _, future in waiting)


def _await(waiting: Waiting, stopped: Callable[[], bool]) -> None:
    """Wait until the first of the line, or any that runs, has ended."""
    running = [future for _, future in waiting if not future.done()]
    while running and not wait(running, POLL, FIRST_COMPLETED).done:
        if stopped():
            raise Stopped


def _ready(
    waiting: Waiting, stopped: Callable[[], bool]
) -> Iterator[tuple[Request, Evaluation]]:  # fmt: skip
    while waiting and waiting[0][1].done():
        if waiting[0][1].exception() is not None:
            yield from _drained(waiting, stopped)  # raises
            return
        request, future = waiting.popleft()
        yield request, future.result()


def _drained(
    waiting: Waiting, stopped: Callable[[], bool]
) -> Iterator[tuple[Request, Evaluation]]:  # fmt: skip
    """All that were begun; the first failure is raised behind them, see 3."""
    failure: EvaluationError | None = None
    while waiting:
        while not waiting[0][1].done():
            _await(waiting, stopped)
        request, future = waiting.popleft()
        try:
            found = future.result()
        except EvaluationError as error:
            failure = failure or error
            continue
        yield request, found
    if failure is not None:
        raise failure


# ---- single evaluations --------------------------------------------------------------------


def at_once(objective: Objective, request: Request) -> Future[Evaluation]:
    """Evaluate now; what comes of it, or the failure, is in the future."""
    future: Future[Evaluation] = Future()
    try:
        future.set_result(evaluated(objective, request))
    except EvaluationError as error:
        future.set_exception(error)
    return future


def then(
    first: Future[Evaluation], change: Callable[[Evaluation], Evaluation]
) -> Future[Evaluation]:
    """What comes of a future, changed as soon as it is there."""
    second: Future[Evaluation] = Future()

    def ended(done: Future[Evaluation]) -> None:
        try:
            second.set_result(change(done.result()))
        except BaseException as error:  # whatever it was, the one who waits hears of it
            second.set_exception(error)

    first.add_done_callback(ended)
    return second


def evaluated(objective: Objective, request: Request) -> Evaluation:
    """Evaluate; a function that ends Python, as scripts do, has failed."""
    try:
        return objective.answer(request)
    except SystemExit as end:
        raise EvaluationError(f"the objective called sys.exit({end.code!r})") from end
