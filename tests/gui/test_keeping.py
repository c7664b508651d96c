"""What is asked before work is lost, autosaves, recovery, meshes that have gone, settings."""

from __future__ import annotations

import subprocess
import sys
import threading

import pytest

pytest.importorskip("PySide6")

from psygnal import EmitLoopError, Signal
from PySide6.QtCore import QPoint, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QProgressDialog, QPushButton

from ffdstudio.gui.dialogs.problem import ProblemDialog
from ffdstudio.gui.errors import ErrorReport, problem_of
from ffdstudio.gui.settings import Settings
from ffdstudio.project import body_views as displays
from ffdstudio.project import filing
from ffdstudio.project.commands import Rename

pytestmark = pytest.mark.display


@pytest.fixture
def ready(user, cube):
    user.open(cube)
    user.build()
    return user


# ---- unsaved changes ----------------------------------------------------------------------


def test_closing_asks_and_cancel_keeps_the_window(ready):
    ready.script.answers = ["cancel"]
    assert not ready.window.close()
    assert ready.window.isVisible()
    assert "Save" in ready.script.asked[0].text


def test_closing_saves_on_request_and_waits_for_it(ready, tmp_path):
    ready.script.answers, ready.script.targets = ["save"], [tmp_path / "a.ffdproj"]
    assert ready.window.close()
    assert (tmp_path / "a.ffdproj").exists()


def test_a_save_that_fails_keeps_the_window(ready, tmp_path):
    ready.script.answers = ["save"]
    ready.script.targets = [tmp_path / "no such folder" / "a.ffdproj"]
    assert not ready.window.close()
    assert "no such file" in ready.script.told[0].cause.lower()


def test_the_dialog_of_a_failed_save_offers_another_name(ready, tmp_path, qtbot):
    ready.script.targets = [tmp_path / "no folder" / "a.ffdproj", tmp_path / "a.ffdproj"]
    ready.trigger("file.save")
    ready.idle()
    dialog = ProblemDialog(ready.script.told[0], ready.window)
    qtbot.addWidget(dialog)
    (button,) = [b for b in dialog.findChildren(QPushButton) if b.text() == "Save &as…"]
    button.click()
    dialog.way()
    ready.idle()
    assert (tmp_path / "a.ffdproj").exists()


@pytest.mark.parametrize("warning", [True, False])
def test_a_report_is_unfolded_on_request_a_log_at_once(warning, qtbot):
    dialog = ProblemDialog(ErrorReport("Title", "Cause.", "", "line\n" * 50, warning))
    qtbot.addWidget(dialog)
    dialog.show()
    assert dialog.report.isVisible() is not warning
    assert dialog.focusWidget().text() == "Close"


def test_what_a_view_raises_is_told_without_the_wrapping_of_the_signal(ready):
    class Emitter:
        happened = Signal()

    def view():
        raise ZeroDivisionError("nothing to divide by")

    emitter = Emitter()
    emitter.happened.connect(view)
    with pytest.raises(EmitLoopError) as caught:
        emitter.happened.emit()
    problem = problem_of(caught.value)
    assert problem.cause == "ZeroDivisionError: nothing to divide by"
    assert "in view" in problem.details


def test_without_changes_nothing_is_asked(user):
    assert user.window.close()
    assert user.script.asked == []


# ---- autosave and recovery ----------------------------------------------------------------

CRASH = """
import os, sys
from pathlib import Path
from ffdstudio.project.autosave import Autosave
from ffdstudio.project.document import Document
from ffdstudio.project.commands import Rename
document = Document()
keeper = Autosave(document, Path(sys.argv[2]))
document.open_mesh(sys.argv[1])
document.do(Rename("body1", "from the crash"))
keeper.tick()
os._exit(9)
"""


def test_what_a_crash_has_left_is_offered_and_brought_back(user, cube, tmp_path):
    done = subprocess.run([sys.executable, "-c", CRASH, cube, tmp_path / "recovery"], check=False)
    assert done.returncode == 9
    user.script.answers = ["recover"]
    user.window.keeper.offer()
    user.idle()
    assert "autosave" in user.script.asked[0].detail
    assert user.window.document.model.bodies[0].name == "from the crash"
    assert user.window.document.modified


def test_what_is_discarded_is_not_offered_again(user, cube, tmp_path):
    subprocess.run([sys.executable, "-c", CRASH, cube, tmp_path / "recovery"], check=False)
    user.script.answers = ["discard"]
    user.window.keeper.offer()
    user.window.keeper.offer()
    assert len(user.script.asked) == 1


def test_a_window_that_closes_properly_leaves_no_autosave(ready, tmp_path):
    ready.window.keeper.tick()
    ready.idle()
    assert list((tmp_path / "recovery").glob("*/*.ffdproj"))
    ready.script.answers = ["discard"]
    ready.window.close()
    assert not list((tmp_path / "recovery").iterdir())


# ---- meshes of a project ------------------------------------------------------------------


def saved(user, tmp_path):
    user.script.targets = [tmp_path / "a.ffdproj"]
    user.trigger("file.save")
    user.idle()
    user.trigger("file.new")
    return tmp_path / "a.ffdproj"


def test_a_missing_mesh_is_asked_for_and_found_elsewhere(ready, cube, tmp_path):
    project = saved(ready, tmp_path)
    cube.rename(tmp_path / "moved.su2")
    ready.script.answers = ["find"]
    ready.script.paths = [[project], [tmp_path / "moved.su2"]]
    ready.trigger("file.open")
    ready.idle()
    assert ready.window.document.model.bodies[0].path.name == "moved.su2"
    assert len(ready.window.document.model.lattices) == 1


def test_a_missing_mesh_can_be_left_out(ready, cube, tmp_path):
    project = saved(ready, tmp_path)
    cube.unlink()
    ready.script.answers = ["leave"]
    ready.open(project)
    assert ready.window.document.model.bodies == ()
    assert len(ready.window.document.model.lattices) == 1


def test_giving_up_changes_nothing(ready, cube, tmp_path):
    project = saved(ready, tmp_path)
    cube.unlink()
    ready.script.answers = ["cancel"]
    ready.open(project)
    assert ready.window.document.model.lattices == ()


def test_a_changed_mesh_is_reported_before_it_is_used(ready, cube, tmp_path):
    project = saved(ready, tmp_path)
    cube.write_text(cube.read_text().replace("NDIME= 3", "% another\nNDIME= 3"))
    ready.script.answers = ["open"]
    ready.open(project)
    assert "changed" in ready.script.asked[0].text
    assert len(ready.window.document.model.bodies) == 1


def test_an_edit_while_a_project_is_read_is_not_lost_without_a_question(
    ready, tmp_path, monkeypatch
):
    ready.script.targets = [tmp_path / "a.ffdproj"]
    ready.trigger("file.save_as")
    ready.idle()
    real, go = filing._load, threading.Event()
    monkeypatch.setattr(filing, "_load", lambda *args: go.wait(20) and real(*args))
    ready.script.paths = [[tmp_path / "a.ffdproj"]]
    ready.trigger("file.open")
    ready.qtbot.waitUntil(lambda: any(j.key == "open" for j in ready.window.jobs.running))
    nudge(ready)
    ready.script.answers = ["cancel"]
    go.set()
    ready.idle()
    assert ready.script.asked[-1].title == "Unsaved changes"
    assert ready.lattice.deformed


# ---- work that is cancelled ------------------------------------------------------------------


@pytest.fixture
def slow(monkeypatch):
    """Checking cells takes until it is cancelled, or until the event is set."""
    real, go = displays.work_out, threading.Event()

    def work_out(body, nodes, lattices, progress, by):
        while not go.wait(0.01):
            progress(0.5, "")
        return real(body, nodes, lattices, progress, by)

    monkeypatch.setattr(displays, "work_out", work_out)
    yield go
    go.set()


def nudge(user):
    edit = user.window.document.edit([(1, 1, 1)])
    edit.translate([0.02, 0, 0])
    edit.commit()


def test_a_check_that_was_cancelled_is_said_and_made_up_for_by_the_next_edit(ready, slow):
    nudge(ready)
    assert "checking cells" in ready.window.status.cells.text()
    ready.qtbot.waitUntil(ready.window.status.cancel.isVisible)
    QTest.mouseClick(ready.window.status.cancel, Qt.MouseButton.LeftButton)
    ready.idle()
    assert "cells not checked" in ready.window.status.cells.text()
    slow.set()
    nudge(ready)
    ready.idle()
    assert "no inverted cells" in ready.window.status.cells.text()


def test_an_export_waits_for_the_check_which_can_be_cancelled_and_asks_then(ready, slow, tmp_path):
    nudge(ready)

    def cancel():
        dialogs = [d for d in ready.window.findChildren(QProgressDialog) if d.isVisible()]
        if dialogs:
            QTest.mouseClick(dialogs[0].findChild(QPushButton), Qt.MouseButton.LeftButton)
        else:
            QTimer.singleShot(50, cancel)

    QTimer.singleShot(50, cancel)
    ready.script.answers = ["cancel"]
    ready.trigger("file.export_mesh")  # no file is asked for: there is none in the script
    assert ready.script.asked[-1].title == "Cells not checked"
    ready.idle()
    slow.set()
    ready.script.targets = [tmp_path / "checked.su2"]
    ready.trigger("file.export_mesh")
    ready.idle()
    assert (tmp_path / "checked.su2").exists()


# ---- errors -------------------------------------------------------------------------------


def test_an_unexpected_error_in_a_slot_is_logged_and_shown_and_the_window_stays(ready, caplog):
    def broken(_on):
        raise ZeroDivisionError("a bug")

    ready.window._special["view.ghost"] = broken
    # pytest-qt puts its own hook in place; ours is what the program runs with
    sys.excepthook = ready.window.net._hook
    with ready.qtbot.captureExceptions():
        sys.excepthook = ready.window.net._hook
        ready.trigger("view.ghost")
        ready.qtbot.waitUntil(lambda: bool(ready.script.told))
    told = ready.script.told[0]
    assert "unexpected" in told.title
    assert "a bug" in told.cause
    assert "ZeroDivisionError" in told.details
    assert "unexpected error" in caplog.text
    ready.script.told.clear()
    assert ready.window.isVisible()
    ready.window.document.do(Rename("body1", "still there"))


# ---- settings -----------------------------------------------------------------------------


def test_the_layout_is_remembered_and_can_be_reset(make_user):
    first = make_user()
    first.window.docks["Points"].hide()
    first.window.close()
    second = make_user()
    assert not second.window.docks["Points"].isVisible()
    second.trigger("view.reset_layout")
    assert second.window.docks["Points"].isVisible()


def test_recent_files_come_newest_first_without_repetition(tmp_path):
    paths = [tmp_path / name for name in "abc"]
    for path in paths:
        path.touch()
    settings = Settings(tmp_path / "s.ini")
    for path in (*paths, paths[0]):
        settings.remember(path)
    assert settings.recent() == [paths[0], paths[2], paths[1]]
    paths[2].unlink()
    settings.save()
    again = Settings(tmp_path / "s.ini")
    assert again.recent() == [paths[0], paths[1]]


@pytest.mark.parametrize("content", [b"", b"\x00\xff" * 50, b"[General]\ngeometry=1\nrecent=7\n"])
def test_damaged_settings_fall_back_to_the_defaults(content, tmp_path):
    (tmp_path / "s.ini").write_bytes(content)
    settings = Settings(tmp_path / "s.ini")
    assert settings.layout() is None
    assert settings.recent() == []
    assert settings.text("theme", "light") == "light"


def test_a_window_of_the_smallest_size_shows_everything(ready):
    ready.window.resize(1280, 720)
    ready.idle()
    assert ready.window.size().height() == 720
    ready.trigger("lattice.new")
    ready.idle()
    builder = ready.window.lattice.builder
    place = builder.make.mapTo(ready.window, QPoint(0, 0))
    assert place.y() + builder.make.height() < 720
    assert builder.make.visibleRegion().boundingRect().height() == builder.make.height()
    assert ready.window.viewport.width() > 500
    assert builder.cancel.focusPolicy() & Qt.FocusPolicy.TabFocus
