"""Case files: any objective, constraints and budgets in TOML.

The schema, table by table (defaults in brackets):

``[shape]``
    ``source`` a NACA section, an airfoil file or a mesh; ``points`` of a section [161];
    ``marker`` of a mesh; ``mesh`` that follows the lattice at the end [the source, if it is one].
``[lattice]``
    ``shape`` control points of each direction; ``lower``, ``upper`` corners [around the shape];
    ``margin`` [0.01]; ``degrees`` [3, in y of a section the highest].
``[variables]``
    ``directions`` such as ["y"] [2D: y, 3D: x, y, z]; ``frozen`` layers [0]; ``fixed`` control
    points [[i, j], ...]; ``linked`` directions such as ["j"]; ``mirror`` such as "j" with
    ``mirror_normal`` [[0, 1, 0]]; ``weights`` = [lower, upper], positive bounds: the weights of
    the control points are variables too, in a case without refinement [they stay].
``[objective]``
    ``kind`` = "contour" (``target``), "surface" (``target``), "flow" (``angles``; ``target``
    section for its pressures, ``lift``, ``moment``), "function" (``name`` = "module:function",
    ``gradient`` [false], ``processes`` [1]), "program" (``command``, ``sensitivity`` [false],
    ``time_limit`` [3600], ``processes`` [1]), "neuralfoil" (``angle``, ``reynolds``, ``lift``,
    ``weight`` [1]).
``[[constraints]]``
    ``kind`` = "lift" or "moment" (``angle``), "thickness" (``at``), "max-thickness", "area",
    "volume", "nose-radius", "displacement" (``direction``); ``lower``, ``upper`` or ``equal``.
``[method]``
    ``name`` ["lbfgs"], ``metric`` ["h1"], ``carry_memory`` [true], ``penalty`` [1000].
``[refinement]``
    ``indicator`` ["gain"], ``directions`` [["i"]], ``variables``, ``positions`` [5],
    ``insertions`` [1], ``row_wise`` [false], ``iterations``, ``slope``, ``share``,
    ``relocate`` [false]; ``coarsen`` share of the cost that taking inserted knots out at the
    end may add, the budget's tolerance being allowed anyway [none go]. No table: the lattice
    stays as it is.
``[budget]``
    ``evaluations``, ``iterations``, ``tolerance`` of the cost.

Relative paths are relative to the case file; a program named without a slash is looked for on
the PATH, one with a slash beside the case file.
"""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.engine import Lattice, embed
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.optimize.case_parts import constraint_of, objective_of, rules_of
from ffdstudio.optimize.methods import METHODS
from ffdstudio.optimize.metrics import METRICS
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.shapes import Shape, is_section, mesh_shape, section_shape
from ffdstudio.optimize.solver import Budget
from ffdstudio.optimize.study import Study, Task
from ffdstudio.optimize.tables import Table

TABLES = (
    "shape", "lattice", "variables", "objective", "constraints", "method", "refinement", "budget",
)  # fmt: skip


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
    path: str | os.PathLike[str], folder: str | os.PathLike[str] | None = None, resume: bool = False
) -> Case:
    """Read a case file and set its study up.

    Parameters
    ----------
    folder : path, optional
        Where the log and the evaluations go.
    resume : bool
        Go on where the log there ends.

    Raises
    ------
    InputError
        If the file is no TOML or says something that no case can say.
    """
    try:
        values = tomllib.loads(read_bytes(path).decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{os.fspath(path)} is no TOML file: {error}") from error
    try:
        return build(values, Path(path).parent, None if folder is None else Path(folder), resume)
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from error


def build(values: dict[str, Any], beside: Path, folder: Path | None, resume: bool) -> Case:
    """Case from the tables of a file that lies in `beside`."""
    unknown = set(values) - set(TABLES)
    if unknown:
        raise InputError(f"a case knows no [{sorted(unknown)[0]}]; it knows {', '.join(TABLES)}")
    tables = {name: Table(values.get(name, {}), name) for name in TABLES if name != "constraints"}
    kind = tables["objective"].values.get("kind")
    shape = _shape(tables["shape"], beside, whole=kind == "program")
    follower = tables["shape"].take("mesh", str, "")
    mesh = read_mesh(beside / follower) if follower else shape.mesh
    rest = _lattice(tables["lattice"], shape)
    rules = rules_of(tables["variables"], shape)
    objective = objective_of(tables["objective"], shape, beside, folder, resume)
    method = tables["method"]
    task = Task(
        objective,
        embed(rest, shape.points),
        shape.surface,
        rules,
        metric=method.choice("metric", METRICS, "h1"),
        constraints=[
            constraint_of(Table(c, "constraints"), shape) for c in values.get("constraints", [])
        ],
        penalty=method.take("penalty", float, 1e3),
    )
    study = Study(
        task,
        method.choice("name", tuple(METHODS), "lbfgs"),
        _refinement(tables["refinement"]) if "refinement" in values else None,
        _budget(tables["budget"]),
        carry_memory=method.take("carry_memory", bool, True),
        folder=folder,
        resume=resume,
    )
    for table in tables.values():
        table.finish()
    return Case(shape, rest, task, study, mesh)


def _shape(table: Table, beside: Path, whole: bool) -> Shape:
    source = table.take("source", str)
    count, marker = table.take("points", int, 161), table.take("marker", str, "")
    if is_section(source):
        return section_shape(located(source, beside), count)
    if not marker:
        raise InputError("[shape] a mesh needs the name of a marker")
    return mesh_shape(located(source, beside), marker, whole)


def located(source: str, beside: Path) -> str:
    """Path beside the case file; names of sections stay as they are."""
    return source if is_section(source) and "." not in source else str(beside / source)


def _lattice(table: Table, shape: Shape) -> Lattice:
    counts = tuple(int(n) for n in table.numbers("shape"))
    degrees = table.numbers("degrees", None)
    lower, upper = table.numbers("lower", None), table.numbers("upper", None)
    margin = table.take("margin", float, 0.01)
    if degrees is None and shape.mesh is None and len(counts) == 2:
        degrees = [3, counts[1] - 1]
    whole = None if degrees is None else [int(p) for p in degrees]
    if lower is not None and upper is not None:
        return Lattice.box(_three(lower), _three(upper), counts, whole)
    seen = shape.points[shape.surface.mass > 0]
    return Lattice.around(seen, counts, whole, margin)


def _three(corner: list[float]) -> Any:
    return np.array((corner + [0.0, 0.0, 0.0])[:3])


def _refinement(table: Table) -> Refinement:
    names = table.take("directions", list, ["i"])
    if not names or not set(names) <= set("ijk"):
        raise InputError(f"[refinement] directions must be out of i, j, k, got {names}")
    return Refinement(
        indicator=table.take("indicator", str, "gain"),
        axes=tuple("ijk".index(name) for name in names),
        variables=table.take("variables", int),
        positions=table.take("positions", int, 5),
        insertions=table.take("insertions", int, 1),
        row_wise=table.take("row_wise", bool, False),
        iterations=table.take("iterations", int, None),
        slope=table.take("slope", float, None),
        share=table.take("share", float, None),
        relocate=table.take("relocate", bool, False),
        coarsen=table.take("coarsen", float, None),
    )


def _budget(table: Table) -> Budget:
    return Budget(
        table.take("evaluations", int, None),
        table.take("iterations", int, None),
        table.take("tolerance", float, None),
    )
