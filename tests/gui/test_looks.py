"""What the picture shows of a shape: pixels of a real window."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")

from ffdstudio.samples import sample

pytestmark = pytest.mark.display


def pixels(user: Any) -> np.ndarray:
    """(h, w, 3) of the picture, without overlay."""
    from PySide6.QtGui import QImage

    jobs = user.window.jobs
    user.qtbot.waitUntil(lambda: not jobs.running, timeout=120_000)  # kernels may be compiled
    user.idle()
    user.window.viewport.overlay.hide()
    image = user.window.viewport.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    user.window.viewport.overlay.show()
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(float)


def luminance(picture: np.ndarray) -> np.ndarray:
    """Relative luminance of sRGB, as in WCAG 2."""
    c = picture / 255
    linear = np.where(c <= 0.03928, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return np.asarray(linear @ [0.2126, 0.7152, 0.0722])


def similarity(a: np.ndarray, b: np.ndarray, mask: np.ndarray) -> float:
    """Mean structural similarity (Wang et al. 2004) of grey pictures where the mask is."""
    from scipy.ndimage import uniform_filter

    def mean(x: np.ndarray) -> np.ndarray:
        return np.asarray(uniform_filter(x, 7))

    ma, mb = mean(a), mean(b)
    va, vb, cov = mean(a * a) - ma**2, mean(b * b) - mb**2, mean(a * b) - ma * mb
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    found = (2 * ma * mb + c1) * (2 * cov + c2) / ((ma**2 + mb**2 + c1) * (va + vb + c2))
    return float(found[mask].mean())


def seen(user: Any, picture: np.ndarray) -> np.ndarray:
    """Where the picture differs from the empty ground."""
    key = user.window.document.model.bodies[0].key
    actor = user.window.scene.bodies[key].full.faces
    actor.SetVisibility(False)
    ground = pixels(user)
    actor.SetVisibility(True)
    return np.asarray(np.abs(picture - ground).max(axis=2) > 4)


@pytest.fixture
def wing(user: Any) -> Any:
    """Window of 1280 x 720 with the wing at its default lattice, edges and net off."""
    user.window.resize(1280, 720)
    user.open(sample("wing_air.su2"))
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    user.qtbot.waitUntil(lambda: builder.reach.settled, timeout=20_000)
    assert "The skin can move by about" in builder.reach.text()
    builder.make.click()
    user.idle()
    user.window.studio.state.show(edges=False, net=False)
    return user


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_one_point_dragged_by_5_percent_of_the_semispan_is_plainly_seen(wing: Any, theme: str):
    wing.trigger(f"view.{theme}")
    before = pixels(wing)
    where = seen(wing, before)
    edit = wing.window.document.edit([(2, 2, 2)])
    edit.translate([0, 0, 0.05 * 2.5])
    edit.commit()
    after = pixels(wing)
    assert similarity(before.mean(axis=2), after.mean(axis=2), where) <= 0.9
    assert similarity(before.mean(axis=2), before.mean(axis=2), where) == pytest.approx(1)


def test_bodies_are_bright_on_the_dark_ground(wing: Any):
    wing.trigger("view.dark")
    picture = pixels(wing)
    where = seen(wing, picture)
    ground = luminance(picture)[~where].max()
    contrast = (luminance(picture)[where] + 0.05) / (ground + 0.05)
    assert np.mean(contrast >= 3) > 0.97


def test_the_picture_opens_on_the_wall_and_the_far_field_is_a_click_away(wing: Any):
    outer = wing.window.scene.bodies["body1"]._far
    assert not outer.GetVisibility()
    wing.trigger("view.outer")
    wing.idle()
    assert outer.GetVisibility()


def test_displacement_is_told_by_colour_with_a_scale_live_and_taken_off_again(wing: Any):
    document, looks = wing.window.document, wing.window.looks
    plain = pixels(wing)
    wing.trigger("view.look_displacement")
    wing.idle()
    assert looks.limit == 0
    edit = document.edit([(2, 2, 2)])
    edit.translate([0, 0, 0.125])
    wing.painted()  # during the drag
    moved = np.linalg.norm(
        document.points("body1") - wing.window.scene.bodies["body1"].rest, axis=1
    )
    assert moved.max() <= looks.limit <= 2.5 * moved.max()
    [bar] = wing.window.viewport.overlay.layers["look"]
    assert (bar.title, bar.texts[0]) == ("Displacement", "0")
    edit.abort()
    wing.trigger("view.look_shaded")
    wing.idle()
    assert wing.window.viewport.overlay.layers["look"] == ()
    assert np.abs(pixels(wing) - plain).mean() < 0.1


@pytest.mark.parametrize("look", ["reflection", "curvature", "matte"])
def test_every_look_changes_the_picture(wing: Any, look: str):
    plain = pixels(wing)
    wing.trigger(f"view.look_{look}")
    assert np.abs(pixels(wing) - plain)[seen(wing, plain)].mean() > 3


def test_edges_fade_with_their_density(user: Any):
    from dataclasses import replace

    user.open(sample("wing_skin.vtu"))
    viewport, actor = user.window.viewport, user.window.scene.bodies["body1"]
    near = actor.full.faces.GetProperty().GetEdgeOpacity()
    viewport.view = replace(viewport.view, distance=30 * viewport.view.distance)
    user.painted()
    assert actor.full.faces.GetProperty().GetEdgeOpacity() == 0 < near


def test_ghosts_of_bodies_that_share_a_surface_do_not_add_up(user: Any):
    user.open(sample("wing_skin.vtu"))
    user.window.studio.state.show(edges=False)
    scene = user.window.scene
    plain = pixels(user)

    def through() -> float:
        for actor in scene.bodies.values():
            actor.full.show(False)
        picture = pixels(user)
        return float((np.abs(picture - empty).max(axis=2) > 8).sum())

    where = seen(user, plain)
    for actor in scene.bodies.values():
        actor.full.show(False)
    empty = pixels(user)
    user.trigger("view.ghost")
    alone = through()
    user.open(sample("wing_air.su2"))
    user.window.studio.state.show(edges=False)
    both = through()
    assert 0.1 * where.sum() < alone < 0.5 * where.sum()
    assert both < 1.3 * alone
