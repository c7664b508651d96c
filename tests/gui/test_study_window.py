"""Studies in the window: run, paused, stepped, stopped, scrubbed, used, refined by hand."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QTimer

from ffdstudio.meshes import Mesh, MeshWarning, write_mesh
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.optimize.methods.powell import Powell
from ffdstudio.optimize.objectives.program import ProgramSpec
from ffdstudio.project.commands import CreateBox
from ffdstudio.project.studies.starting import new_lattice

pytestmark = pytest.mark.display
PATIENCE = 60_000


@pytest.fixture
def foil(tmp_path: Path) -> Path:
    """Plane mesh: a ring of triangles around a NACA 0012."""
    ring = naca4("0012", points=61)[:-1]
    n = len(ring)
    outer = (ring - [0.5, 0]) * [1.6, 6] + [0.5, 0]
    points = np.column_stack([np.vstack([ring, outer]), np.zeros(2 * n)])
    k = np.arange(n)
    ahead = (k + 1) % n
    triangles = np.vstack(
        [np.column_stack([k, k + n, ahead]), np.column_stack([ahead, k + n, ahead + n])]
    )
    lines = np.column_stack([k, ahead])
    mesh = Mesh(points, {"triangle": triangles}, {"foil": {"line": lines}}, dimension=2)
    path = tmp_path / "foil.su2"
    with pytest.warns(MeshWarning):
        write_mesh(mesh, path)
    return path


@pytest.fixture
def studio(user, foil):
    """Window with the section open and the Study panel shown."""
    user.open(foil)
    user.trigger("study.setup")
    form = user.window.studies.panel.form
    form.objective.form.editors["target"].put("naca2412")
    form.refinement.editors["variables"].put(20)
    form.changed.emit()
    user.room, user.runner = user.window.studies, user.window.studies.runner
    user.room.panel.fill()
    return user


def _ended(user):
    user.qtbot.waitUntil(lambda: not user.runner.alive, timeout=PATIENCE)
    user.idle()


def _slow(user):
    """Make the study long: plain conjugate directions."""
    form = user.room.panel.form
    form.method.box.setCurrentIndex(form.method.box.findText(Powell.title))
    form.method.form.editors["metric"].put("none")
    form.refinement.editors["variables"].put(60)
    form.changed.emit()


def test_a_fit_runs_from_the_window_and_its_last_iterate_is_one_undoable_edit(studio):
    document = studio.window.document
    studio.trigger("study.start")
    assert not studio.room.panel.form.isEnabled()
    _ended(studio)
    run = studio.runner.run
    assert run.state == "done"
    assert run.iterates[-1].variables == 20
    assert studio.runner.showing
    assert studio.lattice.rest.shape == (10, 2)
    labels = document.history.labels
    studio.trigger("study.use")
    studio.idle()
    assert document.history.labels == [
        *labels, f"Use iterate {run.iterates[-1].iteration} of Study 1",
    ]  # fmt: skip
    view = studio.room.airfoil_view
    studio.qtbot.waitUntil(lambda: view.view is not None and view.view.rms < 1e-3, timeout=PATIENCE)
    studio.trigger("edit.undo")
    assert studio.lattice.rest.shape == (5, 2)
    assert studio.script.told == []


def test_the_timeline_scrubs_net_mesh_and_plots_together(studio):
    studio.trigger("study.start")
    _ended(studio)
    run, document = studio.runner.run, studio.window.document
    slider = studio.room.convergence.timeline.slider
    assert slider.maximum() == len(run.iterates) - 1
    assert slider.marks
    key = document.model.bodies[0].key
    last = document.points(key).copy()
    slider.setValue(0)
    studio.painted()
    assert studio.lattice.rest.shape == (5, 2)
    assert np.array_equal(document.points(key), document.model.bodies[0].mesh.points)
    assert studio.room.convergence.here.value() == run.column("evaluation")[0]
    slider.setValue(slider.maximum())
    studio.painted()
    assert np.array_equal(document.points(key), last)
    place = slider.marks[0]
    slider.setValue(place)
    studio.painted()
    assert studio.lattice.rest.shape[0] == run.iterates[place].variables // 2
    studio.trigger("study.release")
    assert not studio.runner.showing
    assert studio.lattice.rest.shape == (5, 2)


def test_the_status_line_tells_of_the_cells_of_the_iterate_that_is_shown(studio):
    studio.trigger("study.start")
    _ended(studio)
    document, cells = studio.window.document, studio.window.status.cells
    edit = document.editing
    studio.qtbot.waitUntil(lambda: edit.inverted is not None, timeout=PATIENCE)
    assert edit.note in cells.text()
    assert cells.text().endswith("no inverted cells")
    assert studio.room.panel.cells.text() == ""
    net = edit.shown.control_points.copy()
    net[:, -1, 1] -= 1.0  # the upper side below the lower one
    edit.show(edit.shown.moved(net), "iterate 99 of Study 1")
    studio.runner.shown_changed.emit()
    assert cells.text().endswith("iterate 99 of Study 1, cells not checked yet")
    studio.qtbot.waitUntil(lambda: bool(edit.inverted), timeout=PATIENCE)
    assert cells.text().endswith(f", {edit.inverted} inverted cells")
    assert str(edit.inverted) in studio.room.panel.cells.text()
    count, key = edit.inverted, document.model.bodies[0].key
    edit.commit()
    studio.idle()
    assert document.volume(key).inverted == count
    assert "iterate" not in cells.text()
    assert cells.text().endswith(f", {count} inverted cells")


def test_the_frozen_layers_of_the_chosen_lattice_are_offered(studio):
    form, document = studio.room.panel.form, studio.window.document
    document.do(CreateBox("Box", (-0.1, -0.2, 0.0), (1.1, 0.2, 0.0), (6, 4), (3, 3), frozen=1))
    assert form.lattice.currentText() == "Box"
    assert form.variables.editors["frozen"].value() == 1
    assert form.spec.variables.frozen == 1
    form.variables.editors["frozen"].put(0)
    document.do(CreateBox("Other", (-0.1, -0.2, 0.0), (1.1, 0.2, 0.0), (6, 4), (3, 3)))
    assert form.spec.variables.frozen == 0  # what the user has said stays
    form.lattice.setCurrentIndex(0)
    form.lattice.setCurrentIndex(form.lattice.findText("Box"))
    assert form.spec.variables.frozen == 1


def test_the_hint_of_the_points_panel_is_seen_whole_above_the_plots(studio):
    studio.room.convergence_plot()
    studio.room.airfoil()
    studio.qtbot.wait(100)
    hint = studio.window.points.hint
    assert hint.isVisible()
    assert hint.height() >= hint.heightForWidth(hint.width())


def test_notes_of_a_study_keep_all_their_lines_and_the_plots_their_width(studio):
    window = studio.window
    window.resize(1280, 720)
    studio.room.convergence_plot()
    studio.room.airfoil()
    studio.room.panel.begin()
    _ended(studio)
    studio.qtbot.wait(100)
    for label in (studio.room.panel.figures, studio.room.panel.shown):
        assert label.height() >= label.heightForWidth(label.width())
    assert studio.room.docks["Airfoil"].width() >= window.width() // 2
    view = studio.room.airfoil_view
    assert min(plot.width() for plot in (view.shape, view.error, view.pressure)) > 180
    assert view.lift.text().startswith("CL")


def test_a_study_is_stepped_paused_and_stopped(studio):
    _slow(studio)
    studio.trigger("study.step")
    runner = studio.runner
    studio.qtbot.waitUntil(lambda: runner.run is not None and runner.run.state == "paused")
    studio.qtbot.waitUntil(lambda: len(runner.run.iterates) == 2, timeout=PATIENCE)
    studio.qtbot.wait(200)
    assert len(runner.run.iterates) == 2
    studio.trigger("study.step")
    studio.qtbot.waitUntil(lambda: len(runner.run.iterates) == 3, timeout=PATIENCE)
    studio.trigger("study.pause")
    studio.qtbot.waitUntil(lambda: len(runner.run.iterates) > 4, timeout=PATIENCE)
    assert runner.run.state == "running"
    studio.trigger("study.stop")
    _ended(studio)
    assert runner.run.note == "stopped"
    assert runner.run.iterates


def test_closing_during_a_run_asks_and_stops_cleanly(studio):
    _slow(studio)
    studio.trigger("study.start")
    studio.qtbot.waitUntil(lambda: bool(studio.runner.run.iterates), timeout=PATIENCE)
    studio.script.answers = ["cancel"]
    studio.window.close()
    assert studio.window.isVisible()
    assert studio.runner.alive
    studio.trigger("study.pause")
    studio.script.answers = ["stop", "discard"]
    studio.window.close()
    assert not studio.window.isVisible()
    assert studio.script.asked[-2].title == "A study is running"


def test_cancelling_from_the_status_line_ends_a_paused_study(studio):
    _slow(studio)
    studio.trigger("study.start")
    studio.qtbot.waitUntil(lambda: bool(studio.runner.run.iterates), timeout=PATIENCE)
    studio.trigger("study.pause")
    studio.window.jobs.cancel_all()
    _ended(studio)
    assert studio.runner.run.state == "done"


def test_an_edit_during_a_run_keeps_what_is_seen_and_ends_following(studio):
    _slow(studio)
    studio.trigger("study.start")
    studio.qtbot.waitUntil(lambda: studio.runner.showing, timeout=PATIENCE)
    drag = studio.window.document.edit([(2, 1)])
    drag.translate([0.0, 0.05, 0.0])
    drag.commit()
    assert studio.window.document.history.labels[-1] == "Move point (2, 1)"
    before = len(studio.runner.run.iterates)
    studio.qtbot.waitUntil(lambda: len(studio.runner.run.iterates) > before, timeout=PATIENCE)
    assert not studio.runner.showing
    assert not studio.runner.following
    studio.trigger("study.stop")
    _ended(studio)


def test_what_is_wrong_with_a_plan_is_said_beside_the_buttons(studio):
    studio.room.panel.form.objective.form.editors["target"].put("/nowhere/foil.dat")
    studio.room.panel.form.changed.emit()
    studio.trigger("study.start")
    _ended(studio)
    assert "foil.dat" in studio.room.panel.problem.text()
    assert studio.runner.run.state == "failed"
    assert studio.script.told == []


def test_studies_are_overlaid_and_written(studio, tmp_path):
    studio.trigger("study.start")
    _ended(studio)
    studio.trigger("study.use")
    studio.trigger("study.start")
    _ended(studio)
    panel = studio.room.convergence
    assert len(panel._curves) == 2
    panel.overlay.setChecked(False)
    assert len(panel._curves) == 1
    panel.overlay.setChecked(True)
    for name, start in (("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.csv", b"evaluation,")):
        studio.script.targets = [tmp_path / name]
        studio.trigger("study.export")
        studio.idle()
        assert (tmp_path / name).read_bytes().startswith(start)
    panel.forget.click()
    assert len(studio.runner.runs) == 1


def test_a_bar_inserts_its_knot_and_the_shape_stays(studio):
    studio.trigger("study.start")
    _ended(studio)
    studio.trigger("study.use")
    studio.idle()
    studio.trigger("study.refine")
    panel, document = studio.room.refine_view, studio.window.document
    studio.qtbot.waitUntil(lambda: bool(panel.bars), timeout=PATIENCE)
    studio.idle()
    key = document.model.bodies[0].key
    points, columns = document.points(key).copy(), studio.lattice.rest.shape[0]
    bar = max((b for b in panel.bars if b.axis == 0 and b.knot), key=lambda b: b.score)
    panel.insert(bar)
    studio.idle()
    assert studio.lattice.rest.shape[0] == columns + 1
    assert document.history.labels[-1].startswith("Insert")
    assert np.allclose(document.points(key), points, atol=1e-12)
    studio.qtbot.waitUntil(
        lambda: len([b for b in panel.bars if b.axis == 0]) == columns - 2, timeout=PATIENCE
    )


def test_the_airfoil_view_follows_a_drag_by_hand(studio):
    studio.trigger("study.airfoil")
    spec = studio.room.panel.form.spec
    studio.window.document.do(new_lattice(spec, studio.window.document.model))
    studio.idle()
    view = studio.room.airfoil_view
    studio.qtbot.waitUntil(lambda: view.view is not None, timeout=PATIENCE)
    studio.idle()
    lift = view.view.pressure.lift
    drag = studio.window.document.edit([(2, 0), (2, 1)])
    drag.translate([0.0, 0.02, 0.0])
    studio.qtbot.waitUntil(
        lambda: view.view.pressure.lift > lift + 0.005, timeout=PATIENCE
    )  # while the drag is still under way
    assert studio.window.document.editing is drag
    drag.abort()
    studio.qtbot.waitUntil(lambda: abs(view.view.pressure.lift - lift) < 1e-12, timeout=PATIENCE)


def test_panels_say_what_to_do_while_there_is_nothing(user):
    room = user.window.studies
    for name in ("setup", "convergence_plot", "airfoil"):
        user.trigger(f"study.{name}")
    assert room.panel.pages.currentIndex() == 0
    assert room.airfoil_view.pages.currentIndex() == 0
    assert "Start a study" in room.convergence.timeline.text.text()
    for theme in ("dark", "light"):
        user.trigger(f"view.{theme}")


def test_the_window_answers_while_a_study_runs(studio):
    """A clock of the window's own loop; medians, for the machine may be busy elsewhere."""
    _slow(studio)
    ticks: list[float] = []
    clock = QTimer()
    clock.setInterval(5)
    clock.timeout.connect(lambda: ticks.append(time.perf_counter()))
    studio.trigger("study.start")
    studio.qtbot.waitUntil(lambda: bool(studio.runner.run.iterates), timeout=PATIENCE)
    clock.start()
    studio.qtbot.waitUntil(lambda: len(ticks) > 100, timeout=PATIENCE)
    clock.stop()
    studio.trigger("study.stop")
    _ended(studio)
    assert len(studio.runner.run.iterates) > 1


PROGRAM = """
import json, sys
rows = [[float(w) for w in line.split(",")] for line in open("points.csv")]
number = int(__import__("os").path.basename(__import__("os").getcwd()))
if number > LAST:
    FAIL
value = sum((y - 0.02) ** 2 for _, y, _ in rows) / len(rows)
json.dump({"value": value}, open("result.json", "w"))
with open("sensitivity.csv", "w") as out:
    for _, y, _ in rows:
        out.write(f"0,{2 * (y - 0.02) / len(rows)},0\\n")
"""


@pytest.mark.parametrize(
    ("fail", "words"),
    [
        ("sys.exit('no licence')", "no licence"),
        ("import time; time.sleep(60)", "took more than"),
        ("open('result.json', 'w').write('nonsense'); sys.exit()", "does not hold a value"),
        ("pass", ""),
    ],
)
def test_a_program_drives_a_study_and_its_failure_loses_nothing(studio, foil, fail, words):
    import sys

    script = foil.with_name("solver.py")
    script.write_text(PROGRAM.replace("LAST", "3").replace("FAIL", fail))
    form = studio.room.panel.form
    form.objective.box.setCurrentIndex(form.objective.box.findText(ProgramSpec.title))
    editors = form.objective.form.editors
    editors["command"].put((sys.executable, "./solver.py"))
    editors["sensitivity"].put(True)
    editors["time_limit"].put(3.0)
    form.refine.setChecked(False)
    form.budget.editors["iterations"].put(4)
    form.changed.emit()
    studio.trigger("study.start")
    _ended(studio)
    run = studio.runner.run
    assert len(run.iterates) > 1
    assert run.iterates[-1].cost < run.iterates[0].cost
    assert words in studio.room.panel.problem.text()
    assert studio.runner.showing
    assert studio.script.told == []
