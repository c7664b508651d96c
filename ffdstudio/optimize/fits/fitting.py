"""`fit`: bring one shape to another by a lattice, regularly or adaptively."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.meshes.airfoil import split_element
from ffdstudio.optimize.budget import Budget
from ffdstudio.optimize.fits.result import FitResult, result_of
from ffdstudio.optimize.fits.task import FitTask, section_task, surface_of, surface_task
from ffdstudio.optimize.geometry.sections import POINTS_PER_VARIABLE
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.runs.study import Listener, Study
from ffdstudio.optimize.variables.rules import AXES

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
    directions: str | None = None,
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
        Airfoil files (``flap.dat#2`` is the second element of several), names of NACA four-digit
        sections ("naca0012": closed trailing edge) or (m, 2) contours; or two surface meshes in
        3D (files or `Mesh`).
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
    directions : str, optional
        Of the displacements in 3D, such as "z"; "xyz" by default. Sections move in y.
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
    _check_directions(directions)
    began = time.perf_counter()
    first = columns if adaptive is None else min(start or 5, columns)
    if is_spatial(source):
        _check_pair(source, target)
        layers = layers or 2
        task = surface_task(source, target, (first, rows, layers), metric, directions or "xyz")
        column = len(task.task.rules.directions) * rows * layers
        _check_points(task, columns * column if adaptive is None else first * column)
    elif layers is not None:
        raise InputError("layers are for surfaces in 3D; the source is a section")
    elif directions is not None:
        raise InputError("directions are for surfaces in 3D; a section is deformed in y")
    else:
        column = rows
        task = section_task(
            source, target, (first, rows), metric, spacing, norm, adaptive is not None,
            variables or columns * rows,
        )  # fmt: skip
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
    return result_of(history, task, time.perf_counter() - began)


def _trigger(name: str, metric: str) -> dict[str, Any]:
    """When a cycle is due; plain control points need more rounds to gain from a level."""
    plain = name == "powell" and metric == "none"
    return {"iterations": 3} if plain else TRIGGERS[name]


def is_spatial(source: Any) -> bool:
    """Whether a source is a mesh rather than a section."""
    from ffdstudio.meshes.mesh import Mesh
    from ffdstudio.optimize.geometry.sections import is_naca

    if isinstance(source, Mesh):
        return True
    if isinstance(source, np.ndarray) or is_naca(source):
        return False
    name = split_element(source)[0]
    return Path(name).suffix.lower() not in (".dat", ".txt", ".sel", ".lednicer")


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


def _check_directions(directions: str | None) -> None:
    if directions is None:
        return
    if not directions or not set(directions) <= set(AXES) or len(set(directions)) < len(directions):
        raise InputError(f"directions are letters out of xyz, each once, got {directions!r}")


def _check_points(task: FitTask, variables: int) -> None:
    most = len(task.judged.points) // POINTS_PER_VARIABLE
    if variables > most:
        raise InputError(
            f"the {len(task.judged.points)} points of the source suffice for {most} variables, "
            f"not for {variables}"
        )


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
