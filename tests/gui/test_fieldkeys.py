"""Keys in a field: what is typed is the field's, the rest is the program's."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

pytestmark = pytest.mark.display
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
Key = Qt.Key


@pytest.fixture
def ready(same_user, cube):
    """Window that has the keyboard, with one point selected."""
    same_user.open(cube)
    same_user.build()
    window = same_user.window
    window.activateWindow()
    same_user.qtbot.waitUntil(window.isActiveWindow)
    window.document.select([(1, 1, 1)])
    return same_user


def labels(user):
    return user.window.document.history.labels


def enter(user, field, text):
    field.setFocus()
    user.qtbot.waitUntil(field.hasFocus)
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Key.Key_Return)


def test_undo_after_a_number_was_taken_undoes_the_edit_and_leaving_adds_none(ready):
    points, history = ready.window.points, ready.window.document.history
    field = points.position.edits[0]
    enter(ready, field, "0.123456789")
    assert labels(ready)[-1] == "Move point (1, 1, 1)"
    QTest.keyClick(field, Key.Key_Z, CTRL)
    assert not ready.lattice.deformed
    points.weight.setFocus()
    assert history.redo_label == "Move point (1, 1, 1)"
    QTest.keyClick(points.weight, Key.Key_Z, CTRL | SHIFT)
    assert ready.lattice.current.control_points[1, 1, 1, 0] == 0.123456789


def test_undo_of_what_is_being_typed_is_the_fields(ready):
    field, before = ready.window.points.position.edits[0], labels(ready)
    field.setFocus()
    ready.qtbot.waitUntil(field.hasFocus)
    shown = field.text()
    field.selectAll()
    QTest.keyClicks(field, "0.7")
    while field.isUndoAvailable():
        QTest.keyClick(field, Key.Key_Z, CTRL)
    assert field.text() == shown
    ready.window.points.weight.setFocus()
    assert labels(ready) == before
    assert ready.window.document.history.redo_label is None


def test_a_field_whose_text_was_put_there_commits_nothing(ready):
    field, before = ready.window.points.position.edits[0], labels(ready)
    field.setFocus()
    field.setText("0.5")  # by a program, not by typing
    ready.window.points.weight.setFocus()
    QTest.keyClick(field, Key.Key_Return)
    assert labels(ready) == before


def test_undo_in_a_number_box_undoes_the_edit(ready):
    box = ready.window.lattice.summary.frozen
    enter(ready, box, "1")
    assert ready.lattice.frozen == 1
    QTest.keyClick(box, Key.Key_Z, CTRL)
    assert ready.lattice.frozen == 0
    assert box.value() == 0
    ready.window.viewport.setFocus()
    assert ready.window.document.history.redo_label is not None


def test_undo_while_a_number_box_is_typed_in_is_the_boxes(ready):
    box, before = ready.window.lattice.summary.frozen, labels(ready)
    box.setFocus()
    ready.qtbot.waitUntil(box.hasFocus)
    box.selectAll()
    QTest.keyClicks(box, "1")
    QTest.keyClick(box, Key.Key_Z, CTRL)
    assert labels(ready) == before
    assert ready.window.document.history.redo_label is None


@pytest.mark.parametrize(
    ("key", "name"),
    [
        (Key.Key_E, "file.export_mesh"),
        (Key.Key_K, "lattice.insert_knot"),
        (Key.Key_U, "study.setup"),
        (Key.Key_D, "select.none"),
    ],
)
def test_shortcuts_of_the_program_work_in_a_field(ready, key, name):
    field, ran = ready.window.points.position.edits[0], []
    ready.window._special[name] = ran.append
    field.setFocus()
    ready.qtbot.waitUntil(field.hasFocus)
    QTest.keyClick(field, key, CTRL)
    del ready.window._special[name]
    assert len(ran) == 1


def test_select_all_and_letters_are_the_fields(ready):
    field, chosen = ready.window.points.position.edits[0], ready.window.document.selection
    field.setFocus()
    ready.qtbot.waitUntil(field.hasFocus)
    QTest.keyClick(field, Key.Key_A, CTRL)
    assert field.selectedText() == field.text()
    QTest.keyClicks(field, "b")
    assert field.text() == "b"
    assert ready.window.document.selection == chosen
    assert ready.window.studio.state.mode == "move"
    QTest.keyClick(field, Key.Key_Escape)
