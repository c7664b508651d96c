"""The whole tour with real mouse and keyboard events, on a real X server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")

from ffdstudio.project.files.replaying import export, replay
from ffdstudio.project.interaction.feedback import weight_handle

pytestmark = pytest.mark.display
POINT = (2, 1, 2)


@pytest.fixture
def hands(user: Any) -> Any:
    """The user of a window, with a real mouse and keyboard."""
    from tests.gui.hands import XDOTOOL, Hands

    if XDOTOOL is None:
        pytest.skip("xdotool is not installed")
    return Hands(user)


def built(hands: Any, cube: Path) -> None:
    """Open a cube and put a 4 x 4 x 4 lattice around it, by keyboard and mouse."""
    window = hands.window
    hands.script.paths = [[cube]]
    hands.key("ctrl+o")
    hands.idle()
    assert len(window.document.model.bodies) == 1
    hands.key("ctrl+l")
    builder = window.lattice.builder
    for box in builder.counts:
        box.setValue(4)
    hands.press(builder.make)
    hands.idle()
    assert window.document.model.lattices[0].rest.shape == (4, 4, 4)
    assert hands.script.told == []


def test_open_build_select_drag_weight_undo_save_reopen_export_and_replay(
    hands: Any, cube: Path, tmp_path: Path
) -> None:
    built(hands, cube)
    window, script = hands.window, hands.script
    document = window.document

    begin = hands.pixel(POINT)
    hands.click(begin)
    assert document.selection == {POINT}

    hands.drag(begin, begin + [20, 5], begin + [60, -20])
    np.testing.assert_allclose(hands.pixel(POINT), begin + [60, -20], atol=1)
    assert document.history.labels[-1] == "Move point (2, 1, 2)"

    before = document.model.lattices[0].current.control_points[POINT].copy()
    begin = hands.pixel(POINT)
    hands.place(begin)
    hands.down()
    hands.place(begin + [30, 30])
    hands.key("z")
    hands.place(begin + [40, 40])
    hands.up()
    moved = document.model.lattices[0].current.control_points[POINT] - before
    assert np.flatnonzero(moved).tolist() == [2]

    item = document.model.lattices[0]
    handle = weight_handle(window.viewport.camera_now(), item.current.control_points[POINT], 1.0)
    hands.drag(handle, (handle[0], handle[1] - 10), (handle[0], handle[1] - 25))
    weight = document.model.lattices[0].current.weights[POINT]
    assert weight > 1
    hands.key("ctrl+z")
    assert document.model.lattices[0].current.weights[POINT] == 1
    hands.key("ctrl+shift+z")
    assert document.model.lattices[0].current.weights[POINT] == weight
    hands.idle()

    project, mesh, journal = tmp_path / "a.ffdproj", tmp_path / "out.su2", tmp_path / "a.journal"
    script.targets = [project]
    hands.key("ctrl+s")
    hands.idle()
    assert not document.modified
    hands.key("ctrl+n")
    assert not document.model.bodies
    script.paths = [[project]]
    hands.key("ctrl+o")
    hands.idle()
    assert document.model.lattices[0].current.weights[POINT] == weight
    script.targets = [mesh]
    hands.key("ctrl+e")
    hands.idle()
    script.targets = [journal]
    window.actions_.by_name["file.export_journal"].trigger()
    hands.idle()
    assert script.told == []
    export(replay(journal), tmp_path / "replayed")
    assert (tmp_path / "replayed" / "cube.su2").read_bytes() == mesh.read_bytes()
    assert mesh.read_bytes() != cube.read_bytes()


@pytest.mark.parametrize("parallel", [False, True], ids=["perspective", "parallel"])
def test_a_dragged_point_stays_under_the_cursor(hands: Any, cube: Path, parallel: bool) -> None:
    built(hands, cube)
    if parallel:
        hands.key("5")
        assert hands.window.viewport.view.parallel
    for point, by in (((3, 0, 3), (40, 30)), ((1, 0, 3), (-50, -25))):
        begin = np.round(hands.pixel(point))
        offset = hands.pixel(point) - begin
        hands.drag(begin, begin + [5, 5], begin + by)
        np.testing.assert_allclose(hands.pixel(point), begin + by + offset, atol=1)


def test_escape_takes_a_drag_back_and_fifty_moves_cost_few_pictures(hands: Any, cube: Path) -> None:
    from PySide6.QtCore import QEvent, QPointF, Qt
    from PySide6.QtGui import QMouseEvent
    from PySide6.QtWidgets import QApplication

    built(hands, cube)
    window = hands.window
    model, begin = window.document.model, hands.pixel(POINT)
    hands.place(begin)
    hands.down()
    hands.place(begin + [30, 10])
    hands.settle(0.3)
    frames = window.viewport.frames
    for k in range(50):  # queued, as a fast mouse does
        at = QPointF(*(begin + [30 + k, 10]))
        event = QMouseEvent(
            QEvent.Type.MouseMove,
            at,
            window.viewport.mapToGlobal(at),
            Qt.MouseButton.NoButton,
            Qt.MouseButton.LeftButton,
            Qt.KeyboardModifier.NoModifier,
        )
        QApplication.postEvent(window.viewport, event)
    hands.settle(0.3)
    assert 1 <= window.viewport.frames - frames <= 5
    assert window.document.model is not model
    hands.key("Escape")
    hands.up()
    assert window.document.model is model
