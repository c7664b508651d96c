"""`fit`: bring one shape to another by a lattice, regularly or adaptively."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.optimize.fit_task import FitTask, section_task, surface_of, surface_task
from ffdstudio.optimize.record import History, Record
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.solver import Budget
from ffdstudio.optimize.study import Listener, Study

Array = NDArray[np.float64]
RELOCATE_UP_TO = 48  # variables: beyond, moving knots costs more than the whole fit
NOTHING = 1e-8  # of the extent: two splines through one section differ by so much
KULFAN = 4e-4  # the smallest unit of the norm "max"

# When a cycle of refinement is due. Gauss-Newton converges on each level; a round of conjugate
# directions is an iteration, and gradient methods go on until an iteration gains little.
TRIGGERS: dict[str, dict[str, Any]] = {
    "gauss-newton": {},
    "minimax": {},
    "powell": {"iterations": 1},
    "cg": {"slope": 0.8},
    "lbfgs": {"slope": 0.8},
}


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
    history : list of dict
        The same figures for each iterate.
    lattice, rest : Lattice
    study : History
        All records.
    task : FitTask
        Source, target and figures, for plots.
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
    history: list[dict[str, Any]] = field(repr=False)
    lattice: Lattice
    rest: Lattice
    study: History = field(repr=False)
    task: FitTask = field(repr=False)

    def to_json(self) -> dict[str, Any]:
        """The figures and the history, as plain values."""
        names = (
            "rms", "max_error", "kulfan_ratio", "variables", "columns", "rows", "evaluations",
            "iterations", "seconds", "history",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names}


def fit(
    source: Any,
    target: Any,
    *,
    columns: int = 35,
    rows: int = 2,
    layers: int | None = None,
    adaptive: str | None = "gain",
    start: int | None = None,
    method: str = "gauss-newton",
    norm: str = "l2",
    metric: str = "l2",
    row_wise: bool = False,
    spacing: str = "greville",
    positions: int = 5,
    insertions: int = 1,
    relocate: bool | None = None,
    variables: int | None = None,
    evaluations: int | None = None,
    iterations: int | None = None,
    tolerance: float | None = None,
    folder: str | os.PathLike[str] | None = None,
    resume: bool = False,
    listener: Listener | None = None,
) -> FitResult:
    """Deform a source so that it becomes a target.

    Parameters
    ----------
    source, target : path, str, numpy.ndarray or Mesh
        Airfoil files, names of NACA four-digit sections ("naca0012": closed trailing edge) or
        (m, 2) contours; or two surface meshes in 3D (files or `Mesh`).
    columns, rows, layers : int
        Control points of the lattice in x, y (and z in 3D: 2 layers by default); with
        `adaptive`, at the end.
    adaptive : {"gain", "interval", "gradient"} or None
        The indicator that says where to refine; None keeps a regular lattice.
    start : int
        Columns at the beginning, if adaptive; 5 by default, but no more than `columns`.
    method : {"gauss-newton", "lbfgs", "cg", "powell"}
        For least squares; the norm "max" has its own.
    norm : {"l2", "max"}
        Least squares, or the least largest error in units of Kulfan's tolerance.
    metric : {"l2", "h1", "none"}
        In which the variables are orthonormal.
    row_wise : bool
        A new knot frees one row only; `columns * rows` is then the number of variables.
    spacing : {"greville", "uniform"}
        Places of the control points of a regular lattice; a refined one is Greville's.
    positions, insertions : int
        Candidate places in a knot span, and knots a cycle.
    relocate : bool, optional
        Move knots at the end. Default: for least squares with up to 48 variables.
    variables : int, optional
        Number of variables at the end, instead of columns times rows.
    evaluations, iterations : int, optional
    tolerance : float, optional
        RMS at the fitted points at which the fit has ended; by default 1e-8 of the extent,
        where nothing is left to gain.
    folder : path, optional
        Where the study is logged; with `resume` it goes on from there.
    listener : callable, optional
        Told of each record.

    Returns
    -------
    FitResult

    Raises
    ------
    InputError
        If source or target cannot be read, or the options do not fit.

    Examples
    --------
    >>> result = fit("naca0012", "naca0015", columns=6, adaptive=None)
    >>> result.rms < 1e-6, result.variables
    (True, 12)
    """
    _check_counts(
        evaluations=evaluations, iterations=iterations, variables=variables, columns=columns,
        rows=rows, start=start, layers=layers,
    )  # fmt: skip
    if adaptive is None:
        _check_regular(start=start, variables=variables, row_wise=row_wise or None)
    _check(method, norm, columns, rows, start, adaptive, spacing)
    began = time.perf_counter()
    first = columns if adaptive is None else min(start or 5, columns)
    if is_spatial(source):
        _check_pair(source, target)
        layers = layers or 2
        task = surface_task(source, target, (first, rows, layers), metric, adaptive is not None)
        column = len(task.task.rules.directions) * rows * layers
    elif layers is not None:
        raise InputError("layers are for surfaces in 3D; the source is a section")
    else:
        task = section_task(
            source, target, (first, rows), metric, spacing, norm, adaptive is not None
        )
        column = rows
    final = variables or columns * column
    if final < first * column:
        raise InputError(
            f"{final} variables are fewer than the {first * column} that the fit begins with"
        )
    name = "minimax" if norm == "max" else method
    refinement = None
    if adaptive is not None:
        if relocate is None:
            relocate = (
                name in ("gauss-newton", "minimax") and final <= RELOCATE_UP_TO and not task.spatial
            )
        refinement = Refinement(
            adaptive, task.axes, final, positions, insertions, row_wise, relocate=relocate,
            **_trigger(name, metric),
        )  # fmt: skip
    if tolerance is None:
        tolerance = NOTHING / KULFAN if norm == "max" else NOTHING * extent(task)
    budget = Budget(evaluations, iterations, 0.5 * tolerance**2)
    study = Study(
        task.task, name, refinement, budget, folder=None if folder is None else Path(folder),
        resume=resume,
    )  # fmt: skip
    history = study.run(listener)
    return _result(history, task, time.perf_counter() - began)


def _trigger(name: str, metric: str) -> dict[str, Any]:
    """When a cycle is due; plain control points need more rounds to gain from a level."""
    plain = name == "powell" and metric == "none"
    return {"iterations": 3} if plain else TRIGGERS[name]


def is_spatial(source: Any) -> bool:
    """Whether a source is a mesh rather than a section."""
    from ffdstudio.meshes.mesh import Mesh
    from ffdstudio.optimize.sections import is_naca

    if isinstance(source, Mesh):
        return True
    if isinstance(source, np.ndarray) or is_naca(source):
        return False
    return Path(source).suffix.lower() not in (".dat", ".txt", ".sel", ".lednicer")


def extent(task: FitTask) -> float:
    """Length that nothing is small against: the chord, or the longest side in 3D."""
    return float(np.ptp(task.judged.points, axis=0).max())


def _check_counts(**counts: int | None) -> None:
    for name, count in counts.items():
        if count is not None and count < 1:
            raise InputError(f"{name} must be at least 1, got {count}")


def _check_regular(**given: Any) -> None:
    names = [name.replace("_", "-") for name, value in given.items() if value is not None]
    if names:
        raise InputError(f"{names[0]} is for adaptive fits, not for regular lattices")


def _check_pair(source: Any, target: Any) -> None:
    """Refuse a section as the target of a mesh; a source that is wrong itself is told first."""
    if is_spatial(target):
        return
    if not isinstance(source, str | os.PathLike) or Path(source).is_file():
        raise InputError(
            f"{_name(source, 'the source')} is a mesh, {_name(target, 'the target')} a section: "
            "a fit is between two sections or two surface meshes"
        )
    surface_of(source)


def _name(shape: Any, otherwise: str) -> str:
    return os.fspath(shape) if isinstance(shape, str | os.PathLike) else otherwise


def _check(
    method: str,
    norm: str,
    columns: int,
    rows: int,
    start: int | None,
    adaptive: str | None,
    spacing: str,
) -> None:
    if norm not in ("l2", "max"):
        raise InputError(f'the norm must be "l2" or "max", got {norm!r}')
    if method not in TRIGGERS:
        raise InputError(f"the method must be one of {', '.join(TRIGGERS)}, got {method!r}")
    if norm == "max" and method not in ("gauss-newton", "minimax"):
        raise InputError(f'the norm "max" has a method of its own, {method} is for "l2"')
    if columns < 4 or rows < 2 or (start is not None and start < 4):
        raise InputError("a fit needs at least 4 columns, at the start as well, and 2 rows")
    if start is not None and start > columns:
        raise InputError(f"a fit to {columns} columns cannot start with {start}")
    if adaptive is not None and spacing != "greville":
        raise InputError("equally spaced columns are for regular lattices: add --regular")


def _result(history: History, task: FitTask, seconds: float) -> FitResult:
    figures = [_figures(record) for record in history.iterates]
    lattice = history.lattice(-1)
    return FitResult(
        **figures[-1] | {"seconds": seconds}, history=figures, lattice=lattice,
        rest=task.rest_of(lattice), study=history, task=task,
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
