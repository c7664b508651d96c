"""Evaluations kept on the disk, so that a resumed study does not pay for them again."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.optimize.objectives.base import (
    Array,
    Evaluation,
    Objective,
    Stoppable,
    TakesVariables,
)

if TYPE_CHECKING:
    from ffdstudio.optimize.objectives.stream import Job, Start


class EvaluationError(InputError):
    """An evaluation failed; the study ends there and can be resumed."""


class Remembered:
    """An expensive objective with a folder of what it has said.

    An evaluation is found by the SHA-256 of the points and of what the objective is. A damaged
    file counts as none.

    Parameters
    ----------
    objective : Objective
    folder : path
    identity : str
        What the objective is: another program or other settings answer anew.
    resume : bool
        Whether to use what an earlier run has left; else only this run's own.

    Attributes
    ----------
    recalled : int
        Answers that an earlier run has left.
    """

    def __init__(
        self, objective: Objective, folder: Path, identity: str = "", resume: bool = True
    ) -> None:
        self.objective, self.folder = objective, folder
        self.differentiable = objective.differentiable
        self.processes: int = getattr(objective, "processes", 1)
        self.variables: list[float] | None = []
        self.stopped: Callable[[], bool] = lambda: False
        self.recalled = 0
        self._identity, self._resume = identity.encode(), resume
        self._own: set[Path] = set()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot make the folder {folder}: {error.strerror}") from error

    def evaluate(self, points: Array, gradient: bool = True) -> Evaluation:
        """See `Objective`."""
        known = self._recalled(points, gradient and self.differentiable)
        if known is not None:
            return known
        if isinstance(self.objective, TakesVariables):
            self.objective.variables = self.variables
        self._pass_on()
        return self._kept(points, self.objective.evaluate(points, gradient))

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `stream.Concurrent`: those that are known are not begun, others kept as they end."""
        from ffdstudio.optimize.objectives.stream import starting

        self._pass_on()
        with starting(self.objective) as start:

            def begin(job: Job) -> Future[Evaluation]:
                known = self._recalled(job.points, False)
                if known is None:
                    return _then(start(job), lambda found: self._kept(job.points, found))
                ready: Future[Evaluation] = Future()
                ready.set_result(known)
                return ready

            yield begin

    def _pass_on(self) -> None:
        if isinstance(self.objective, Stoppable):
            self.objective.stopped = self.stopped

    # ---- the folder ---------------------------------------------------------------------------

    def _path(self, points: Array) -> Path:
        digest = hashlib.sha256(self._identity + b"\0" + np.ascontiguousarray(points).tobytes())
        return self.folder / f"{digest.hexdigest()[:32]}.npz"

    def _recalled(self, points: Array, gradient: bool) -> Evaluation | None:
        path = self._path(points)
        if not (self._resume or path in self._own) or not path.exists():
            return None
        found = _read(path)
        if found is None or (gradient and found.gradient is None):
            return None
        self.recalled += path not in self._own
        return found

    def _kept(self, points: Array, found: Evaluation) -> Evaluation:
        path = self._path(points)
        _write(path, found)
        self._own.add(path)
        return found


def _then(
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


def _read(path: Path) -> Evaluation | None:
    try:
        with np.load(io.BytesIO(read_bytes(path)), allow_pickle=False) as stored:
            head = json.loads(str(stored["head"]))
            gradient = stored["gradient"] if "gradient" in stored.files else None
        return Evaluation(gradient=gradient, **head)
    except (ValueError, TypeError, KeyError, OSError, EOFError):
        return None


def _write(path: Path, found: Evaluation) -> None:
    names = ("value", "flow", "adjoint", "measures")
    head = {name: getattr(found, name) for name in names}
    arrays: dict[str, Any] = {"head": np.array(json.dumps(head))}
    if found.gradient is not None:
        arrays["gradient"] = found.gradient
    data = io.BytesIO()
    np.savez(data, **arrays)
    write_bytes(path, data.getvalue())
