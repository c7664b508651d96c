"""Windows for tests: a user who answers by script, settings and autosaves of their own."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")
pytest.importorskip("pytestqt")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog

from ffdstudio.gui.dialogs.ask import Asker, Question
from ffdstudio.gui.errors import ErrorReport

if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # for tests that draw nothing

PATIENCE = 20_000  # milliseconds until a wait has failed


class Script(Asker):
    """Answers without asking; what was asked and told is kept."""

    def __init__(self) -> None:
        super().__init__()
        self.paths: list[list[Path]] = []
        self.targets: list[Path | None] = []
        self.answers: list[str] = []
        self.dialogs: list[Callable[[Any], bool]] = []
        self.asked: list[Question] = []
        self.told: list[ErrorReport] = []

    def open_paths(self, title: str, filters: str, folder: Path) -> list[Path]:
        return self.paths.pop(0)

    def save_path(self, title: str, filters: str, suggestion: Path) -> Path | None:
        return self.targets.pop(0)

    def choose(self, question: Question) -> str:
        self.asked.append(question)
        return self.answers.pop(0)

    def tell(self, problem: ErrorReport) -> None:
        self.told.append(problem)

    def run(self, dialog: QDialog) -> bool:
        accepted = self.dialogs.pop(0)(dialog)
        dialog.deleteLater()
        return accepted


class User:
    """Somebody with a mouse and a keyboard in front of a window."""

    def __init__(self, window: Any, script: Script, qtbot: Any) -> None:
        self.window, self.script, self.qtbot = window, script, qtbot

    def open(self, *paths: Path) -> None:
        """Open files and wait until all work on them is done."""
        self.script.paths.append(list(paths))
        self.trigger("file.open")
        self.idle()

    def trigger(self, name: str) -> None:
        """Carry out an action, which has to be enabled."""
        action = self.window.actions_.by_name[name]
        assert action.isEnabled(), name
        action.trigger()

    def idle(self) -> None:
        """Wait until no work is under way and the picture is painted."""
        self.qtbot.waitUntil(lambda: not self.window.jobs.running, timeout=PATIENCE)
        if self.window.viewport.isVisible():
            self.painted()

    def painted(self) -> None:
        """Wait for one more picture."""
        before = self.window.viewport.frames
        self.window.viewport.update()
        self.qtbot.waitUntil(lambda: self.window.viewport.frames > before, timeout=PATIENCE)

    def build(self, counts: tuple[int, ...] = (4, 4, 4), **fields: Any) -> None:
        """Build a lattice by the form."""
        self.trigger("lattice.new")
        builder = self.window.lattice.builder
        for box, count in zip(builder.counts, counts, strict=False):
            box.setValue(count)
        for name, value in fields.items():
            getattr(builder, name).setValue(value)
        QTest.mouseClick(builder.make, Qt.MouseButton.LeftButton)
        self.idle()

    @property
    def lattice(self) -> Any:
        return self.window.document.model.active_lattice

    def pixel(self, point: Any) -> QPoint:
        """Where a world point is seen."""
        x, y = self.window.viewport.camera_now().project(np.asarray(point))[0]
        return QPoint(round(x), round(y))

    def at(self, index: tuple[int, ...]) -> QPoint:
        """Where a control point is seen."""
        return self.pixel(self.lattice.current.control_points[index])

    def click(self, place: QPoint, modifier: Any = Qt.KeyboardModifier.NoModifier) -> None:
        QTest.mouseClick(self.window.viewport, Qt.MouseButton.LeftButton, modifier, place)

    def begin(
        self,
        start: QPoint,
        end: QPoint,
        keys: tuple[Any, ...] = (),
        button: Any = Qt.MouseButton.LeftButton,
        modifier: Any = Qt.KeyboardModifier.NoModifier,
    ) -> None:
        """Press and move, without letting go."""
        view = self.window.viewport
        QTest.mousePress(view, button, modifier, start)
        for step in range(1, 6):
            self.move(start + (end - start) * step / 5, button, modifier)
            if step == 1:
                for key in keys:
                    QTest.keyClick(view, key)

    def move(
        self,
        place: QPoint,
        button: Any = Qt.MouseButton.LeftButton,
        modifier: Any = Qt.KeyboardModifier.NoModifier,
    ) -> None:
        """Move with a button held; `QTest.mouseMove` knows no buttons."""
        from PySide6.QtCore import QEvent, QPointF
        from PySide6.QtGui import QMouseEvent
        from PySide6.QtWidgets import QApplication

        view, here = self.window.viewport, QPointF(place)
        there = QPointF(view.mapToGlobal(place))
        none = Qt.MouseButton.NoButton
        event = QMouseEvent(QEvent.Type.MouseMove, here, there, none, button, modifier)
        QApplication.sendEvent(view, event)

    def drag(self, start: QPoint, end: QPoint, **how: Any) -> None:
        """Press, move, let go, and wait until all has followed."""
        self.begin(start, end, **how)
        button = how.get("button", Qt.MouseButton.LeftButton)
        modifier = how.get("modifier", Qt.KeyboardModifier.NoModifier)
        QTest.mouseRelease(self.window.viewport, button, modifier, end)
        self.idle()


@pytest.fixture
def make_user(qtbot: Any, tmp_path: Path) -> Iterator[Callable[[], User]]:
    """Open windows, each with its user; they are closed at the end."""
    from ffdstudio.gui.settings import Settings
    from ffdstudio.gui.window import MainWindow

    users: list[User] = []

    def make() -> User:
        script = Script()
        settings = Settings(tmp_path / "window.ini")
        window = MainWindow(settings, script, tmp_path / "recovery")
        window.resize(1200, 800)
        window.show()
        qtbot.waitExposed(window)
        users.append(User(window, script, qtbot))
        return users[-1]

    yield make
    for user in users:
        close(user)
    assert [fault for user in users for fault in unexpected(user.script)] == []


def unexpected(script: Script) -> list[str]:
    """Reports of errors that nobody expected: a listener's reaches no test by itself."""
    return [told.details for told in script.told if "unexpected" in told.title]


def close(user: User) -> None:
    """Close a window without saving."""
    user.script.answers = ["discard"]
    if user.window.isVisible():
        user.window.close()
    user.window.deleteLater()
    user.qtbot.wait(0)


@pytest.fixture(scope="module")
def shared_window(qapp: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """One window for the tests of a module: making one takes longer than most tests."""
    from ffdstudio.gui.settings import Settings
    from ffdstudio.gui.window import MainWindow

    folder = tmp_path_factory.mktemp("window")
    window = MainWindow(Settings(folder / "window.ini"), Script(), folder / "recovery")
    window.resize(1200, 800)
    window.show()
    yield window
    window.document.clear()
    window.close()
    window.deleteLater()
    qapp.processEvents()


@pytest.fixture
def same_user(shared_window: Any, qtbot: Any) -> Iterator[User]:
    """The user of the module's window, which is emptied after each test."""
    script = shared_window.studio.asker
    yield User(shared_window, script, qtbot)
    emptied(shared_window)
    faults = unexpected(script)
    script.__init__()
    script.parent = shared_window
    assert faults == []


def emptied(window: Any) -> None:
    """Put a window back to what it was when it opened."""
    from dataclasses import replace

    from ffdstudio.gui.state import ShownOptions

    window.tools.cancel()
    if window.lattice.building:
        window.lattice.builder.stop()
    state = window.studio.state
    state.set_mode("move")
    state.spread(soft=False, mirror=-1, profile="smooth", mirror_at=0.0, pivot="centroid")
    state.radius = None
    state.hover(None)
    window.document.clear()
    state.show(**vars(ShownOptions()))
    window.viewport.view = replace(window.viewport.view, parallel=False, flat=False)
    window.jobs.finish()
    window.problems.clear()


@pytest.fixture
def user(make_user: Callable[[], User]) -> User:
    """One window with its user."""
    return make_user()


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    """Volume mesh of a cube with two markers."""
    import sys

    sys.path.insert(0, str(Path(__file__).parents[1] / "project"))
    try:
        from scenes import write_cube
    finally:
        sys.path.pop(0)
    return write_cube(tmp_path / "cube.su2", 4)


@pytest.fixture
def square(tmp_path: Path) -> Path:
    """Plane mesh of a square with one marker."""
    import sys

    sys.path.insert(0, str(Path(__file__).parents[1] / "project"))
    try:
        from scenes import write_square
    finally:
        sys.path.pop(0)
    return write_square(tmp_path / "square.su2")
