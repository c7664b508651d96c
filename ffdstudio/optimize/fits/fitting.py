"""`fit`: bring one shape to another by a lattice, regularly or adaptively."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.meshes.airfoil import split_element
from ffdstudio.optimize.build.build import build_on
from ffdstudio.optimize.build.lattice import ACROSS, MARGIN
from ffdstudio.optimize.build.place import Place, given
from ffdstudio.optimize.build.shape import shape_of
from ffdstudio.optimize.catalog.methods import method_kind
from ffdstudio.optimize.catalog.metrics import metric_named
from ffdstudio.optimize.fits.result import FitResult, result_of
from ffdstudio.optimize.geometry.sections import POINTS_PER_VARIABLE, points_for
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.geometry.surfaces import surface_of
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.methods.minimax import Minimax
from ffdstudio.optimize.methods.powell import Powell
from ffdstudio.optimize.objectives.contour import ContourSpec
from ffdstudio.optimize.objectives.surface import SurfaceSpec
from ffdstudio.optimize.runs.study import Listener
from ffdstudio.optimize.spec.codec import checked
from ffdstudio.optimize.spec.fields import Letter
from ffdstudio.optimize.spec.goals import ObjectiveSpec
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.optimize.variables.rules import AXES

LETTERS: tuple[Letter, ...] = ("x", "y", "z")
RELOCATE_UP_TO = 48  # variables: beyond, moving knots costs more than the whole fit
NOTHING = 1e-8  # of the extent: two splines through one section differ by so much
KULFAN = 4e-4  # the smallest unit of the norm "max"


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
    metric: str = "h1",
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
    objects: dict[str, Any] = {}
    spatial = is_spatial(source)
    if spatial:
        _check_pair(source, target)
    elif layers is not None:
        raise InputError("layers are for surfaces in 3D; the source is a section")
    elif directions is not None:
        raise InputError("directions are for surfaces in 3D; a section is deformed in y")
    first = columns if adaptive is None else min(start or 5, columns)
    across = (rows, layers or 2) if spatial else (rows,)
    column = int(np.prod(across)) * (len(directions or "xyz") if spatial else 1)
    final = variables or columns * column
    if final < first * column:
        raise InputError(
            f"{final} variables are fewer than the {first * column} that the fit begins with"
        )
    kind = Minimax if norm == "max" else method_kind(method)
    if relocate is None:
        relocate = kind.residuals and final <= RELOCATE_UP_TO and not spatial
    names = _named(source, "source", objects), _named(target, "target", objects)
    spec = StudySpec(
        shape=_shape(names[0], spatial, variables or columns * rows),
        lattice=_lattice((first, *across), spatial, spacing, adaptive is not None),
        variables=_variables(spatial, directions or "xyz"),
        objective=_objective(names[1], spatial, norm),
        method=kind(metric=metric),
        refinement=None if adaptive is None else RefinementSpec(
            indicator=adaptive, directions=("i", "j", "k") if spatial else ("i",),
            variables=final, positions=positions, insertions=insertions, row_wise=row_wise,
            relocate=relocate, **_trigger(kind, metric),
        ),
        budget=BudgetSpec(evaluations=evaluations, iterations=iterations),
    )  # fmt: skip
    spec = checked(spec)
    place = Place(folder=None if folder is None else Path(folder), resume=resume, objects=objects)
    shape = shape_of(spec, place)
    if spatial:
        _check_points(shape, columns * column if adaptive is None else first * column)
    if tolerance is None:
        tolerance = NOTHING / KULFAN if norm == "max" else NOTHING * extent(shape)
    budget = msgspec.structs.replace(spec.budget, tolerance=0.5 * tolerance**2)
    built = build_on(msgspec.structs.replace(spec, budget=budget), place, shape)
    return result_of(built.study.run(listener), built, time.perf_counter() - began)


def _named(shape: Any, name: str, objects: dict[str, Any]) -> str:
    """How a description names a shape; arrays and meshes are kept at hand."""
    if isinstance(shape, str | os.PathLike):
        return os.fspath(shape)
    objects[name] = shape
    return given(name)


def _shape(source: str, spatial: bool, variables: int) -> ShapeSpec:
    return ShapeSpec(source=source, points=None if spatial else points_for(variables))


def _lattice(counts: tuple[int, ...], spatial: bool, spacing: str, movable: bool) -> LatticeSpec:
    if spatial:
        return LatticeSpec(shape=counts, margin=MARGIN)
    return LatticeSpec(
        shape=counts, degrees=(3, counts[1] - 1), margin=(MARGIN, ACROSS),
        spacing="uniform" if spacing == "uniform" else "greville", movable=movable,
    )  # fmt: skip


def _variables(spatial: bool, letters: str) -> VariablesSpec:
    wanted = tuple(letter for letter in LETTERS if letter in letters)
    return VariablesSpec(directions=wanted if spatial else None)


def _objective(target: str, spatial: bool, norm: str) -> ObjectiveSpec:
    if spatial:
        return SurfaceSpec(target=target)
    return ContourSpec(target=target, unit="tolerance" if norm == "max" else "chord")


def _trigger(kind: type[MethodSpec], metric: str) -> dict[str, Any]:
    """When a cycle is due; plain control points need more rounds to gain from a level."""
    if kind is Powell and metric_named(metric).plain:
        return {"iterations": 3}
    return kind.trigger._asdict()


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


def extent(shape: Shape) -> float:
    """Length that nothing is small against: the chord, or the longest side in 3D."""
    return float(np.ptp(shape.dense, axis=0).max())


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


def _check_points(shape: Shape, variables: int) -> None:
    most = len(shape.points) // POINTS_PER_VARIABLE
    if variables > most:
        raise InputError(
            f"the {len(shape.points)} points of the source suffice for {most} variables, "
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
    kind = method_kind(method)
    if kind.constraints:
        raise InputError(f"the method {method} is for constraints, which a fit has not")
    if norm == "max" and not kind.residuals:
        raise InputError(f'the norm "max" has a method of its own, {method} is for "l2"')
    if columns < 4 or rows < 2 or (start is not None and start < 4):
        raise InputError("a fit needs at least 4 columns, at the start as well, and 2 rows")
    if start is not None and start > columns:
        raise InputError(f"a fit to {columns} columns cannot start with {start}")
    if adaptive is not None and spacing != "greville":
        raise InputError("equally spaced columns are for regular lattices: add --regular")
