"""Cameras, picking and drags: against the definition of what should be under the cursor."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffdstudio.project.interaction.dragging import Lock, displacement, snap_step
from ffdstudio.project.interaction.picking import in_rectangle, nearest
from ffdstudio.project.view.camera import Camera
from tests.project.scenes import look

BOTH = pytest.mark.parametrize("parallel", [False, True], ids=["perspective", "parallel"])
ANCHOR = np.array([0.3, 0.2, 0.9])


@BOTH
@settings(max_examples=50, deadline=None)
@given(x=st.floats(0, 800), y=st.floats(0, 600), depth=st.floats(0.5, 20))
def test_a_ray_projects_to_its_pixel(parallel: bool, x: float, y: float, depth: float) -> None:
    camera = look(parallel=parallel)
    ray = camera.ray(x, y)
    np.testing.assert_allclose(
        camera.project(ray.origin + depth * ray.direction), [[x, y]], atol=1e-8
    )


@BOTH
@settings(max_examples=100, deadline=None)
@given(
    eye=st.tuples(*[st.floats(2, 6)] * 3),
    dx=st.floats(-150, 150),
    dy=st.floats(-150, 150),
    grab=st.tuples(st.floats(-8, 8), st.floats(-8, 8)),
    normal=st.sampled_from([None, 0, 1, 2]),
)
def test_free_and_in_a_plane_the_point_stays_under_the_cursor(
    parallel: bool,
    eye: tuple[float, float, float],
    dx: float,
    dy: float,
    grab: tuple[float, float],
    normal: int | None,
) -> None:
    camera = look(eye, parallel=parallel)
    pixel = camera.project(ANCHOR)[0]
    begin = tuple(pixel + grab)
    lock = None if normal is None else Lock.without(normal)
    move = displacement(camera, ANCHOR, begin, (begin[0] + dx, begin[1] + dy), lock)
    if normal is not None:
        assert move[normal] == 0
        view = camera.ray(*(pixel + [dx, dy])).direction
        reached = (ANCHOR - camera.ray(*(pixel + [dx, dy])).origin)[normal] / view[normal] > 0
        if abs(view[normal]) < 0.1 or not reached:  # edge-on: not under the cursor
            return
    np.testing.assert_allclose(camera.project(ANCHOR + move)[0], pixel + [dx, dy], atol=1e-6)


@BOTH
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_on_an_axis_the_point_is_nearest_to_the_ray(parallel: bool, axis: int) -> None:
    camera = look(parallel=parallel)
    pixel = camera.project(ANCHOR)[0]
    move = displacement(camera, ANCHOR, tuple(pixel), tuple(pixel + [40, -25]), Lock.axis(axis))
    assert np.count_nonzero(move) == 1
    ray = camera.ray(*(pixel + [40, -25]))

    def gap(t: float) -> float:
        offset = ANCHOR + t * np.eye(3)[axis] - ray.origin
        return float(np.linalg.norm(np.cross(offset, ray.direction)))

    t = move[axis]
    assert gap(t) <= min(gap(t + 1e-5), gap(t - 1e-5))


@BOTH
def test_along_an_axis_in_the_picture_the_point_stays_under_the_cursor(parallel: bool) -> None:
    camera = look((0.3, 0.2, 6.0), at=(0.3, 0.2, 0.0), parallel=parallel)
    pixel = camera.project(ANCHOR)[0]
    move = displacement(camera, ANCHOR, tuple(pixel), tuple(pixel + [57, 0]), Lock.axis(0))
    np.testing.assert_allclose(camera.project(ANCHOR + move)[0], pixel + [57, 0], atol=1e-6)


@BOTH
def test_an_axis_along_the_view_takes_vertical_travel(parallel: bool) -> None:
    camera = look((0.3, 0.2, 6.0), at=(0.3, 0.2, 0.0), parallel=parallel)
    pixel = tuple(camera.project(ANCHOR)[0])
    up = displacement(camera, ANCHOR, pixel, (pixel[0] + 300, pixel[1] - 50), Lock.axis(2))
    np.testing.assert_allclose(up, [0, 0, 50 * camera.pixel_size(ANCHOR)], rtol=1e-6)


def test_past_the_vanishing_point_a_drag_stays_finite_and_keeps_its_side() -> None:
    camera = look()
    pixel = camera.project(ANCHOR)[0]
    far = [
        displacement(camera, ANCHOR, tuple(pixel), tuple(pixel + [dx, 0]), Lock.axis(0))[0]
        for dx in (50, 400, 3000, 100000)
    ]
    assert np.isfinite(far).all()
    assert all(np.sign(value) == np.sign(far[0]) for value in far)


@BOTH
def test_precision_is_a_tenth_and_snapping_rounds(parallel: bool) -> None:
    camera = look(parallel=parallel)
    drag = (camera, ANCHOR, (100.0, 100.0), (180.0, 60.0))
    full = displacement(*drag)
    np.testing.assert_allclose(displacement(*drag, fine=True), full / 10)
    np.testing.assert_allclose(displacement(*drag, snap=0.1), np.round(full / 0.1) * 0.1)
    oblique = Lock((0.6, 0.8, 0.0), plane=True)
    snapped = displacement(*drag, lock=oblique, snap=0.1)
    assert abs(snapped @ oblique.direction) < 1e-15
    on_axis = displacement(*drag, lock=Lock.axis(1), snap=0.25)
    assert on_axis[1] % 0.25 == 0


def test_a_drag_back_to_where_it_began_moves_nothing() -> None:
    assert not displacement(look(), ANCHOR, (5.0, 5.0), (5.0, 5.0), Lock.axis(0)).any()


def test_the_snap_step_is_round_and_a_few_pixels_wide() -> None:
    for eye in ((2.0, 1.0, 1.0), (20.0, 30.0, 10.0), (300.0, 10.0, 5.0)):
        camera = look(eye)
        step = snap_step(camera, ANCHOR)
        assert 12 <= step / camera.pixel_size(ANCHOR) <= 12 * 2.5
        assert f"{step:.0e}"[0] in "125"


@BOTH
def test_large_coordinates_keep_the_point_under_the_cursor(parallel: bool) -> None:
    shift = np.array([4e6, -3e6, 1e6])
    near = look(parallel=parallel)
    move = np.eye(4)
    move[:3, 3] = -shift
    camera = Camera(near.matrix @ move, near.width, near.height)
    anchor = ANCHOR + shift
    pixel = camera.project(anchor)[0]
    end = displacement(camera, anchor, tuple(pixel), tuple(pixel + [90, 30]))
    np.testing.assert_allclose(camera.project(anchor + end)[0], pixel + [90, 30], atol=0.1)


# ---- picking ----------------------------------------------------------------------------


def test_the_point_in_front_is_picked_where_two_lie_over_one_another() -> None:
    camera = look((0.0, 0.0, 10.0), at=(0.0, 0.0, 0.0))
    points = [[0, 0, -1], [0.001, 0, 1], [0.5, 0, 0]]
    x, y = camera.project([points[0]])[0]
    assert nearest(camera, points, x, y) == 1
    x, y = camera.project([points[2]])[0]
    assert nearest(camera, points, x + 4, y - 4) == 2
    assert nearest(camera, points, x + 40, y) is None


def test_points_behind_the_viewer_are_not_picked() -> None:
    camera = look((0.0, 0.0, 10.0), at=(0.0, 0.0, 0.0))
    assert nearest(camera, [[0, 0, 11.0]], 400, 300, radius=1000) is None
    assert len(in_rectangle(camera, [[0, 0, 11.0], [0, 0, 0]], (0, 0), (800, 600))) == 1


def test_nothing_is_picked_from_nothing() -> None:
    assert nearest(look(), np.zeros((0, 3)), 1, 1) is None


@BOTH
def test_a_rectangle_takes_what_projects_into_it(parallel: bool) -> None:
    camera = look(parallel=parallel)
    points = np.random.default_rng(0).random((200, 3))
    pixels = camera.project(points)
    found = in_rectangle(camera, points, (450, 350), (300, 250))
    expected = [k for k, (x, y) in enumerate(pixels) if 300 <= x <= 450 and 250 <= y <= 350]
    assert found.tolist() == expected
    assert expected
