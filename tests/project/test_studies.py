"""Plans become studies of the document; indicators and the airfoil view beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.project.commands import AddLattice, InsertKnots, MovePoints, OpenMesh
from ffdstudio.project.document import Document
from ffdstudio.project.studies.indicator import bars
from ffdstudio.project.studies.plan import Limit, Plan, box_around, checked
from ffdstudio.project.studies.task import prepare
from ffdstudio.project.view.section_view import section_view


def _plane_mesh(contour):
    """Plane mesh that has a section as its only marker."""
    n = len(contour) - 1
    points = np.column_stack([contour[:-1], np.zeros(n)])
    ring = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    return Mesh(points, {"triangle": [[0, 1, 2]]}, {"foil": {"line": ring}}, dimension=2)


def _document(contour):
    document = Document()
    mesh = _plane_mesh(contour)
    document.do(OpenMesh("/nowhere/foil.su2", name="foil", mesh=mesh))
    return document


def _prepared(document, plan):
    plan = checked(plan, document.model)
    document.do(box_around(plan, document.model))
    return prepare(plan, document.model, document.model.active_lattice)


BASE = Plan("body1", "foil", target="naca2412", columns=5, variables=20)


def test_a_plan_of_the_document_does_what_the_command_line_does():
    prepared = _prepared(_document(naca4("0012", points=201)), BASE)
    last = prepared.study.run().iterates[-1]
    same = ffd.fit("naca0012", "naca2412", columns=10, start=5, relocate=False)
    assert last.variables == same.variables == 20
    assert last.measures["rms"] == pytest.approx(same.rms, rel=0.05)


def test_a_scaled_and_shifted_section_is_fitted_in_chords():
    contour = naca4("0012", points=201)
    unit = _prepared(_document(contour), BASE).study.run().iterates[-1]
    moved = _prepared(_document(2.5 * contour + [4, -1]), BASE).study.run().iterates[-1]
    assert moved.measures["rms"] == pytest.approx(unit.measures["rms"], rel=1e-3)


def test_limits_hold_at_the_end_of_a_study():
    limits = (Limit("max thickness", "at least", 0.12), Limit("lift", "equal to", 0.4, 1.0))
    plan = replace(
        BASE, objective="pressure", method="slsqp", metric="h1", angle=1.0, limits=limits,
        indicator="", columns=6,
    )  # fmt: skip
    prepared = _prepared(_document(naca4("0012", points=201)), plan)
    measured = prepared.study.run().iterates[-1].measures
    assert measured["violation: lift"] < 1e-6
    assert measured["violation: max thickness"] < 1e-6


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
    plan = Plan(
        "body1", lattice="lattice2", objective="surface", target=str(tmp_path / "raised.vtu"),
        directions="z", indicator="", metric="l2",
    )  # fmt: skip
    prepared = prepare(checked(plan, document.model), document.model, document.model.active_lattice)
    last = prepared.study.run().iterates[-1]
    assert last.measures["max_error"] < 1e-3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"target": " "}, "needs a target"),
        ({"marker": "far"}, "no airfoil section"),
        ({"directions": ""}, "a direction"),
        ({"objective": "surface"}, "build a lattice"),
    ],
)
def test_a_plan_that_cannot_begin_says_why(change, words):
    document = _document(naca4("0012", points=51))
    with pytest.raises(InputError, match=words):
        checked(replace(BASE, **change), document.model)


def test_the_tallest_bar_of_a_gradient_is_where_it_falls_most():
    document = _document(naca4("0012", points=201))
    document.do(box_around(BASE, document.model))
    item = document.model.active_lattice
    found = bars(BASE, document.model, item)
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
        plan = replace(BASE, indicator="")
        study = prepare(plan, trial.model, trial.model.active_lattice).study
        fits.append(study.run().iterates[-1].cost)
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
    document.do(box_around(BASE, document.model))
    item = document.model.active_lattice
    before = bars(BASE, document.model, item)
    place = item.rest.control_points[2, 1] + [0, 0.02, 0]
    document.do(MovePoints(item.key, ((2, 1),), (tuple(place),)))
    assert bars(BASE, document.model, document.model.active_lattice) != before
