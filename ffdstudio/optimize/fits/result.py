"""What a fit has reached."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ffdstudio.engine import Lattice
from ffdstudio.optimize.build.build import Built
from ffdstudio.optimize.runs.record import Record, RunHistory


@dataclass
class FitResult:
    """What a fit has reached.

    Attributes
    ----------
    rms, max_error : float
        Orthogonal distance on the dense contour (3D: on the points of the source); chord 1.
    kulfan_ratio : float or None
        Largest error in units of Kulfan's tolerance; None in 3D.
    variables, columns, rows, evaluations, iterations : int
    seconds : float
    ended : str
        Why: converged, stalled (no step makes the error less), a budget, a limit of growth.
    history : list of dict
        The same figures for each iterate.
    lattice, rest : Lattice
    study : RunHistory
        All records.
    built : Built
        Description, shape and figures, for plots.
    """

    rms: float
    max_error: float
    kulfan_ratio: float | None
    variables: int
    columns: int
    rows: int
    evaluations: int
    iterations: int
    seconds: float
    ended: str
    history: list[dict[str, Any]] = field(repr=False)
    lattice: Lattice
    rest: Lattice
    study: RunHistory = field(repr=False)
    built: Built = field(repr=False)

    def to_json(self) -> dict[str, Any]:
        """The figures and the history, as plain values."""
        names = (
            "rms", "max_error", "kulfan_ratio", "variables", "columns", "rows", "evaluations",
            "iterations", "seconds", "ended", "history",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names}


def result_of(history: RunHistory, built: Built, seconds: float) -> FitResult:
    """Result of a study that has ended."""
    figures = [_figures(record) for record in history.iterates]
    lattice = history.lattice(-1)
    return FitResult(
        **figures[-1] | {"seconds": seconds}, ended=history.records[-1].note, history=figures,
        lattice=lattice, rest=built.monitor.rest_of(lattice), study=history, built=built,
    )  # fmt: skip


def _figures(record: Record) -> dict[str, Any]:
    assert record.lattice is not None
    points = record.lattice["control_points"]
    return {
        "rms": record.measures["rms"],
        "max_error": record.measures["max_error"],
        "kulfan_ratio": record.measures.get("kulfan_ratio"),
        "variables": record.variables,
        "columns": len(points),
        "rows": len(points[0]),
        "evaluations": record.evaluation,
        "iterations": record.iteration,
        "seconds": record.seconds,
    }
