"""A run from its description.

1. Sections are optimized in chords (see `geometry.chord`), on the points that the description
   asks for, and judged on 2001 others that are embedded once and carried through refinements.
2. All of it takes a while and belongs into a worker.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from ffdstudio.engine import Lattice, embed
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, coverage, read_mesh
from ffdstudio.meshes.ways import Way
from ffdstudio.optimize.budget import Budget
from ffdstudio.optimize.build.lattice import Begun, lattice_of
from ffdstudio.optimize.build.monitor import ErrorMonitor
from ffdstudio.optimize.build.place import Place
from ffdstudio.optimize.build.rules import check_growth, refinement_of, rules_of
from ffdstudio.optimize.build.shape import moved, shape_of
from ffdstudio.optimize.consent import Consent, source_of
from ffdstudio.optimize.flow.response import SectionResponse
from ffdstudio.optimize.followers.body import FollowingMesh
from ffdstudio.optimize.followers.task import with_followers
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.chords import InChords
from ffdstudio.optimize.objectives.identity import identity
from ffdstudio.optimize.objectives.remembered import Remembered
from ffdstudio.optimize.runs.study import Study, Task
from ffdstudio.optimize.spec.codec import read_study
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.paths import refuse_links_out

Array = NDArray[np.float64]


@dataclass
class Built:
    """A study that can run.

    Attributes
    ----------
    spec : StudySpec
        What it was built from.
    place : Place
    shape : Shape
    begun : Begun
        The lattice as the study begins with it.
    task : Task
    study : Study
    monitor : ErrorMonitor
    memory : Remembered or None
        Of an expensive objective.
    """

    spec: StudySpec
    place: Place
    shape: Shape
    begun: Begun
    task: Task
    study: Study
    monitor: ErrorMonitor
    memory: Remembered | None = None

    @property
    def rest(self) -> Lattice:
        """The lattice at rest, before any refinement."""
        return self.begun.rest

    def before(self, mesh: Mesh) -> Array:
        """(n, 3) nodes of a mesh as the study finds them: earlier lattices have moved them."""
        return moved(mesh, self.spec.shape, self.place).points

    def keeping(self, bodies: Sequence[FollowingMesh]) -> Self:
        """The same study, which keeps the cells of bodies that follow it valid."""
        self.task = self.study.task = with_followers(self.task, bodies)
        return self

    def body_of(self, mesh: Mesh) -> FollowingMesh | None:
        """How a mesh follows; None of one that has no cells to keep valid."""
        kept = self.task.followers
        same = (b for b in kept if b.mesh is mesh or (mesh.path and b.mesh.path == mesh.path))
        return next(same, None)

    def followers(self) -> Iterator[Mesh]:
        """Meshes that follow the lattice; each is read when its turn comes."""
        names = self.spec.shape.followers
        if not names and self.shape.mesh is not None:
            yield self.shape.mesh
        for name in names:
            yield read_mesh(self.place.beside / name)


def build(spec: StudySpec, place: Place | None = None) -> Built:
    """Build the run that a description asks for.

    Parameters
    ----------
    spec : StudySpec
    place : Place, optional
        What its names stand for, and where results go; by default files in the working folder.

    Raises
    ------
    InputError
        If something that it names cannot be read, or its parts do not fit together.
    """
    place = place or Place()
    check_method(spec)
    return build_on(spec, place, shape_of(spec, place))


def build_on(spec: StudySpec, place: Place, shape: Shape) -> Built:
    """Build a run on a shape that is known already; see `build`."""
    check_shape(spec, shape)
    begun = lattice_of(spec.lattice, shape, place)
    plain = spec.objective.build(shape, place)
    memory = _memory(plain, spec, shape, place)
    monitor = ErrorMonitor.of(shape, begun.rest, spec.objective.judged(plain, place))
    task = _task(spec, shape, begun, _in_units(memory or plain, spec, shape), monitor)
    study = _study(spec, place, task)
    return Built(spec, place, shape, begun, task, study, monitor, memory)


def read_case(
    path: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    resume: bool = False,
    consent: Consent | None = None,
) -> Built:
    """Read a case file and build its study.

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
    spec = read_study(path)
    target = None if folder is None else Path(folder)
    if target is not None and resume:
        refuse_links_out(target)
    place = Place(
        Path(path).parent, target, resume, source=source_of(path), consent=consent or Consent()
    )  # fmt: skip
    try:
        built = build(spec, place)
        return built.keeping(following_meshes(built))
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from error


def following_meshes(built: Built) -> list[FollowingMesh]:
    """The meshes that a case names, or that its shape lies in, bound to its lattice."""
    way = Way(built.spec.shape.follow)
    return [
        FollowingMesh.of(mesh, built.rest, built.before(mesh), way=way)
        for mesh in built.followers()
        if coverage(mesh).checked
    ]


# ---- checks --------------------------------------------------------------------------------


def check_method(spec: StudySpec) -> None:
    """Refuse a method that can do less than the study needs."""
    method, name = spec.method, spec.method.kind()
    if method.residuals and spec.constraints:
        raise InputError(
            f"[method] name: {name} knows no constraints: use slsqp, or lbfgs, by penalty"
        )
    if method.residuals and not spec.objective.residuals:
        raise InputError(
            f"[method] name: {name} needs residuals, which {spec.objective.kind()} does not have: "
            "use lbfgs"
        )


def check_shape(spec: StudySpec, shape: Shape) -> None:
    """Refuse an objective that is about another kind of shape."""
    needs = spec.objective.needs
    if needs != "any" and (needs == "section") != shape.flat:
        wanted = "a section, not a surface in 3D"
        if needs == "surface":
            wanted = "a surface in 3D, not a section"
        raise InputError(f"[objective] {spec.objective.kind()} needs {wanted}")


# ---- parts ---------------------------------------------------------------------------------


def _memory(plain: Objective, spec: StudySpec, shape: Shape, place: Place) -> Remembered | None:
    """The memory of an expensive objective in the study's folder."""
    files = spec.objective.files(shape, place)
    if files is None or place.folder is None:
        return None
    said = identity(msgspec.to_builtins(spec.objective), files)
    return Remembered(plain, place.folder / "evaluations", said, place.resume)


def _in_units(objective: Objective, spec: StudySpec, shape: Shape) -> Objective:
    about_sections = spec.objective.needs == "section"
    if about_sections and shape.chord is not None and not shape.chord.unit:
        return InChords(objective, shape.chord)
    return objective


def _task(
    spec: StudySpec, shape: Shape, begun: Begun, objective: Objective, monitor: ErrorMonitor
) -> Task:
    embedding = embed(begun.rest, shape.points)
    if not embedding.inside.any():
        raise InputError("the lattice holds no point of the shape")
    return Task(
        objective,
        embedding,
        _surface(spec, shape),
        rules_of(spec.variables, shape, begun.rest),
        begun.current,
        begun.knots,
        spec.method.metric,
        [limit.constraint(shape) for limit in spec.constraints],
        spec.method.penalty,
        monitor.figures,
        SectionResponse((spec.method.angle,), shape.chord, shape.contour) if shape.chord else None,
    )


def _surface(spec: StudySpec, shape: Shape) -> Surface:
    """Where the metric lives; with equal shares for a mean over points."""
    if not spec.objective.by_points:
        return shape.surface
    count = len(shape.points)
    return Surface(np.full(count, 1 / count), shape.surface.slopes)


def _study(spec: StudySpec, place: Place, task: Task) -> Study:
    limits, refinement = spec.budget, None
    if spec.refinement is not None:
        rest = task.embedding.lattice
        refinement = refinement_of(spec.refinement, task.rules, rest)
        check_growth(refinement, task.rules, rest)
    budget = Budget(limits.evaluations, limits.iterations, limits.tolerance)
    return Study(task, spec.method, refinement, budget, place.folder, place.resume)
