"""Evaluations kept on the disk, so that a resumed study does not pay for them again."""

from __future__ import annotations

import hashlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.optimize.objectives.base import Array, Evaluation, Objective, TakesVariables


class EvaluationError(InputError):
    """An evaluation failed; the study ends there and can be resumed."""


class Remembered:
    """An expensive objective with a folder of what it has said.

    An evaluation is found by the SHA-256 of the points. A damaged file counts as none.
    """

    def __init__(self, objective: Objective, folder: Path) -> None:
        self.objective, self.folder = objective, folder
        self.differentiable = objective.differentiable
        self.variables: list[float] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot make the folder {folder}: {error.strerror}") from error

    def evaluate(self, points: Array, gradient: bool = True) -> Evaluation:
        """See `Objective`."""
        known = self._load(points)
        if known is not None and not (gradient and self.differentiable and known.gradient is None):
            return known
        if isinstance(self.objective, TakesVariables):
            self.objective.variables = self.variables
        found = self.objective.evaluate(points, gradient)
        self._save(points, found)
        return found

    def evaluate_all(self, shapes: list[Array]) -> list[Evaluation]:
        """Evaluate several shapes, those that are new at the same time."""
        found: list[Any] = [self._load(points) for points in shapes]
        new = [k for k, known in enumerate(found) if known is None]
        from ffdstudio.optimize.solver import evaluate_all

        for k, one in zip(new, evaluate_all(self.objective, [shapes[k] for k in new]), strict=True):
            found[k] = one
            self._save(shapes[k], one)
        return found

    def _path(self, points: Array) -> Path:
        digest = hashlib.sha256(np.ascontiguousarray(points).tobytes()).hexdigest()
        return self.folder / f"{digest[:32]}.npz"

    def _load(self, points: Array) -> Evaluation | None:
        path = self._path(points)
        if not path.exists():
            return None
        try:
            with np.load(io.BytesIO(read_bytes(path)), allow_pickle=False) as stored:
                head = json.loads(str(stored["head"]))
                gradient = stored["gradient"] if "gradient" in stored.files else None
            return Evaluation(gradient=gradient, **head)
        except (ValueError, TypeError, KeyError, OSError, EOFError):
            return None

    def _save(self, points: Array, found: Evaluation) -> None:
        head = {
            "value": found.value,
            "flow": found.flow,
            "adjoint": found.adjoint,
            "measures": found.measures,
        }
        arrays: dict[str, Any] = {"head": np.array(json.dumps(head))}
        if found.gradient is not None:
            arrays["gradient"] = found.gradient
        data = io.BytesIO()
        np.savez(data, **arrays)
        write_bytes(self._path(points), data.getvalue())
