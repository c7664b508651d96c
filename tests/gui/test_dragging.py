"""Drags by the mouse: what moves, what is drawn, and how often."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from ffdstudio.project.commands import MovePoints, SetWeights

pytestmark = pytest.mark.display
POINT = (2, 1, 3)


@pytest.fixture
def user(same_user):
    return same_user


@pytest.fixture
def ready(user, cube):
    user.open(cube)
    user.build()
    return user


@pytest.mark.parametrize("parallel", [False, True])
def test_a_dragged_point_stays_under_the_cursor(ready, parallel):
    if parallel:
        ready.trigger("view.parallel")
        ready.idle()
    assert ready.window.viewport.view.parallel is parallel
    camera, start = ready.window.viewport.camera_now(), ready.at(POINT)
    before = camera.project(ready.lattice.current.control_points[POINT])
    ready.drag(start, start + QPoint(60, -45))
    now = camera.project(ready.lattice.current.control_points[POINT])
    assert np.abs(now - before - [60, -45]).max() < 1


def test_a_key_locks_a_drag_to_an_axis_and_it_is_one_entry(ready):
    start, rest = ready.at(POINT), ready.lattice.rest.control_points[POINT]
    ready.drag(start, start + QPoint(25, -35), keys=(Qt.Key.Key_Z,))
    change = ready.lattice.current.control_points[POINT] - rest
    assert change[2] > 0.01
    assert (change[:2] == 0).all()
    assert isinstance(ready.window.document.history.entries[-1].command, MovePoints)
    assert ready.window.document.history.position == 3


def test_what_is_drawn_is_where_the_camera_says(ready):
    """A selected point is orange where the tools look for it; mesh and net are bluish grey."""
    ready.click(ready.at(POINT))
    ready.idle()
    colour = ready.window.viewport.grabFramebuffer().pixelColor(ready.at(POINT))
    assert colour.red() > colour.blue() + 60


def test_fifty_queued_moves_give_few_pictures(ready):
    view, start = ready.window.viewport, ready.at(POINT)
    ready.begin(start, start + QPoint(10, 0))
    ready.painted()
    before = view.frames
    for step in range(50):
        ready.move(start + QPoint(10 + step, step))
    ready.qtbot.waitUntil(lambda: view.frames > before, timeout=10_000)
    ready.painted()
    assert view.frames - before <= 3
    QTest.keyClick(view, Qt.Key.Key_Escape)


def test_repainting_the_overlay_renders_nothing(ready):
    view, start = ready.window.viewport, ready.at(POINT)
    before = view.frames
    ready.move(start, button=Qt.MouseButton.NoButton)  # hover: one picture for the colour
    ready.idle()
    assert ready.window.studio.state.hovered == POINT
    assert "weight  1" in view.overlay.layers["hover"][0].lines
    drawn = view.frames
    view.overlay.update()
    ready.qtbot.wait(30)
    assert drawn > before
    assert view.frames == drawn


def test_escape_aborts_a_drag_without_a_trace(ready):
    labels, rest = list(ready.window.document.history.labels), ready.lattice.current
    start = ready.at(POINT)
    ready.begin(start, start + QPoint(50, 0))
    assert ready.lattice.deformed
    QTest.keyClick(ready.window.viewport, Qt.Key.Key_Escape)
    assert ready.lattice.current is rest
    assert ready.window.document.history.labels == labels


def test_the_mesh_follows_while_the_mouse_moves(ready):
    key = ready.window.document.model.bodies[0].key
    shown = ready.window.scene.bodies[key].full.points.array.copy()
    start = ready.at(POINT)
    ready.begin(start, start + QPoint(60, -20))
    ready.painted()
    now = ready.window.scene.bodies[key].full.points.array
    expected = ready.window.document.points(key) - ready.window.viewport.origin
    assert (now != shown).any()
    assert np.allclose(now, expected, atol=1e-6)
    QTest.keyClick(ready.window.viewport, Qt.Key.Key_Escape)


def test_a_weight_has_a_handle_to_drag_and_a_double_click_resets_it(ready):
    ready.click(ready.at(POINT))
    handle = ready.at(POINT) - QPoint(0, 40)
    ready.drag(handle, handle - QPoint(0, 50))
    assert ready.lattice.current.weights[POINT] > 2
    assert isinstance(ready.window.document.history.entries[-1].command, SetWeights)
    up = handle - QPoint(0, 50)
    QTest.mouseDClick(
        ready.window.viewport, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, up
    )
    assert (ready.lattice.current.weights == 1).all()


def test_beside_the_points_the_mouse_moves_the_camera_only(ready):
    view, model = ready.window.viewport, ready.window.document.model
    corner, before = QPoint(12, 12), view.view
    ready.drag(corner, corner + QPoint(60, 30))
    assert not np.allclose(view.view.back, before.back)
    turned = view.view
    ready.drag(corner, corner + QPoint(60, 30), button=Qt.MouseButton.MiddleButton)
    assert (view.view.back == turned.back).all()
    assert not np.allclose(view.view.focal, turned.focal)
    assert ready.window.document.model is model


def test_a_plane_mesh_is_locked_to_its_plane(user, square):
    user.open(square)
    user.build((4, 4))
    view = user.window.viewport.view
    assert view.flat
    assert view.parallel
    corner = QPoint(12, 12)
    user.drag(corner, corner + QPoint(60, 30))
    assert (user.window.viewport.view.back == [0, 0, 1]).all()
    start = user.at((1, 2))
    user.drag(start, start + QPoint(40, -30))
    moved = user.lattice.current.control_points - user.lattice.rest.control_points
    assert np.abs(moved[1, 2, :2]).min() > 0
    assert (moved[..., 2] == 0).all()
