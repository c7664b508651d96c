"""Objectives, constraints and rules of a case file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.optimize import constraints as limits
from ffdstudio.optimize.contour import upper_side
from ffdstudio.optimize.identity import identity, module_files, program_files
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.distance import ContourDistance, SurfaceDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.objectives.function import PythonFunction
from ffdstudio.optimize.objectives.neural import NeuralFoil
from ffdstudio.optimize.objectives.program import ExternalProgram
from ffdstudio.optimize.objectives.remembered import Remembered
from ffdstudio.optimize.panel import PanelFlow
from ffdstudio.optimize.rules import Rules
from ffdstudio.optimize.sections import target_contour
from ffdstudio.optimize.shapes import Shape, is_section
from ffdstudio.optimize.tables import Table

LETTERS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def rules_of(table: Table, shape: Shape) -> Rules:
    """Rules of ``[variables]``."""
    flat = shape.triangles is None
    words = table.take("directions", list, ["y"] if flat else ["x", "y", "z"])
    if not words or not all(word in LETTERS for word in words):
        raise InputError(f"[variables] directions must be out of x, y, z, got {words}")
    mirror, normal = table.take("mirror", str, ""), table.numbers("mirror_normal", [0.0, 1.0, 0.0])
    linked = table.take("linked", list, [])
    for word in [*linked, *([mirror] if mirror else [])]:
        if word not in ("i", "j", "k"):
            raise InputError(f"[variables] a direction of the lattice is i, j or k, not {word!r}")
    return Rules(
        directions=tuple(LETTERS[word] for word in words),
        frozen=table.take("frozen", int, 0),
        fixed=tuple(tuple(int(i) for i in index) for index in table.take("fixed", list, [])),
        mirror=("ijk".index(mirror), tuple(normal)) if mirror else None,
        linked=tuple("ijk".index(word) for word in linked),
        weights=_bounds(table),
    )


def _bounds(table: Table) -> tuple[float, float] | None:
    weights = table.numbers("weights", None)
    if weights is None:
        return None
    if len(weights) != 2:
        raise InputError(f"[variables] weights must be [lower, upper], got {weights}")
    return weights[0], weights[1]


def objective_of(
    table: Table, shape: Shape, beside: Path, folder: Path | None, resume: bool = False
) -> Objective:
    """Objective of ``[objective]``; expensive ones are remembered in the study's folder."""
    settings = dict(table.values)
    kind = table.choice("kind", tuple(_OBJECTIVES))
    found = _OBJECTIVES[kind](table, shape, beside, folder)
    if folder is None:
        return found
    if isinstance(found, ExternalProgram):
        mesh = [] if shape.mesh is None or shape.mesh.path is None else [Path(shape.mesh.path)]
        files = [*program_files(found.command), *mesh]
    elif isinstance(found, PythonFunction):
        files = module_files(str(found.name))
    elif isinstance(found, NeuralFoil):
        files = []
    else:
        return found
    return Remembered(found, folder / "evaluations", identity(settings, files), resume)


def _contour(table: Table, shape: Shape, beside: Path, folder: Path | None) -> Objective:
    return ContourDistance(_target(table.take("target", str), beside), upper_side(shape.points))


def _surface(table: Table, shape: Shape, beside: Path, folder: Path | None) -> Objective:
    from ffdstudio.optimize.fit_task import surface_of

    return SurfaceDistance(*surface_of(str(beside / table.take("target", str))))


def _flow(table: Table, shape: Shape, beside: Path, folder: Path | None) -> Objective:
    angles = table.numbers("angles")
    target, pressure = table.take("target", str, ""), None
    if target:
        contour, upper = _target(target, beside), upper_side(shape.points)
        nodes = contour.at(shape.points[:, 0], upper)
        pressure = PanelFlow(nodes, angles).pressure
    return FlowTarget(angles, pressure, table.numbers("lift", None), table.numbers("moment", None))


def _target(name: str, beside: Path) -> Any:
    return target_contour(name if is_section(name) and "." not in name else str(beside / name))


def _function(table: Table, shape: Shape, beside: Path, folder: Path | None) -> Objective:
    return PythonFunction(
        table.take("name", str),
        table.take("gradient", bool, False),
        table.take("processes", int, 1),
    )


def _program(table: Table, shape: Shape, beside: Path, folder: Path | None) -> Objective:
    if folder is None:
        raise InputError("an external program needs a folder for its evaluations: -o DIR")
    command = [str(word) for word in table.take("command", list)]
    command = [_beside(word, beside) for word in command]
    return ExternalProgram(
        command,
        folder / "runs",
        shape.mesh,
        table.take("sensitivity", bool, False),
        table.take("time_limit", float, 3600.0),
        table.take("processes", int, 1),
    )


def _beside(word: str, beside: Path) -> str:
    path = beside / word
    return str(path.resolve()) if "/" in word and path.exists() else word


def _neural(table: Table, shape: Shape, beside: Path, folder: Path | None) -> Objective:
    return NeuralFoil(
        table.take("angle", float),
        table.take("reynolds", float),
        table.take("lift", float),
        table.take("weight", float, 1.0),
    )


_OBJECTIVES: dict[str, Callable[[Table, Shape, Path, Path | None], Objective]] = {
    "contour": _contour,
    "surface": _surface,
    "flow": _flow,
    "function": _function,
    "program": _program,
    "neuralfoil": _neural,
}


def constraint_of(table: Table, shape: Shape) -> limits.Constraint:
    """One of ``[[constraints]]``."""
    kind = table.choice("kind", tuple(_QUANTITIES))
    quantity = _QUANTITIES[kind](table, shape)
    lower, upper = table.take("lower", float, None), table.take("upper", float, None)
    equal = table.take("equal", float, None)
    table.finish()
    if equal is not None:
        lower = upper = equal
    return limits.Constraint(quantity, lower, upper, kind)


def _volume(table: Table, shape: Shape) -> limits.Quantity:
    if shape.triangles is None:
        raise InputError("[constraints] a volume needs a surface in 3D")
    return limits.Volume(shape.triangles)


def _displacement(table: Table, shape: Shape) -> limits.Quantity:
    letter = table.choice("direction", tuple(LETTERS))
    return limits.Displacement(shape.points, np.array(LETTERS[letter]))


_QUANTITIES: dict[str, Callable[[Table, Shape], limits.Quantity]] = {
    "lift": lambda table, shape: limits.Lift(table.take("angle", float)),
    "moment": lambda table, shape: limits.Moment(table.take("angle", float)),
    "thickness": lambda table, shape: limits.Thickness(table.numbers("at")),
    "max-thickness": lambda table, shape: limits.MaxThickness(),
    "area": lambda table, shape: limits.Area(),
    "volume": _volume,
    "nose-radius": lambda table, shape: limits.NoseRadius(),
    "displacement": _displacement,
}
