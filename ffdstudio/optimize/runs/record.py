"""The record of a study: one line of JSON for each evaluation, iterate and refinement.

1. Lines are only ever appended, so another process can follow a study while it runs, and a
   killed one has lost at most its last, unfinished line.
2. A study is deterministic. It resumes by running again: as long as it does what the log says,
   nothing is written; expensive objectives answer from their own memory on the disk.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.parts import as_lists
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.limits import check_nesting
from ffdstudio.optimize.ending import Ending, Reason

LOG = "log.jsonl"


@dataclass
class Record:
    """One line.

    Attributes
    ----------
    kind : {"evaluation", "iterate", "refinement", "end"}
    evaluation, flow, adjoint : int
        Evaluations of the cost so far, and solves that they took.
    iteration, level, variables : int
        Iterates and refinements so far, and the number of design variables.
    cost, gradient : float
        The cost and the norm of its gradient by the whitened variables (NaN if not asked for).
    seconds : float
        Wall time since the study began.
    y : list of float
        Design variables of the level.
    measures : dict
        Further figures: rms, max_error, lift, violations of constraints, ...
    lattice : dict, optional
        Of iterates and refinements: knots, control points, weights.
    note : str
        What was inserted, or why the study ended.
    ending : Ending, optional
        How the study ended, of the last record.
    """

    kind: str
    evaluation: int
    iteration: int
    level: int
    variables: int
    cost: float
    gradient: float = math.nan
    flow: int = 0
    adjoint: int = 0
    seconds: float = 0.0
    y: list[float] = field(default_factory=list)
    measures: dict[str, float] = field(default_factory=dict)
    lattice: dict[str, Any] | None = None
    note: str = ""
    ending: Ending | None = None

    def same(self, other: Record) -> bool:
        """Whether both tell of the same step, whenever it was made."""
        mine, its = self.line(), other.line()
        return {**mine, "seconds": 0} == {**its, "seconds": 0}

    def line(self) -> dict[str, Any]:
        """What is written."""
        fields = {k: v for k, v in asdict(self).items() if v not in (None, "", [], {})}
        if math.isnan(self.gradient):
            del fields["gradient"]
        return fields


class RunHistory:
    """Records of a study, with the lattices of its iterates."""

    def __init__(self, records: list[Record] | None = None) -> None:
        self.records = records if records is not None else []

    @property
    def ending(self) -> Ending | None:
        """How the study ended; None while it runs, and of logs that do not tell."""
        return self.records[-1].ending if self.records else None

    @property
    def iterates(self) -> list[Record]:
        """Records of iterates, in order."""
        return [r for r in self.records if r.kind == "iterate"]

    @property
    def refinements(self) -> list[Record]:
        """Records of refinements, in order."""
        return [r for r in self.records if r.kind == "refinement"]

    def lattice(self, number: int) -> Lattice:
        """Current lattice of an iterate, by its place in `iterates`; -1 is the last."""
        stored = self.iterates[number].lattice
        assert stored is not None
        return unpack(stored)

    def column(self, name: str) -> Array:
        """A field or a measure over the iterates, NaN where there is none."""
        return np.array([value_of(r, name) for r in self.iterates], dtype=np.float64)

    def first_below(self, limit: float, name: str = "cost") -> Record | None:
        """First iterate at which a figure is below a limit."""
        return next((r for r in self.iterates if value_of(r, name) <= limit), None)


def value_of(record: Record, name: str) -> float:
    """A field of a record, or a measure."""
    return float(record.measures.get(name, getattr(record, name, math.nan)))


def pack(lattice: Lattice) -> dict[str, Any]:
    """A lattice as plain lists; the shortest decimals that give the same floats."""
    packed = as_lists(lattice.parts())
    if (lattice.weights == 1).all():
        del packed["weights"]
    return packed


def unpack(stored: dict[str, Any]) -> Lattice:
    """A lattice from plain lists.

    Raises
    ------
    InputError
        If these are no lattice.
    """
    try:
        return Lattice.of_parts(stored)
    except (TypeError, OverflowError) as error:
        raise InputError(f"this is no lattice of a study's record: {error}") from error


def read_log(folder: str | Path) -> RunHistory:
    """History of a study that has ended, stopped, or is running in another process.

    Raises
    ------
    InputError
        If there is no log or a line is not one of ours.
    """
    return RunHistory(list(_parsed(Path(folder) / LOG)))


def written_log(records: Iterable[Record]) -> bytes:
    """Records as the lines of a log."""
    return b"".join(map(_bytes, records))


def parsed_log(lines: bytes) -> list[Record]:
    """Records of a log that may be damaged: lines that are no records are left out."""
    found = []
    for line in lines.split(b"\n"):
        with contextlib.suppress(ValueError, TypeError, KeyError, OverflowError, RecursionError):
            found.append(_record(line.decode()))
    return found


def _parsed(path: Path) -> Iterator[Record]:
    lines = read_bytes(path, to_update=True).split(b"\n")
    for number, line in enumerate(lines[:-1], start=1):  # the last one is unfinished or empty
        try:
            yield _record(line.decode())
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
            raise InputError(f"line {number} of {path} is no record of a study") from error


def _record(line: str) -> Record:
    """Record of a line, each field of its own type; costs may be NaN or infinite."""
    check_nesting(line)
    said = json.loads(line)
    _check_kind(said, (dict,))
    for name, value in said.items():
        kinds, inner = _KINDS.get(name, ((object,), ()))
        items = list(value.values() if isinstance(value, dict) else value) if inner else []
        _check_kind(value, kinds)
        for item in items:
            _check_kind(item, inner)
    told = said.pop("ending", None)
    ending = None if told is None else Ending(**told | {"reason": Reason(told["reason"])})
    record = Record(**said, ending=ending)
    if record.lattice is not None:
        unpack(record.lattice)
    return record


def _check_kind(value: object, kinds: tuple[type, ...]) -> None:
    if isinstance(value, bool) or not isinstance(value, kinds):
        raise TypeError(value)


_NUMBER = (int, float)
_KINDS: dict[str, tuple[tuple[type, ...], tuple[type, ...]]] = {
    "kind": ((str,), ()),
    "note": ((str,), ()),
    "lattice": ((dict,), ()),
    "y": ((list,), _NUMBER),
    "measures": ((dict,), _NUMBER),
    **dict.fromkeys(("evaluation", "iteration", "level", "variables"), ((int,), ())),
    **dict.fromkeys(("flow", "adjoint"), ((int,), ())),
    **dict.fromkeys(("cost", "gradient", "seconds"), (_NUMBER, ())),
}
"""Types of the fields of a record, and of what is in those that hold several."""


class Log:
    """Appends records to a file, or finds that they are there already."""

    def __init__(self, folder: Path | None, resume: bool) -> None:
        self.known: list[Record] = []
        self.position = 0
        self._file: BinaryIO | None = None
        self.path = None if folder is None else folder / LOG
        if self.path is None:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cannot make the folder {self.path.parent}: {error.strerror}"
            ) from error
        if resume and self.path.exists():
            self.known = [r for r in _parsed(self.path) if r.kind != "end"]
        self._rewrite(len(self.known))

    def add(self, record: Record) -> None:
        """Write a record, unless the log holds it already."""
        if self.path is None:
            return
        if self.position < len(self.known):
            if self.known[self.position].same(record):
                record.seconds = self.known[self.position].seconds
                self.position += 1
                return
            self._rewrite(self.position)
            self.known = []
        self._append(record)

    @property
    def elapsed(self) -> float:
        """Time that earlier runs took."""
        return self.known[-1].seconds if self.known else 0.0

    def _rewrite(self, count: int) -> None:
        assert self.path is not None
        self.close()
        write_bytes(self.path, b"".join(_bytes(r) for r in self.known[:count]))

    def _append(self, record: Record) -> None:
        try:
            if self._file is None:
                assert self.path is not None
                self._file = self.path.open("ab")
            self._file.write(_bytes(record))
            self._file.flush()
        except OSError as error:
            raise InputError(
                f"cannot write {self.path}: {(error.strerror or '').lower()}"
            ) from error

    def close(self) -> None:
        """Close the file; a later record opens it again."""
        if self._file is not None:
            self._file.close()
            self._file = None


def _bytes(record: Record) -> bytes:
    return json.dumps(record.line(), separators=(",", ":")).encode() + b"\n"
