"""Objectives of a case file."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ffdstudio.engine import Lattice, embed
from ffdstudio.errors import InputError
from ffdstudio.optimize.cases.rules import of_kind
from ffdstudio.optimize.cases.schema import DEFORMED, OBJECTIVES
from ffdstudio.optimize.cases.tables import Table
from ffdstudio.optimize.consent import Consent, Kind, Order, located, require
from ffdstudio.optimize.flow.panel import PanelFlow
from ffdstudio.optimize.flow.pressure_table import panels, read_pressures
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.geometry.sections import target_contour
from ffdstudio.optimize.geometry.shapes import Shape, is_section
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.chords import InChords
from ffdstudio.optimize.objectives.distance import ContourDistance, SurfaceDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.objectives.function import PythonFunction
from ffdstudio.optimize.objectives.identity import identity, module_files, program_files
from ffdstudio.optimize.objectives.neural import NeuralFoil
from ffdstudio.optimize.objectives.program import ExternalProgram
from ffdstudio.optimize.objectives.remembered import Remembered

SECTIONS = ("contour", "flow", "neuralfoil")


class Place(NamedTuple):
    """Where a case lies, and where its results go.

    Attributes
    ----------
    beside : pathlib.Path
        Folder of the case file.
    folder : pathlib.Path or None
        Of the results.
    resume : bool
    source : pathlib.Path or None
        Project or record that the case came inside; None if the user names it.
    consent : Consent, optional
        What may run of a case that did; nothing by default.
    """

    beside: Path
    folder: Path | None = None
    resume: bool = False
    source: Path | None = None
    consent: Consent | None = None

    def located(self, source: str) -> str:
        """Path beside the case file; names of sections stay as they are."""
        plain = is_section(source) and "." not in source
        return source if plain else str(self.beside / source)


def objective_table(values: Any) -> Table:
    """``[objective]``, checked."""
    return Table(values, "objective", of_kind(values, "objective", OBJECTIVES)[1])


def objective_of(table: Table, values: Any, shape: Shape, place: Place) -> Objective:
    """Objective of ``[objective]``; expensive ones are remembered in the study's folder."""
    kind = table["kind"]
    if kind in SECTIONS and not shape.flat:
        raise InputError(f"[objective] {kind} needs a section, not a surface in 3D")
    if kind == "surface" and shape.flat:
        raise InputError("[objective] surface needs a surface in 3D, not a section")
    found = _OBJECTIVES[kind](table, shape, place)
    kept = _remembered(found, values, shape, place)
    if kind in SECTIONS and shape.chord is not None and not shape.chord.unit:
        return InChords(kept, shape.chord)
    return kept


def _remembered(found: Objective, values: Any, shape: Shape, place: Place) -> Objective:
    files: list[Path] = []
    if isinstance(found, ExternalProgram):
        mesh = [] if shape.mesh is None or shape.mesh.path is None else [Path(shape.mesh.path)]
        files = [*program_files(found.command), *mesh]
    elif isinstance(found, PythonFunction):
        files = module_files(str(found.name))
    elif not isinstance(found, NeuralFoil):
        return found
    if place.folder is None:
        return found
    said = identity(values, files)
    return Remembered(found, place.folder / "evaluations", said, place.resume)


def target_of(table: Table, place: Place) -> Contour | None:
    """Section that a contour or its pressures are to become."""
    if table["kind"] not in ("contour", "flow") or not table["target"]:
        return None
    return target_contour(place.located(table["target"]))


# ---- shapes and flows ----------------------------------------------------------------------


def _contour(table: Table, shape: Shape, place: Place) -> Objective:
    contour = target_of(table, place)
    assert contour is not None
    return ContourDistance(contour, upper_side(shape.local))


def _surface(table: Table, shape: Shape, place: Place) -> Objective:
    from ffdstudio.optimize.fits.task import surface_of

    points, triangles = surface_of(str(place.beside / table["target"]))
    if table["deformed"] is not None:
        points = deformed(points, Table(table["deformed"], "objective.deformed", DEFORMED))
    return SurfaceDistance(points, triangles)


def deformed(points: Any, table: Table) -> Any:
    """Points moved by a lattice around them whose control points make the moves of a table."""
    rest = Lattice.around(points, table["shape"], table["degrees"])
    control = rest.control_points.copy()
    for move in table["moves"]:
        index = tuple(int(k) for k in move[:3])
        if list(index) != move[:3] or not all(
            0 <= k < n for k, n in zip(index, rest.shape, strict=True)
        ):
            raise table.refuse("moves", f"there is no control point {move[:3]}")
        control[index] += move[3:]
    return embed(rest, points).deform(rest.moved(control))


def _flow(table: Table, shape: Shape, place: Place) -> Objective:
    angles, contour = table["angles"], target_of(table, place)
    if contour is not None and table["pressures"] is not None:
        raise table.refuse("pressures", "they go without a target section")
    pressure = None
    if contour is not None:
        nodes = contour.at(shape.local[:, 0], upper_side(shape.local))
        pressure = PanelFlow(nodes, angles).pressure
    if table["pressures"] is not None:
        tables = [read_pressures(place.beside / name) for name in table["pressures"]]
        pressure = np.array([one.at(*panels(shape.local)) for one in tables])
    weights = {name: table[f"{name}_weights"] for name in ("pressure", "lift", "moment")}
    return FlowTarget(angles, pressure, table["lift"], table["moment"], weights)


# ---- other people's programs ---------------------------------------------------------------


def _function(table: Table, shape: Shape, place: Place) -> Objective:
    """A module may lie beside the case file; spawned processes look there too."""
    _allowed("function", [table["name"]], place)
    beside = str(place.beside.resolve())
    if beside not in sys.path:
        sys.path.append(beside)
    return PythonFunction(table["name"], table["gradient"], table["processes"])


def _program(table: Table, shape: Shape, place: Place) -> Objective:
    if place.folder is None:
        raise InputError("an external program needs a folder for its evaluations: -o DIR")
    return ExternalProgram(
        located(_allowed("program", table["command"], place), place.beside),
        place.folder / "runs",
        shape.mesh,
        table["sensitivity"],
        table["time_limit"],
        table["processes"],
    )


def _allowed(kind: Kind, words: list[str], place: Place) -> list[str]:
    """The words of a program or function that may run."""
    require(Order(kind, tuple(words), place.source), place.consent or Consent())
    return words


def _neural(table: Table, shape: Shape, place: Place) -> Objective:
    return NeuralFoil(table["angle"], table["reynolds"], table["lift"], table["weight"])


_OBJECTIVES: dict[str, Callable[[Table, Shape, Place], Objective]] = {
    "contour": _contour,
    "surface": _surface,
    "flow": _flow,
    "function": _function,
    "program": _program,
    "neuralfoil": _neural,
}
