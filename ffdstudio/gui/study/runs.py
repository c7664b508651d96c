"""One run of a study as the window keeps it: its plan, its records, its figures as columns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.project.studies.plan import Plan

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record, RunHistory
    from ffdstudio.optimize.runs.study import Study

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
    "preparing": "Preparing …",
    "running": "Running",
    "paused": "Paused",
    "done": "Ended",
    "failed": "Failed",
}


@dataclass(eq=False)
class Run:
    """A study that runs or has run.

    Attributes
    ----------
    name : str
    number : int
        Which picks its colour.
    plan : Plan
    key : str
        Of the lattice in the document.
    history : RunHistory
        Records that have arrived, a copy of the worker's.
    state : str
        One of `STATES`.
    note : str
        Why it ended.
    """

    name: str
    number: int
    plan: Plan
    key: str
    history: RunHistory
    state: str = "preparing"
    note: str = ""
    study: Study | None = None
    stopping: bool = False
    iterates: list[Record] = field(default_factory=list)
    _columns: dict[str, list[float]] = field(default_factory=dict)

    def add(self, record: Record) -> None:
        """Take a record that has arrived."""
        from ffdstudio.optimize.runs.record import value_of

        self.history.records.append(record)
        if record.kind == "end":
            self.note = record.note
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
