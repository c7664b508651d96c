"""The viewer's place: plain arithmetic, checked against the camera that it makes."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.gui.navigation import AXIS_VIEWS, fitted, levelled, looking, orbit, pan, zoom

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


def test_what_is_at_the_pivot_stays_where_it_is_seen(view):
    pivot = np.array([2.0, 0.5, 1.0])
    start = pixel(view, pivot)
    for dx, dy in np.random.default_rng(2).normal(0, 40, (20, 2)):
        view = orbit(view, dx, dy, pivot)
        assert pixel(view, pivot) == pytest.approx(start, abs=1e-6)
        assert orthonormal(view)


def test_a_turntable_keeps_the_horizon_level_and_a_rolled_view_is_levelled(view):
    for dx, dy in np.random.default_rng(3).normal(0, 30, (20, 2)):
        view = orbit(view, dx, dy)
        assert abs(view.right[2]) < 1e-9
    rolled = looking(view.back, view.up + 0.5 * view.right, view)
    assert abs(rolled.right[2]) > 0.1
    assert abs(levelled(rolled).right[2]) < 1e-12
    assert np.allclose(levelled(rolled).back, view.back)


def test_the_ends_of_the_triad_are_those_of_the_axes(view):
    from ffdstudio.gui.navigation import CORNER, triad_ends

    middle = np.array([CORNER, HEIGHT - CORNER])
    for name, end in triad_ends(view, HEIGHT).items():
        along = np.eye(3)["xyz".index(name[1])] * (1 if name[0] == "+" else -1)
        way = (np.array(end) - middle) * [1, -1]
        assert np.allclose(way / 34.0, [along @ view.right, along @ view.up])
