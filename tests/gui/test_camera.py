"""Camera by mouse and keys: the shape is found again, sides are parallel, large bodies turn."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QPoint

from ffdstudio.samples import sample

pytestmark = pytest.mark.display


@pytest.fixture
def wing(user: Any) -> Any:
    user.open(sample("wing_air.su2"))
    return user


def seen(user: Any) -> np.ndarray:
    """(2,) share of the picture that the wing takes, width and height."""
    view = user.window.viewport
    mesh = user.window.document.model.bodies[0].mesh
    pixels = view.camera_now().project(mesh.points[mesh.marker_nodes("WING")])
    return np.asarray(np.ptp(pixels, axis=0) / [view.width(), view.height()])


def test_fit_shows_the_wing_everything_the_far_field_and_home_the_first_picture(wing: Any) -> None:
    first = wing.window.viewport.view
    assert seen(wing).max() > 0.4
    wing.trigger("view.fit_all")
    assert seen(wing).max() < 0.3
    wing.trigger("view.fit")
    assert seen(wing).max() > 0.4
    wing.trigger("view.plus_x")
    wing.trigger("view.home")
    again = wing.window.viewport.view
    assert np.allclose(again.back, first.back)
    assert again.distance == pytest.approx(first.distance)


def test_sides_are_parallel_and_the_corner_is_not(wing: Any) -> None:
    wing.trigger("view.plus_y")
    assert wing.window.viewport.view.parallel
    wing.trigger("view.corner")
    assert not wing.window.viewport.view.parallel


def test_a_click_on_an_end_of_the_triad_looks_from_there(wing: Any) -> None:
    from ffdstudio.gui.navigation import triad_ends

    view = wing.window.viewport
    ends = triad_ends(view.view, view.height())
    wing.click(QPoint(*map(round, ends["+z"])))
    assert view.view.back.tolist() == [0, 0, 1]
    assert view.view.parallel


def test_the_picture_turns_about_what_is_under_the_cursor(wing: Any) -> None:
    mesh, view = wing.window.document.model.bodies[0].mesh, wing.window.viewport
    where = wing.pixel(mesh.points[mesh.marker_nodes("WING")].mean(axis=0))
    point = wing.window.tools.occluders.under(view.camera_now(), where.x(), where.y())
    assert point is not None
    start = view.camera_now().project(point)[0]
    back = view.view.back
    wing.drag(where, where + QPoint(80, 30))
    assert not np.allclose(view.view.back, back)
    assert np.abs(view.camera_now().project(point)[0] - start).max() < 1
    assert not wing.window.studio.state.navigating


def test_kept_views_come_again(wing: Any) -> None:
    wing.trigger("view.plus_x")
    wing.trigger("view.keep")
    wing.trigger("view.plus_y")
    wing.trigger("view.recall")
    assert wing.window.viewport.view.back.tolist() == [1, 0, 0]


def test_a_large_surface_is_turned_as_its_proxy(user: Any, monkeypatch: Any, tmp_path: Any) -> None:
    from ffdstudio.gui import scene
    from ffdstudio.project.view import surface

    monkeypatch.setattr(scene, "MANY_FACES", 100)
    monkeypatch.setattr(surface, "PROXY_ABOVE", 100)
    monkeypatch.setattr(surface.surface_of, "__defaults__", (100,))
    user.open(sample("wing_skin.vtu"))
    actor = user.window.scene.bodies["body1"]
    assert actor.proxy is not None
    user.begin(QPoint(5, 200), QPoint(60, 200))
    assert actor.proxy.faces.GetVisibility()
    assert not actor.full.faces.GetVisibility()
    assert np.allclose(actor.proxy.points.array, actor.full.points.array[actor.surface.proxy.rows])
    from PySide6.QtCore import Qt
    from PySide6.QtTest import QTest

    QTest.mouseRelease(user.window.viewport, Qt.MouseButton.LeftButton, pos=QPoint(60, 200))
    assert actor.full.faces.GetVisibility()
