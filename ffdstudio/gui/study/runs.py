"""One study as the window shows it: its records, its figures as columns, what goes on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.build.place import is_given

if TYPE_CHECKING:
    from ffdstudio.optimize.ending import Ending
    from ffdstudio.optimize.runs.record import Record, RunHistory
    from ffdstudio.optimize.runs.study import Study
    from ffdstudio.optimize.spec.study import StudySpec
    from ffdstudio.project.model import StudyItem

FIGURES = {
    "cost": "Cost",
    "rms": "RMS error",
    "max_error": "Largest error",
    "kulfan_ratio": "Error over Kulfan's tolerance",
    "variables": "Variables",
    "gradient": "Gradient norm",
}
AGAINST = {"evaluation": "Evaluations", "iteration": "Iterations", "seconds": "Time in seconds"}
STATES = {
    "ready": "Not begun",
    "preparing": "Preparing …",
    "running": "Running",
    "paused": "Paused",
    "done": "Ended",
    "failed": "Failed",
}


@dataclass(eq=False)
class Run:
    """A study of the document: ready, running, or at its end.

    Attributes
    ----------
    item : StudyItem
        As it is in the document now.
    number : int
        Which picks its colour.
    history : RunHistory
        Records that have arrived; the document's own.
    state : str
        One of `STATES`.
    note : str
        Why it ended.
    """

    item: StudyItem
    number: int
    history: RunHistory
    state: str = "ready"
    note: str = ""
    ending: Ending | None = None
    study: Study | None = None
    stopping: bool = False
    iterates: list[Record] = field(default_factory=list)
    _columns: dict[str, list[float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for record in self.history.records:
            self._take(record)
        if self.history.records:
            self.state = "done"
            self.note = self.note or "it was not ended"

    @property
    def name(self) -> str:
        """Its name in the document."""
        return self.item.name

    @property
    def spec(self) -> StudySpec:
        """What it does."""
        return self.item.spec

    @property
    def key(self) -> str:
        """Key of its lattice in the document; empty if it has none there."""
        file = self.spec.lattice.file
        return file[1:-1] if is_given(file) else ""

    @property
    def failed(self) -> bool:
        """Whether an evaluation of it failed."""
        return self.ending is not None and self.ending.failed

    def begin(self, history: RunHistory) -> None:
        """Forget what was; a new run begins."""
        self.history, self.state, self.note, self.ending = history, "preparing", "", None
        self.iterates, self._columns, self.stopping = [], {}, False

    def add(self, record: Record) -> None:
        """Take a record that has arrived."""
        self.history.records.append(record)
        self._take(record)

    def _take(self, record: Record) -> None:
        from ffdstudio.optimize.runs.record import value_of

        if record.kind == "end":
            self.note, self.ending = record.note, record.ending
        if record.kind != "iterate":
            return
        self.iterates.append(record)
        for name in (*FIGURES, *AGAINST):
            self._columns.setdefault(name, []).append(value_of(record, name))

    def column(self, name: str) -> Array:
        """A figure over the iterates, NaN where there is none."""
        return np.array(self._columns.get(name, []), dtype=np.float64)

    @property
    def alive(self) -> bool:
        """Whether it has not ended."""
        return self.state in ("preparing", "running", "paused")

    @property
    def refined_at(self) -> list[int]:
        """Places in `iterates` of the last iterate of each level but the last."""
        levels = [record.level for record in self.iterates]
        return [k for k in range(len(levels) - 1) if levels[k + 1] != levels[k]]

    def sentence(self, place: int) -> str:
        """Tell one iterate in a line."""
        record = self.iterates[place]
        parts = [
            f"iterate {record.iteration}",
            f"{record.variables} variables",
            f"cost {record.cost:.3e}",
        ]
        if "rms" in record.measures:
            parts.append(f"RMS {record.measures['rms']:.3e}")
        return ", ".join(parts)
