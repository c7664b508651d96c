"""The viewer's place: plain arithmetic, checked against the camera that it makes."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.gui.navigation import AXIS_VIEWS, fitted, looking, orbit, pan, zoom

HEIGHT = 600.0
ASPECT = 1.5


def pixel(view, point):
    """Where a point is seen, from the middle of the picture, y upwards."""
    offset = np.asarray(point) - view.focal
    depth = view.distance if view.parallel else view.distance - offset @ view.back
    scale = HEIGHT / 2 / view.half_height * view.distance / depth
    return scale * np.array([offset @ view.right, offset @ view.up])


@pytest.fixture
def view():
    return fitted(looking(*AXIS_VIEWS["corner"]), [[-1, -2, -3], [4, 5, 6]], ASPECT)


def orthonormal(view):
    frame = np.array([view.right, view.up, view.back])
    return np.allclose(frame @ frame.T, np.eye(3)) and np.linalg.det(frame) > 0


@pytest.mark.parametrize("side", AXIS_VIEWS)
@pytest.mark.parametrize("parallel", [False, True])
def test_fitting_shows_all_corners_and_wastes_little(side, parallel):
    from dataclasses import replace

    bounds = np.array([[-1.0, -2, -3], [4, 5, 6]])
    view = fitted(replace(looking(*AXIS_VIEWS[side]), parallel=parallel), bounds, ASPECT)
    corners = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T
    seen = np.abs([pixel(view, corner) for corner in corners]).max(axis=0)
    share = seen / [HEIGHT / 2 * ASPECT, HEIGHT / 2]
    assert 0.5 < share.max() < 1.0


def test_turning_keeps_the_frame_and_the_focal_point(view):
    for dx, dy in np.random.default_rng(1).normal(0, 80, (50, 2)):
        turned = orbit(view, dx, dy)
        assert orthonormal(turned)
        assert (turned.focal == view.focal).all()
        assert turned.distance == view.distance
        view = turned


def test_a_flat_view_does_not_turn():
    from dataclasses import replace

    view = replace(looking(*AXIS_VIEWS["+z"]), flat=True)
    assert orbit(view, 30, 40) is view


def test_shifting_takes_the_focal_plane_along_with_the_cursor(view):
    moved = pan(view, 30, -20, HEIGHT)
    assert pixel(moved, view.focal) == pytest.approx([30, 20])


def test_coming_closer_keeps_what_is_under_the_cursor(view):
    x, y = 120.0, -70.0
    scale = 2 * view.half_height / HEIGHT
    under = view.focal + scale * (x * view.right + y * view.up)
    closer = zoom(view, 3, x, y, HEIGHT)
    assert pixel(closer, under) == pytest.approx([x, y])
    assert closer.distance < view.distance
