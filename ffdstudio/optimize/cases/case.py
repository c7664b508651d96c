"""Case files: any objective, constraints and budgets in TOML.

The keys are in `schema`; ``resources/cases/README.md`` says what they mean, beside an
example for each objective. Relative paths are relative to the case file; a program named
without a slash is looked for on the PATH, one with a slash beside the case file.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.containers import stricttoml
from ffdstudio.engine import Lattice, embed
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.optimize.budget import Budget
from ffdstudio.optimize.cases.objectives import Place, objective_of, objective_table, target_of
from ffdstudio.optimize.cases.rules import constraints_of, refinement_of, rules_of
from ffdstudio.optimize.cases.schema import BUDGET, LATTICE, METHOD, SHAPE, TABLES
from ffdstudio.optimize.cases.tables import Table
from ffdstudio.optimize.catalog.methods import method_kind
from ffdstudio.optimize.consent import Consent, source_of
from ffdstudio.optimize.geometry.sections import trailing_gap
from ffdstudio.optimize.geometry.shapes import Shape, is_section, mesh_shape, section_shape
from ffdstudio.optimize.runs.study import Study, Task
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.paths import refuse_links_out

RESIDUALS = ("contour", "surface")  # objectives that have them
LARGEST = 20_000  # control points of a lattice


@dataclass
class Case:
    """A case file, read.

    Attributes
    ----------
    shape : Shape
    rest : Lattice
    task : Task
    study : Study
    mesh : Mesh, optional
        That follows the lattice.
    """

    shape: Shape
    rest: Lattice
    task: Task
    study: Study
    mesh: Mesh | None = None


def read_case(
    path: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    resume: bool = False,
    consent: Consent | None = None,
) -> Case:
    """Read a case file and set its study up.

    Parameters
    ----------
    folder : path, optional
        Where the log and the evaluations go.
    resume : bool
        Go on where the log there ends.
    consent : Consent, optional
        What may run of a case that came inside something else; see `consent`.

    Raises
    ------
    InputError
        If the file is no TOML or says something that no case can say.
    """
    values = stricttoml.loads(read_bytes(path), os.fspath(path))
    target = None if folder is None else Path(folder)
    if target is not None and resume:
        refuse_links_out(target)
    place = Place(Path(path).parent, target, resume, source_of(path), consent)
    try:
        return built(values, place)
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from error


def build(values: dict[str, Any], beside: Path, folder: Path | None, resume: bool) -> Case:
    """Case from the tables of a file that the user names and that lies in `beside`."""
    return built(values, Place(beside, folder, resume))


def built(values: dict[str, Any], place: Place) -> Case:
    """Case from the tables of a file that lies at a place."""
    unknown = set(values) - set(TABLES)
    if unknown:
        raise InputError(f"a case knows no [{sorted(unknown)[0]}]; it knows {', '.join(TABLES)}")
    given = {name: values.get(name, {}) for name in TABLES}
    of_shape = Table(given["shape"], "shape", SHAPE)
    box = Table(given["lattice"], "lattice", LATTICE)
    goal = objective_table(given["objective"])
    method = Table(given["method"], "method", METHOD)
    budget = Table(given["budget"], "budget", BUDGET)
    shape = _shape(of_shape, goal, place)
    rest = _lattice(box, shape)
    rules = rules_of(given["variables"], shape, rest)
    refined = "refinement" in values
    refinement = refinement_of(values["refinement"], rules, rest) if refined else None
    constraints = constraints_of(values.get("constraints", []), shape)
    _check_method(method, goal, bool(constraints))
    task = Task(
        objective_of(goal, given["objective"], shape, place),
        embed(rest, shape.points),
        _metric_surface(goal, shape),
        rules,
        metric=method["metric"],
        constraints=constraints,
        penalty=method["penalty"],
    )
    study = Study(
        task,
        method_kind(method["name"])(carry_memory=method["carry_memory"]),
        refinement,
        Budget(budget["evaluations"], budget["iterations"], budget["tolerance"]),
        folder=place.folder,
        resume=place.resume,
    )
    follower = of_shape["mesh"]
    mesh = read_mesh(place.beside / follower) if follower else shape.mesh
    return Case(shape, rest, task, study, mesh)


def _check_method(method: Table, goal: Table, constrained: bool) -> None:
    name = method["name"]
    if name not in ("gauss-newton", "minimax"):
        return
    if constrained:
        raise method.refuse("name", f"{name} knows no constraints: use slsqp, or lbfgs, by penalty")
    if goal["kind"] not in RESIDUALS:
        raise method.refuse(
            "name", f"{name} needs residuals, which {' and '.join(RESIDUALS)} have: use lbfgs"
        )


def _shape(table: Table, goal: Table, place: Place) -> Shape:
    source = table["source"]
    if is_section(source):
        target = target_of(goal, place) if table["trailing_edge"] == "match" else None
        gap = None if target is None else trailing_gap(target)
        return section_shape(place.located(source), table["points"], gap)
    if not table["marker"]:
        raise InputError("[shape] a mesh needs the name of a marker")
    whole = goal["kind"] == "program"
    return mesh_shape(str(place.beside / source), table["marker"], whole)


def _metric_surface(goal: Table, shape: Shape) -> Surface:
    """Distances to a contour are averaged over points, not over length: see `task`."""
    if goal["kind"] != "contour":
        return shape.surface
    count = len(shape.points)
    return Surface(np.full(count, 1 / count), shape.surface.slopes)


def _lattice(table: Table, shape: Shape) -> Lattice:
    counts, degrees = table["shape"], table["degrees"]
    if np.prod(counts, dtype=float) > LARGEST:
        raise table.refuse("shape", f"more than {LARGEST} control points")
    lower, upper = table["lower"], table["upper"]
    if (lower is None) != (upper is None):
        raise table.refuse("lower", "lower and upper go together")
    if degrees is not None and len(degrees) != len(counts):
        raise table.refuse("degrees", f"{len(counts)} directions need as many, got {len(degrees)}")
    if degrees is None and shape.mesh is None and len(counts) == 2:
        degrees = [3, counts[1] - 1]
    if lower is not None:
        return Lattice.box(_three(lower), _three(upper), counts, degrees)
    seen = shape.points[shape.surface.mass > 0]
    return Lattice.around(seen, counts, degrees, table["margin"])


def _three(corner: list[float]) -> Any:
    return np.array((corner + [0.0, 0.0, 0.0])[:3])
