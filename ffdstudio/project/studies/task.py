"""A plan made into a study: objective, embedding, variables, constraints, and who judges.

1. Sections are optimized in chords (see `chords.Chord`), on 301 cosine-spaced points of the
   spline through the mesh's nodes (161 for a flow), whatever the mesh's own spacing is.
2. They are judged on 2001 other points, embedded once and carried through refinements.
3. All of it takes a while and belongs into a worker.
"""

from __future__ import annotations

import shlex
import tempfile
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.embedding import Embedding
from ffdstudio.errors import InputError
from ffdstudio.optimize import constraints as measures
from ffdstudio.optimize.catalog.methods import method_kind
from ffdstudio.optimize.consent import located
from ffdstudio.optimize.constraints import Constraint, placed
from ffdstudio.optimize.fits.fitting import TRIGGERS
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.geometry.sections import (
    DENSE_POINTS,
    FIT_POINTS,
    kulfan_tolerance,
    target_contour,
)
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.chords import InChords
from ffdstudio.optimize.objectives.distance import ContourDistance, SurfaceDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.runs.study import Study, Task
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.project.commands.iterate import in_space_of
from ffdstudio.project.model import Body, LatticeItem, Model
from ffdstudio.project.studies.plan import Limit, Plan, profile_of, start_points

FLOW_POINTS = 161
UNITS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass
class ErrorMonitor:
    """Measures the errors of a lattice on points of its own.

    Attributes
    ----------
    embedding : Embedding
        In the lattice at rest.
    distance : object
        With `distances(points)`; None where there is no target shape.
    chord : Chord or None
        Of a section, whose errors are in chords.
    """

    embedding: Embedding
    distance: Any = None
    chord: Chord | None = None
    _latest: Embedding | None = field(default=None, repr=False)

    def points(self, current: Lattice) -> Array:
        """(n, 3) points under a lattice, in chords if it is a section."""
        latest = self._latest
        if latest is None or not latest.lattice.same_space(current):
            rest = self.embedding.lattice
            latest = self._latest = self.embedding.refined(in_space_of(rest, current))
        points = latest.deform(current)
        return points if self.chord is None else self.chord.local(points)

    def figures(self, current: Lattice) -> dict[str, float]:
        """RMS and largest error, and Kulfan's ratio of a section."""
        if self.distance is None:
            return {}
        points = self.points(current)
        error = np.abs(self.distance.distances(points)[0])
        found = {"rms": float(np.sqrt(np.mean(error**2))), "max_error": float(error.max())}
        if self.chord is not None:
            found["kulfan_ratio"] = float((error / kulfan_tolerance(points[:, 0])).max())
        return found


@dataclass
class Prepared:
    """A study that can run."""

    study: Study
    judge: ErrorMonitor


def prepare(plan: Plan, model: Model, item: LatticeItem) -> Prepared:
    """Make the study of a plan on a lattice of the model.

    Raises
    ------
    InputError
        If the target cannot be read, or plan and lattice do not fit.
    """
    task, judge = task_of(plan, model, item)
    return Prepared(
        Study(
            task,
            method_kind(plan.method)(carry_memory=plan.carry),
            refinement_of(plan),
            plan.budget,
        ),
        judge,
    )


def task_of(plan: Plan, model: Model, item: LatticeItem) -> tuple[Task, ErrorMonitor]:
    """Objective and variables of a plan, and who judges."""
    body = model.body(plan.body)
    make = _section if plan.plane else _program if plan.objective == "program" else _surface
    objective, embedding, surface, judge, triangles = make(plan, model, body, item)
    rules = _rules(plan, item.rest)
    limits = [_constraint(limit, judge.chord, triangles) for limit in plan.limits]
    current = item.current if item.deformed else None
    task = Task(
        objective, embedding, surface, rules, current, metric=plan.metric, constraints=limits,
        monitor=judge.figures,
    )  # fmt: skip
    return task, judge


def refinement_of(plan: Plan) -> Refinement | None:
    """How the plan refines; None if it does not."""
    if not plan.indicator:
        return None
    when: dict[str, Any] = dict(TRIGGERS.get(plan.method, {"slope": 0.7}))
    if plan.every is not None:
        when = {"iterations": plan.every}
    return Refinement(
        plan.indicator, plan.axes, plan.variables, insertions=plan.insertions,
        row_wise=plan.row_wise, **when,
    )  # fmt: skip


def _rules(plan: Plan, rest: Lattice) -> Rules:
    mirror = None
    if plan.mirrored is not None and plan.mirrored < rest.dimension:
        normal = rest.axes[plan.mirrored]
        mirror = (plan.mirrored, (float(normal[0]), float(normal[1]), float(normal[2])))
    directions = tuple(UNITS[letter] for letter in plan.directions)
    return Rules(directions, plan.frozen, mirror=mirror)


# ---- sections ----------------------------------------------------------------------------


def _section(plan: Plan, model: Model, body: Body, item: LatticeItem) -> Any:
    nodes = start_points(model, body, item)[profile_of(body, plan.marker).nodes]
    chord = Chord.of(nodes)
    contour = Contour.through(chord.local(nodes))
    target = target_contour(plan.target) if plan.target else None
    dense = contour.sample(DENSE_POINTS)
    distance = None if target is None else ContourDistance(target, upper_side(dense))
    judge = ErrorMonitor(embed(item.rest, chord.world(dense)), distance, chord)
    flow = plan.objective != "contour"
    points = contour.sample(FLOW_POINTS if flow else FIT_POINTS)
    objective: Objective
    if plan.objective == "lift":
        objective = FlowTarget([plan.angle], lift=[plan.lift])
    elif target is None:
        raise InputError("the objective needs a target")
    elif flow:
        objective = FlowTarget.like(target.sample(FLOW_POINTS), [plan.angle])
    else:
        objective = ContourDistance(target, upper_side(points))
    if chord != Chord(0.0, 0.0, 1.0):
        objective = InChords(objective, chord)
    surface = Surface.curve(points)
    if not flow:  # the mean is over points, not over length
        surface = Surface(np.full(len(points), 1 / len(points)), surface.slopes)
    return objective, _all_inside(item, chord.world(points)), surface, judge, None


def _all_inside(item: LatticeItem, points: Array) -> Embedding:
    embedding = embed(item.rest, points)
    if not embedding.inside.any():
        raise InputError(f"{item.name} holds no point of the shape")
    return embedding


# ---- surfaces ----------------------------------------------------------------------------


def _surface(plan: Plan, model: Model, body: Body, item: LatticeItem) -> Any:
    from ffdstudio.optimize.fits.task import surface_of

    triangles = _triangles(body, plan.marker)
    used, flat = np.unique(triangles, return_inverse=True)
    triangles = flat.reshape(-1, 3)
    points = start_points(model, body, item)[used]
    distance = SurfaceDistance(*surface_of(plan.target))
    embedding = _all_inside(item, points)
    judge = ErrorMonitor(embedding, distance)
    return distance, embedding, Surface.triangles(points, triangles), judge, triangles


def _program(plan: Plan, model: Model, body: Body, item: LatticeItem) -> Any:
    """All nodes of the mesh are seen; the marker tells where the metric lives."""
    from ffdstudio.optimize.objectives.program import ExternalProgram

    points, triangles = start_points(model, body, item), None
    if body.mesh.dimension == 2:
        nodes = profile_of(body, plan.marker).nodes
        surface = Surface.edges(points, np.column_stack([nodes[:-1], nodes[1:]]))
    else:
        triangles = _triangles(body, plan.marker)
        surface = Surface.triangles(points, triangles)
    folder = tempfile.mkdtemp(prefix="ffdstudio-study-")
    command = located(_words(plan.target), body.path.parent)
    objective = ExternalProgram(command, folder, body.mesh, plan.sensitivity, plan.time_limit)
    embedding = _all_inside(item, points)
    return objective, embedding, surface, ErrorMonitor(embedding), triangles


def _words(command: str) -> list[str]:
    try:
        return shlex.split(command)
    except ValueError as error:  # a quotation without its end
        raise InputError(f"the command {command!r} cannot be understood: {error}") from None


def _triangles(body: Body, marker: str) -> NDArray[np.int64]:
    cells = body.mesh.markers[marker] if marker else body.mesh.cells
    parts = [cells[kind] for kind in ("triangle",) if kind in cells]
    if "quad" in cells:
        parts += [cells["quad"][:, [0, 1, 2]], cells["quad"][:, [0, 2, 3]]]
    if not parts or body.mesh.dimension == 2:
        part = f"the marker {marker} of {body.name}" if marker else body.name
        raise InputError(f"{part} has no surface of triangles or quads")
    return np.concatenate(parts)


# ---- constraints -------------------------------------------------------------------------


def _constraint(limit: Limit, chord: Chord | None, triangles: Any) -> Constraint:
    quantity: Any = _quantity(limit, triangles)
    if chord is not None and chord != Chord(0.0, 0.0, 1.0):
        quantity = placed.InChords(quantity, chord)
    lower = limit.value if limit.relation != "at most" else None
    upper = limit.value if limit.relation != "at least" else None
    return Constraint(quantity, lower, upper, limit.quantity)


def _quantity(limit: Limit, triangles: Any) -> Any:
    if (limit.quantity == "volume") != (triangles is not None):
        raise InputError(f"a constraint on the {limit.quantity} does not fit this shape")
    if limit.quantity == "volume":
        return measures.Volume(triangles)
    simple: dict[str, Any] = {
        "area": measures.Area,
        "max thickness": measures.MaxThickness,
        "nose radius": measures.NoseRadius,
    }
    at_places: dict[str, Any] = {
        "thickness": measures.Thickness,
        "lift": measures.Lift,
        "moment": measures.Moment,
    }
    if limit.quantity in simple:
        return simple[limit.quantity]()
    return at_places[limit.quantity](limit.place)
