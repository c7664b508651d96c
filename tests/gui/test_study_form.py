"""The form of a study is made from the catalog: what it shows is what it says."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication, QComboBox, QSpinBox

from ffdstudio.optimize.build.place import given
from ffdstudio.optimize.constraints.lift import LiftLimit
from ffdstudio.optimize.objectives.flow import FlowSpec
from ffdstudio.optimize.spec.codec import from_values, to_values
from tests.gui.test_study_window import foil  # noqa: F401 - a fixture
from tests.optimize.catalog_rows import EVERY

pytestmark = pytest.mark.display
PATIENCE = 60_000


@pytest.fixture
def form(user, foil):  # noqa: F811
    user.open(foil)
    user.trigger("study.setup")
    user.window.studies.panel.fill()
    return user.window.studies.panel.form


@pytest.fixture
def key(user, form):
    return user.window.document.model.bodies[0].key


FLAT = {name: spec for name, spec in EVERY.items() if spec.objective.needs != "surface"
        and all(c.needs != "surface" for c in spec.constraints)}  # fmt: skip


def test_for_every_row_the_form_says_what_it_is_given(user, form, key):
    for name, spec in FLAT.items():
        shape = msgspec.structs.replace(spec.shape, source=given(key), marker="foil")
        spec = msgspec.structs.replace(spec, shape=shape)
        form.put(spec)
        assert form.wrong == "", name
        assert form.spec == spec, name
        assert from_values(to_values(form.spec)) == spec, name


def test_angle_and_lift_are_what_their_fields_say(form, key):
    form.objective.box.setCurrentIndex(form.objective.box.findText(FlowSpec.title))
    editors = form.objective.form.editors
    editors["target"].put("")
    for name, text in (("angles", "1.25, 3"), ("lift", "0.125 0.375"), ("moment", "-0.05 -0.1")):
        editors[name].line.setText(text)
        editors[name].line.textEdited.emit(text)
    goal = form.spec.objective
    assert (goal.angles, goal.lift, goal.moment) == ((1.25, 3), (0.125, 0.375), (-0.05, -0.1))


def test_a_constraint_says_beside_itself_what_it_lacks(form):
    form.limits.add.click()
    assert form.spec is None
    assert form.problem.text() == "Angle: a number is needed."
    row = form.limits.rows[0]
    assert row.kind is LiftLimit
    row.form.editors["angle"].line.setText("2")
    row.form.edited.emit()
    assert "lift has no limit" in form.problem.text()
    row.form.editors["lower"].line.setText("0,125")
    row.form.edited.emit()
    assert form.spec.constraints == (LiftLimit(angle=2.0, lower=0.125),)
    assert form.problem.text() == ""
    assert form.spec.method.constraints  # Gauss-Newton keeps none: another one was taken


def test_the_wheel_scrolls_and_changes_nothing(form):
    before = form.spec
    boxes = [*form.findChildren(QComboBox), *form.findChildren(QSpinBox)]
    assert len(boxes) > 8
    for box in boxes:
        place = QPointF(box.rect().center())
        event = QWheelEvent(
            place, place, QPoint(0, -120), QPoint(0, -120), Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(box, event)
    assert form.spec == before


def test_a_case_file_is_saved_and_loaded(user, form, key, tmp_path: Path):
    form.refinement.editors["variables"].put(33)
    form.budget.editors["tolerance"].put(1.5e-9)
    form.changed.emit()
    spec = form.spec
    user.script.targets = [tmp_path / "mine.toml"]
    user.trigger("study.save_case")
    user.idle()
    assert (tmp_path / "mine.toml").exists()
    form.refinement.editors["variables"].put(44)
    assert form.spec != spec
    user.window.studies.panel.take_case(tmp_path / "mine.toml")
    assert form.spec == spec


def test_a_case_about_another_mesh_opens_it(user, form, root, tmp_path: Path):
    case = tmp_path / "other.toml"
    mesh = root / "sample_meshes" / "naca0012.su2"
    case.write_text(
        f'[shape]\nsource = "{mesh}"\nmarker = "airfoil"\n[lattice]\nshape = [6, 2]\n'
        '[objective]\nkind = "flow"\nangles = [3.0]\nlift = [0.5]\n'
    )
    user.window.studies.panel.take_case(case)
    user.qtbot.waitUntil(
        lambda: len(user.window.document.model.bodies) == 2
        and form.spec is not None and form.spec.shape.marker == "airfoil",
        timeout=PATIENCE,
    )  # fmt: skip
    user.idle()
    assert form.spec.shape.source == given(user.window.document.model.bodies[1].key)
    assert form.spec.objective.angles == (3.0,)
    assert form.spec.lattice.shape == (6, 2)


def test_reopened_studies_have_plots_timeline_and_use(user, form, tmp_path: Path):
    window, runner = user.window, user.window.studies.runner
    form.refinement.editors["variables"].put(12)
    form.changed.emit()
    for _ in range(3):
        user.trigger("study.start")
        user.qtbot.waitUntil(lambda: not runner.alive, timeout=PATIENCE)
        user.idle()
        user.trigger("study.release")
    known = [(run.name, len(run.iterates), run.note) for run in runner.runs]
    assert len(known) == 3
    window.document.save(tmp_path / "three.ffdproj")
    user.idle()
    window.document.open(tmp_path / "three.ffdproj")
    user.idle()
    user.qtbot.waitUntil(lambda: len(runner.runs) == 3, timeout=PATIENCE)
    assert [(run.name, len(run.iterates), run.note) for run in runner.runs] == known
    user.trigger("study.convergence_plot")
    panel = window.studies.convergence
    assert len(panel._curves) == 3
    run = runner.runs[1]
    runner.select(run)
    assert panel.timeline.slider.maximum() == len(run.iterates) - 1
    panel.timeline.slider.setValue(len(run.iterates) - 1)
    panel.timeline.slider.scrubbed.emit(len(run.iterates) - 1)
    user.idle()
    assert runner.showing
    user.trigger("study.use")
    user.idle()
    item = window.document.model.lattice(run.key)
    assert item.current == run.history.lattice(-1)
    assert window.document.history.labels[-1].endswith(run.name)


def test_studies_are_looked_at_renamed_duplicated_and_removed_in_a_table(user, form):
    window, runner, panel = user.window, user.window.studies.runner, user.window.studies.panel
    form.refinement.editors["variables"].put(10)
    form.changed.emit()
    assert not panel.table.isVisible()
    for _ in range(2):
        user.trigger("study.start")
        user.qtbot.waitUntil(lambda: not runner.alive, timeout=PATIENCE)
        user.idle()
        user.trigger("study.release")
    table = panel.table
    assert [table.item(k, 0).text() for k in range(2)] == [run.name for run in runner.runs]
    assert table.item(1, 3).text() == "10"
    assert table.item(1, 6).text() == "Ended"
    table.selectRow(0)
    assert runner.run is runner.runs[0]
    table.item(0, 0).setText("Match")
    assert window.document.model.studies[0].name == "Match"
    assert runner.runs[0].name == "Match"
    table.duplicated.emit(runner.runs[0])
    assert [item.name for item in window.document.model.studies][-1] == "Match copy"
    assert table.item(2, 6).text() == "Not begun"
    menu = table.menu(runner.runs[2])
    menu.actions()[2].trigger()
    assert form.spec == runner.runs[0].spec
    user.trigger("study.start")  # the copy is what the form says: it is begun
    user.qtbot.waitUntil(lambda: not runner.alive, timeout=PATIENCE)
    user.idle()
    assert len(runner.runs) == 3
    assert runner.runs[2].iterates
    user.trigger("study.release")
    menu.actions()[3].trigger()
    assert len(window.document.model.studies) == 2
    user.trigger("edit.undo")
    assert [run.name for run in runner.runs][-1] == "Match copy"
    assert runner.runs[2].iterates
    table.item(0, 0).setText(" ")
    assert window.document.model.studies[0].name == "Match"
    assert table.item(0, 0).text() == "Match"
