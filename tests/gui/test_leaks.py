"""Windows that are closed are gone: no document, actor or thread of theirs is left."""

from __future__ import annotations

import gc
import threading
import weakref
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("PySide6")
from PySide6.QtCore import QCoreApplication, QEvent, QPoint
from PySide6.QtWidgets import QApplication

from ffdstudio.gui.settings import Settings
from ffdstudio.gui.window import MainWindow
from tests.gui.conftest import Script, User, close

pytestmark = pytest.mark.display


def census() -> dict[str, int]:
    """How many there are of what a window could leave."""
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    QApplication.processEvents()
    gc.collect()
    names = [type(thing).__name__ for thing in gc.get_objects()]
    wanted = ("vtkActor", "vtkOpenGLActor", "vtkOpenGLRenderer", "MainWindow", "Document", "Scene")
    count = {name: names.count(name) for name in wanted}
    return {
        **count,
        "threads": threading.active_count(),
        "windows": len(QApplication.topLevelWidgets()),
    }


def once(qtbot: Any, folder: Path, cube: Path) -> weakref.ref[Any]:
    """Open a window, do something in it, close it."""
    window = MainWindow(Settings(folder / "window.ini"), Script(), folder / "recovery")
    window.resize(1000, 700)
    window.show()
    qtbot.waitExposed(window)
    user = User(window, window.studio.asker, qtbot)
    user.open(cube)
    user.build()
    user.drag(user.at((2, 1, 2)), user.at((2, 1, 2)) + QPoint(20, 10))
    document = weakref.ref(window.document)
    close(user)
    return document


def leaks(qtbot: Any, folder: Path, cube: Path, windows: int) -> None:
    once(qtbot, folder, cube)  # what the first one loads stays
    before = census()
    documents = [once(qtbot, folder, cube) for _ in range(windows)]
    after = census()
    assert [ref for ref in documents if ref() is not None] == []
    assert after == before


def test_a_few_windows_leave_nothing(qtbot: Any, tmp_path: Path, cube: Path) -> None:
    leaks(qtbot, tmp_path, cube, 3)


@pytest.mark.campaign
def test_fifty_windows_leave_nothing(qtbot: Any, tmp_path: Path, cube: Path) -> None:
    leaks(qtbot, tmp_path, cube, 50)
