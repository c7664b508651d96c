"""Evaluations kept on the disk, so that a resumed study does not pay for them again."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.containers import archive, npy, strictjson
from ffdstudio.containers.strictjson import field
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.optimize.objectives.base import Evaluation, Objective, Request, Response, Start
from ffdstudio.optimize.objectives.stream import then


class Remembered(Objective):
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
        self.abilities = objective.abilities
        self.recalled = 0
        self._identity, self._resume = identity.encode(), resume
        self._own: set[Path] = set()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot make the folder {folder}: {error.strerror}") from error

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        known = self._recalled(request.points, request.gradient and self.abilities.gradient)
        if known is not None:
            return known
        return self._kept(request.points, self.objective.answer(request))

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `Objective`: those that are known are not begun, others are kept as they end."""
        with self.objective.starting() as start:

            def begin(request: Request) -> Future[Evaluation]:
                known = self._recalled(request.points, False)
                if known is None:
                    return then(start(request), lambda found: self._kept(request.points, found))
                ready: Future[Evaluation] = Future()
                ready.set_result(known)
                return ready

            yield begin

    def response(self, points: Array) -> Response | None:
        """See `Objective`."""
        return self.objective.response(points)

    def pressures(self, points: Array) -> Mapping[str, Mapping[str, tuple[Array, Array]]]:
        """See `Objective`."""
        return self.objective.pressures(points)

    # ---- the folder ---------------------------------------------------------------------------

    def _path(self, points: Array) -> Path:
        digest = hashlib.sha256(self._identity + b"\0" + np.ascontiguousarray(points).tobytes())
        return self.folder / f"{digest.hexdigest()[:32]}.npz"

    def _recalled(self, points: Array, gradient: bool) -> Evaluation | None:
        path = self._path(points)
        if not (self._resume or path in self._own) or not path.exists():
            return None
        found = _read(path, points)
        if found is None or (gradient and found.gradient is None):
            return None
        self.recalled += path not in self._own
        return found

    def _kept(self, points: Array, found: Evaluation) -> Evaluation:
        path = self._path(points)
        _write(path, found)
        self._own.add(path)
        return found


def _read(path: Path, points: Array) -> Evaluation | None:
    """Evaluation that a file holds; None if it is not, to the last field, one of ours."""
    try:
        entries = archive.unpack(read_bytes(path, to_update=True), path.name)
        head = strictjson.loads(str(npy.loads(entries["head.npy"], text=True)).encode(), path.name)
        rows = npy.loads(entries["gradient.npy"]) if "gradient.npy" in entries else None
        fields = _checked(head)
    except (ValueError, TypeError, KeyError):
        return None
    if rows is not None and not (rows.shape == points.shape and np.isfinite(rows).all()):
        return None
    return Evaluation(gradient=None if rows is None else rows.astype(np.float64), **fields)


def _checked(head: dict[str, Any]) -> dict[str, Any]:
    """The fields of an evaluation, or an `InputError`."""
    value, measures = field(head, "value", (float, int), "it"), field(head, "measures", dict, "it")
    if any(isinstance(x, bool) or not isinstance(x, float | int) for x in measures.values()):
        raise InputError("a measure that is no number")
    counts = {name: field(head, name, int, "it") for name in ("flow", "adjoint")}
    return {"value": float(value), "measures": measures, **counts}


def _write(path: Path, found: Evaluation) -> None:
    names = ("value", "flow", "adjoint", "measures")
    head = {name: getattr(found, name) for name in names}
    arrays: dict[str, Any] = {"head": np.array(json.dumps(head))}
    if found.gradient is not None:
        arrays["gradient"] = found.gradient
    data = io.BytesIO()
    np.savez(data, **arrays)
    write_bytes(path, data.getvalue())
