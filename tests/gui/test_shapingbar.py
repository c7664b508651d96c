"""The strip that says how a drag works, and typing during one, with events of a real window."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

pytestmark = pytest.mark.display
POINT = (2, 1, 2)


@pytest.fixture
def ready(user: Any, cube: Any) -> Any:
    user.open(cube)
    user.build()
    return user


def enter(field: Any, text: str) -> None:
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)


def choose(box: Any, data: object) -> None:
    box.setCurrentIndex(box.findData(data))
    box.activated.emit(box.currentIndex())


def test_the_strip_comes_with_a_lattice_and_goes_with_it(user: Any, cube: Any) -> None:
    user.open(cube)
    bar = user.window.shaping_bar
    assert not bar.isVisible()
    user.build()
    assert bar.isVisible()
    user.trigger("lattice.remove")
    assert not bar.isVisible()


def test_what_the_strip_says_is_what_the_tools_do(ready: Any) -> None:
    bar, tools = ready.window.shaping_bar, ready.window.tools
    bar.soft.click()
    assert tools.options.soft is not None
    enter(bar.radius, "0.4")
    choose(bar.profile, "linear")
    assert (tools.options.soft.radius, tools.options.soft.profile) == (0.4, "linear")
    choose(bar.plane, 1)
    enter(bar.at, "0.5")
    assert (tools.options.mirror.axis, tools.options.mirror.at) == (1, 0.5)
    choose(bar.pivot, "picked")
    assert tools.options.pivot == "picked"
    choose(bar.guard, "stop")
    assert ready.window.quality.warden.mode == "stop"
    ready.trigger("edit.soft")  # by its key, the strip follows
    assert tools.options.soft is None
    assert not bar.soft.isChecked()
    ready.trigger("edit.soft")
    assert tools.options.soft.radius == 0.4


def test_the_reach_of_soft_selection_is_drawn_around_the_selected_points(ready: Any) -> None:
    overlay = ready.window.viewport.overlay
    ready.click(ready.at(POINT))
    assert overlay.layers.get("soft", ()) == ()
    ready.window.shaping_bar.soft.click()
    ready.painted()
    [ring] = overlay.layers["soft"]
    assert ring.radius > 20


def test_a_frozen_point_moves_nothing_with_soft_selection_either(ready: Any) -> None:
    from ffdstudio.project.commands import FreezeLayers

    document = ready.window.document
    document.do(FreezeLayers(ready.lattice.key, 1))
    ready.window.shaping_bar.soft.click()
    before = ready.lattice.current
    start = ready.at((3, 0, 3))
    ready.drag(start, start + QPoint(40, 20))
    assert ready.lattice.current is before


def test_numbers_are_typed_during_a_drag_although_they_are_keys_of_views(ready: Any) -> None:
    view = ready.window.viewport
    back = view.view.back
    start = ready.at(POINT)
    before = ready.lattice.current.control_points[POINT].copy()
    ready.begin(start, start + QPoint(30, 10))
    QTest.keyClicks(view, "0.125")
    QTest.keyClick(view, Qt.Key.Key_Tab)
    QTest.keyClicks(view, "=1/8")
    QTest.keyClick(view, Qt.Key.Key_Return)
    ready.idle()
    moved = ready.lattice.current.control_points[POINT] - before
    assert moved == pytest.approx([0.125, 0.125, 0])
    assert np.array_equal(view.view.back, back)


def test_space_held_shows_what_was_before(ready: Any) -> None:
    document, view = ready.window.document, ready.window.viewport
    edit = document.edit([POINT])
    edit.translate([0.3, 0, 0.2])
    edit.commit()
    ready.idle()
    actor = ready.window.scene.bodies["body1"]
    now = actor.full.points.array.copy()
    view.setFocus()
    QTest.keyPress(view, Qt.Key.Key_Space)
    rest = actor.rest - view.origin
    assert np.allclose(actor.full.points.array, rest, atol=1e-6)
    assert not np.allclose(now, rest, atol=1e-3)
    QTest.keyRelease(view, Qt.Key.Key_Space)
    assert np.array_equal(actor.full.points.array, now)
    assert len(document.history.labels) == 3
