"""Studies of the document: what they begin with, that they can be undone, saved and reopened."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.optimize.build.place import given
from ffdstudio.optimize.constraints.lift import LiftLimit
from ffdstudio.optimize.constraints.thickness import MaxThicknessLimit
from ffdstudio.optimize.methods.gauss_newton import GaussNewton
from ffdstudio.optimize.methods.slsqp import Slsqp
from ffdstudio.optimize.objectives.contour import ContourSpec
from ffdstudio.optimize.objectives.flow import FlowSpec
from ffdstudio.optimize.objectives.surface import SurfaceSpec
from ffdstudio.optimize.spec.parts import LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.commands import AddLattice, InsertKnots, MovePoints, OpenMesh
from ffdstudio.project.document import Document
from ffdstudio.project.studies.indicator import bars
from ffdstudio.project.studies.starting import checked, new_lattice, on_lattice, prepare
from ffdstudio.project.view.section_view import section_view


def _plane_mesh(contour):
    """Plane mesh that has a section as its only marker."""
    n = len(contour) - 1
    points = np.column_stack([contour[:-1], np.zeros(n)])
    ring = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    cell = [[0, n // 3, 2 * n // 3]]  # large: no study turns it inside out
    return Mesh(points, {"triangle": cell}, {"foil": {"line": ring}}, dimension=2)


def _document(contour):
    document = Document()
    mesh = _plane_mesh(contour)
    document.do(OpenMesh("/nowhere/foil.su2", name="foil", mesh=mesh))
    return document


def changed(study, **parts):
    """A study with keys of its tables replaced."""
    new = {}
    for table, values in parts.items():
        old = getattr(study, table)
        new[table] = msgspec.structs.replace(old, **values) if isinstance(values, dict) else values
    return msgspec.structs.replace(study, **new)


def _prepared(document, study):
    study = checked(study, document.model)
    document.do(new_lattice(study, document.model))
    return prepare(on_lattice(study, document.model.active), document.model)


BASE = StudySpec(
    shape=ShapeSpec(source=given("body1"), marker="foil", points=301),
    lattice=LatticeSpec(shape=(5, 2), degrees=(3, 1), margin=(0.01, 0.05)),
    objective=ContourSpec(target="naca2412"),
    method=GaussNewton(),
    refinement=RefinementSpec(variables=20),
)


def test_a_study_of_the_document_does_what_the_command_line_does():
    built = _prepared(_document(naca4("0012", points=201)), BASE)
    last = built.study.run().iterates[-1]
    same = ffd.fit("naca0012", "naca2412", columns=10, start=5, relocate=False)
    assert last.variables == same.variables == 20
    assert last.measures["rms"] == pytest.approx(same.rms, rel=0.05)


def test_a_scaled_and_shifted_section_is_fitted_in_chords():
    contour = naca4("0012", points=201)
    unit = _prepared(_document(contour), BASE).study.run().iterates[-1]
    moved = _prepared(_document(2.5 * contour + [4, -1]), BASE).study.run().iterates[-1]
    assert moved.measures["rms"] == pytest.approx(unit.measures["rms"], rel=1e-3)


def test_constraints_hold_at_the_end_of_a_study():
    study = changed(
        BASE,
        shape={"points": 161},
        lattice={"shape": (6, 2)},
        objective=FlowSpec(angles=(1.0,), target="naca2412"),
        constraints=(MaxThicknessLimit(lower=0.12), LiftLimit(equal=0.4, angle=1.0)),
        method=Slsqp(),
        refinement=None,
    )
    built = _prepared(_document(naca4("0012", points=201)), study)
    measured = built.study.run().iterates[-1].measures
    assert measured["violation: lift"] < 1e-6
    assert measured["violation: max-thickness"] < 1e-6
    assert measured["cl@1"] == pytest.approx(0.4, abs=1e-6)


def test_the_angle_of_a_study_is_no_lift_coefficient():
    study = changed(
        BASE,
        shape={"points": 81},
        objective=FlowSpec(angles=(3.0,), lift=(0.6,)),
        method=Slsqp(),
        refinement=None,
    )
    last = _prepared(_document(naca4("0012", points=201)), study).study.run().iterates[-1]
    assert last.measures["cl@3"] == pytest.approx(0.6, abs=1e-3)


def test_a_surface_is_brought_to_a_target_mesh(tmp_path):
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)))
    k = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    quads = np.column_stack([k, k + 1, k + 10, k + 9])
    flat = Mesh(np.column_stack([x, y, 0 * x]), {"quad": quads}, dimension=3)
    raised = Mesh(np.column_stack([x, y, 0.2 * x**2]), {"quad": quads}, dimension=3)
    ffd.write_mesh(raised, tmp_path / "raised.vtu")
    document = Document()
    document.do(OpenMesh("/nowhere/flat.vtu", name="flat", mesh=flat))
    box = ffd.Lattice.box([-0.1, -0.1, -0.1], [1.1, 1.1, 0.1], (4, 4, 2), (3, 3, 1))
    document.do(AddLattice("Box", box, box))
    study = StudySpec(
        shape=ShapeSpec(source=given("body1")),
        lattice=LatticeSpec(file=given("lattice2")),
        variables=VariablesSpec(directions=("z",)),
        objective=SurfaceSpec(target=str(tmp_path / "raised.vtu")),
        method=GaussNewton(metric="l2"),
    )
    built = prepare(checked(study, document.model), document.model)
    assert built.study.run().iterates[-1].measures["max_error"] < 1e-3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"objective": {"target": " "}}, "target must be text"),
        ({"shape": {"marker": "far"}}, "no airfoil section"),
        ({"variables": {"directions": ()}}, "directions must be"),
        ({"objective": SurfaceSpec(target="x.stl"), "shape": {"marker": "far"}}, "build a lattice"),
        ({"constraints": (MaxThicknessLimit(lower=0.1),)}, "knows no constraints"),
        ({"lattice": {"file": given("lattice9")}}, "no lattice lattice9"),
    ],
)
def test_a_study_that_cannot_begin_says_why(change, words):
    document = _document(naca4("0012", points=51))
    with pytest.raises(InputError, match=words):
        checked(changed(BASE, **change), document.model)


def test_the_tallest_bar_of_a_gradient_is_where_it_falls_most():
    document = _document(naca4("0012", points=201))
    document.do(new_lattice(BASE, document.model))
    item = document.model.active_lattice
    found = bars(BASE, document.model, item, "gain")
    assert {bar.axis for bar in found} == {0, 1}
    ends = np.unique(item.rest.knots[0])
    along = [bar for bar in found if bar.axis == 0]
    assert [bar.low for bar in along] == ends[:-1].tolist()
    best = max(found, key=lambda bar: bar.score)
    fits = []
    for bar in along:
        trial = Document()
        trial.replace(document.model, {}, None)
        trial.do(InsertKnots(item.key, 0, (bar.knot,)))
        still = on_lattice(changed(BASE, refinement=None), item.key)
        fits.append(prepare(still, trial.model).study.run().iterates[-1].cost)
    assert along[int(np.argmin(fits))] == best


def test_the_view_of_a_section_shows_errors_and_pressures():
    contour = np.column_stack([naca4("0012", points=101), np.zeros(201)])
    moved = contour + [0, 1, 0] * np.sin(np.pi * contour[:, :1]) * 1e-3
    view = section_view(contour, moved, "naca0012", 0.0)
    crest = np.argmin(np.abs(view.current[:60, 0] - 0.5))
    assert view.error[crest] == pytest.approx(1e-3, rel=0.02)
    assert view.aim.lift == pytest.approx(0.0, abs=1e-6)
    assert view.pressure.lift > 0.001
    assert view.pressure.cp.max() <= 1.0 + 1e-9


def test_a_drag_moves_what_is_studied():
    document = _document(naca4("0012", points=101))
    document.do(new_lattice(BASE, document.model))
    item = document.model.active_lattice
    before = bars(BASE, document.model, item, "gain")
    place = item.rest.control_points[2, 1] + [0, 0.02, 0]
    document.do(MovePoints(item.key, ((2, 1),), (tuple(place),)))
    assert bars(BASE, document.model, document.model.active_lattice, "gain") != before
