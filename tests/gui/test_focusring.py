"""Whoever has the keyboard is seen to have it, in both themes."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest

pytestmark = pytest.mark.display


@pytest.fixture
def ready(same_user, cube):
    same_user.open(cube)
    same_user.build()
    window = same_user.window
    window.activateWindow()
    same_user.qtbot.waitUntil(window.isActiveWindow)
    window.document.select([(1, 1, 1)])
    return same_user


def place(window, widget):
    """Rectangle of a control in its window."""
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_tab_shows_a_ring_around_each_control_it_comes_to(ready, theme):
    window, ring = ready.window, ready.window.focus_ring.ring
    ready.trigger(f"view.{theme}")
    window.tree.setFocus()
    reached = []
    for _ in range(80):
        widget = window.focusWidget()
        if widget in reached:
            break
        reached.append(widget)
        ready.qtbot.waitUntil(ring.isVisible)  # a dock may have to come to the front first
        seen, own = ring.geometry(), place(window, widget)
        assert own.adjusted(2, 2, -2, -2).intersected(seen).isValid(), widget
        assert own.adjusted(-2, -2, 2, 2).contains(seen), widget
        QTest.keyClick(widget, Qt.Key.Key_Tab)
    kinds = {type(widget).__name__ for widget in reached}
    assert len(reached) > 15
    assert {"Viewport", "TreePanel", "HistoryPanel", "NumberEdit", "QSpinBox"} <= kinds
    assert "QScrollArea" not in kinds
    colour = ring.grab().toImage().pixelColor(0, 0).name()
    assert colour == ready.window.studio.theme["highlight"].lower()
    ready.trigger("view.light")


def test_the_ring_follows_the_control_and_leaves_with_it(ready):
    window, ring = ready.window, ready.window.focus_ring.ring
    field = window.points.weight
    field.setFocus()
    before = ring.geometry()
    window.resize(window.width() + 80, window.height())
    ready.qtbot.waitUntil(lambda: ring.geometry() != before)
    assert place(window, field).adjusted(-2, -2, 2, 2).contains(ring.geometry())
    window.resize(window.width() - 80, window.height())
    window.docks["Points"].hide()
    assert not ring.isVisible() or window.focusWidget() is not field
    window.docks["Points"].show()


def test_the_picture_has_no_ring_for_the_mouse(ready):
    window, ring = ready.window, ready.window.focus_ring.ring
    window.points.weight.setFocus()
    ready.trigger("select.all")
    assert ring.isVisible()  # by a key, perhaps
    ready.click(QPoint(5, 5))
    assert window.viewport.hasFocus()
    assert not ring.isVisible()


def test_a_dialog_has_its_ring_and_takes_it_along(ready):
    window, seen = ready.window, []

    def look(dialog):
        dialog.show()
        dialog.activateWindow()
        ready.qtbot.waitUntil(dialog.isActiveWindow)
        dialog.angle.setFocus()
        ring = window.focus_ring.ring
        seen.append(ring.parentWidget() is dialog and ring.isVisible())
        dialog.close()
        return False

    ready.script.dialogs = [look]
    ready.trigger("edit.transform")
    ready.qtbot.wait(50)
    assert seen == [True]
    window.activateWindow()
    ready.qtbot.waitUntil(window.isActiveWindow)
    window.points.weight.setFocus()
    assert window.focus_ring.ring.parentWidget() is window
    assert window.focus_ring.ring.isVisible()
