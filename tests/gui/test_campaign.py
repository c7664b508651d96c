"""A seeded user who does anything in a real window: no exception, and undo leads back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog

from ffdstudio.gui.action_table import ROWS
from ffdstudio.gui.dialogs.ask import Question
from ffdstudio.gui.settings import Settings
from ffdstudio.gui.window import MainWindow
from tests.gui.conftest import Script, User, close
from tests.project.test_campaign import Witness, check

pytestmark = pytest.mark.display
MOST = 300  # control points of a lattice: refinement stops there, for time
NEVER = {"file.quit", "help.log"}
GROWING = ("lattice.elevate", "lattice.insert", "file.open", "lattice.load")


class Dice(Script):
    """Answers every question at random."""

    def __init__(self, random: np.random.Generator, folder: Path, files: list[Path]) -> None:
        super().__init__()
        self.random, self.folder, self.files = random, folder, files

    def open_paths(self, title: str, filters: str, folder: Path) -> list[Path]:
        known = [path for path in (*self.files, *self.folder.glob("saved*")) if path.exists()]
        return [known[self.random.integers(len(known))]] if self.random.random() < 0.8 else []

    def open_folder(self, title: str, folder: Path) -> Path | None:
        return self.folder if self.random.random() < 0.5 else None  # no mesh: to be told

    def save_path(self, title: str, filters: str, suggestion: Path) -> Path | None:
        name = f"saved{self.random.integers(3)}{''.join(suggestion.suffixes)}"
        return self.folder / name if self.random.random() < 0.8 else None

    def choose(self, question: Question) -> str:
        return question.answers[self.random.integers(len(question.answers))][0]

    def run(self, dialog: QDialog) -> bool:
        dialog.deleteLater()
        return bool(self.random.integers(2))


class Clumsy:
    """Clicks, drags and presses keys at random."""

    def __init__(self, user: User, random: np.random.Generator) -> None:
        self.user, self.window, self.random = user, user.window, random
        self.document = user.window.document
        self.rows = [row.name for row in ROWS if row.name not in NEVER]

    def act(self) -> None:
        self.random.choice(
            np.array([self.action, self.drag, self.hover, self.keys, self.undo, self.wait])
        )()
        QApplication.processEvents()
        assert [told.details for told in self.user.script.told if told.details] == []

    def action(self) -> None:
        name = str(self.random.choice(self.rows))
        large = any(item.rest.weights.size > MOST for item in self.document.model.lattices)
        many = len(self.document.model.items) > 3
        if (large or many) and name.startswith(GROWING):
            return
        action = self.window.actions_.by_name[name]
        if action.isEnabled():
            action.trigger()
        if self.window.lattice.building and self.random.random() < 0.7:
            builder = self.window.lattice.builder
            builder.counts[int(self.random.integers(3))].setValue(int(self.random.integers(2, 7)))
            (builder.make if builder.make.isEnabled() else builder.cancel).click()

    def drag(self) -> None:
        """Press somewhere, often on a control point, move, end in some way."""
        view, item = self.window.viewport, self.user.lattice
        start = QPoint(*(int(n) for n in self.random.integers(5, 500, 2)))
        if item is not None and self.random.random() < 0.8:
            point = tuple(int(self.random.integers(n)) for n in item.rest.shape)
            try:
                start = self.user.at(point)
            except (ValueError, OverflowError):  # behind the viewer
                return
        end = start + QPoint(*(int(n) for n in self.random.integers(-80, 80, 2)))
        button = Qt.MouseButton.LeftButton
        if self.random.random() < 0.2:
            button = Qt.MouseButton.MiddleButton
        keys = (Qt.Key.Key_Z,) if self.random.random() < 0.2 else ()
        self.user.begin(start, end, keys, button)
        if self.random.random() < 0.1:
            self.undo()
        elif self.random.random() < 0.1:
            QTest.keyClick(view, Qt.Key.Key_Escape)
        QTest.mouseRelease(view, button, Qt.KeyboardModifier.NoModifier, end)

    def hover(self) -> None:
        """Rest the pointer on a control point, without a button."""
        item = self.user.lattice
        if item is not None and np.isfinite(item.current.control_points).all():
            last = tuple(n - 1 for n in item.rest.shape)  # gone first when the net shrinks
            self.window.studio.state.hover(last)

    def keys(self) -> None:
        names = ("Left", "Up", "Escape", "X", "Return", "Tab", "Shift", "F5")
        key = getattr(Qt.Key, f"Key_{self.random.choice(names)}")
        QTest.keyClick(self.window.viewport, key)

    def undo(self) -> None:
        history = self.document.history
        if self.random.random() < 0.3:
            self.document.jump(int(self.random.integers(len(history.entries) + 1)))
        elif self.random.random() < 0.5:
            self.document.redo()
        else:
            self.document.undo()

    def wait(self) -> None:
        """Let all work end; then everything has to fit together."""
        self.user.idle()
        assert self.document.editing is None
        check(self.document)


def campaign(qtbot: Any, folder: Path, meshes: list[Path], actions: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    broken = folder / "broken.su2"
    broken.write_text("NDIME= 3\nNELEM= 4\n")
    script = Dice(random, folder, [*meshes, broken])
    window = MainWindow(Settings(folder / "window.ini"), script, folder / "recovery")
    window.resize(1000, 700)
    window.show()
    qtbot.waitExposed(window)
    user = User(window, script, qtbot)
    witness = Witness(window.document, exact=False)
    window.files.open_paths([meshes[0]])
    user.idle()
    user.build()
    clumsy = Clumsy(user, random)
    for _ in range(actions):
        clumsy.act()
    clumsy.wait()
    document = window.document
    last = document.history.position
    for position in [*range(last, -1, -1), *range(last + 1)]:
        document.jump(position)
    assert witness.compared >= last
    clumsy.wait()
    close(user)


def test_a_short_random_session_in_the_window(
    qtbot: Any, tmp_path: Path, cube: Path, square: Path
) -> None:
    campaign(qtbot, tmp_path, [cube, square], 60, seed=3)


@pytest.mark.campaign
def test_two_thousand_random_actions_in_the_window(
    qtbot: Any, tmp_path: Path, cube: Path, square: Path
) -> None:
    campaign(qtbot, tmp_path, [cube, square], 2000, seed=4)
