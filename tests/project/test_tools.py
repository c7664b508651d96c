"""Gestures, replayed as events: no window needed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.feedback import vector_text, weight_handle
from ffdstudio.project.interaction.spread import Mirror, Soft
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.view.camera import Camera
from tests.project.scenes import BOX, look, opened, write_cube, write_square

POINT = (2, 1, 2)


class Hand:
    """A user with a mouse and a keyboard."""

    def __init__(self, document: Document, camera: Camera | None = None) -> None:
        self.document = document
        self.tools = Tools(document)
        self.camera = look() if camera is None else camera

    def pixel(self, point: tuple[int, ...]) -> np.ndarray:
        item = self.document.model.active_lattice
        assert item is not None
        return self.camera.project(item.current.control_points[point])[0]

    def send(self, kind: str, at: np.ndarray | tuple[float, ...] = (0, 0), **rest: object) -> bool:
        return self.tools.handle(PointerEvent(kind, self.camera, *map(float, at), **rest))  # type: ignore[arg-type]

    def press(self, at: np.ndarray | tuple[float, ...], **rest: object) -> bool:
        return self.send("press", at, button="left", **rest)

    def release(self, at: np.ndarray | tuple[float, ...], **rest: object) -> bool:
        return self.send("release", at, button="left", **rest)

    def key(self, key: str, **rest: object) -> bool:
        return self.send("key", key=key, **rest)

    def click(self, at: np.ndarray | tuple[float, ...], **rest: object) -> None:
        self.press(at, **rest)
        self.release(at, **rest)

    def drag(self, point: tuple[int, ...], by: tuple[float, float], **rest: object) -> None:
        begin = self.pixel(point)
        self.press(begin)
        for share in (0.1, 0.5, 1.0):
            self.send("move", begin + share * np.array(by), **rest)
        self.release(begin + by, **rest)

    @property
    def net(self) -> np.ndarray:
        item = self.document.model.active_lattice
        assert item is not None
        return item.current.control_points


@pytest.fixture(params=[False, True], ids=["perspective", "parallel"])
def hand(request: pytest.FixtureRequest, tmp_path: Path) -> Hand:
    document = opened(write_cube(tmp_path / "cube.su2"), BOX)
    return Hand(document, look(parallel=request.param))


def test_a_drag_moves_the_point_under_the_cursor_and_is_one_entry(hand: Hand) -> None:
    begin = hand.pixel(POINT)
    hand.drag(POINT, (70.0, -30.0))
    np.testing.assert_allclose(hand.pixel(POINT), begin + [70, -30], atol=1e-6)
    assert hand.document.history.labels[2:] == ["Move point (2, 1, 2)"]
    assert hand.document.selection == {POINT}
    assert not hand.tools.busy


def test_the_camera_gets_what_hits_no_point(hand: Hand) -> None:
    assert not hand.press((5, 5))
    assert not hand.press(hand.pixel(POINT), alt=True)
    assert not hand.send("press", hand.pixel(POINT), button="middle")
    assert not hand.send("move", (100, 100))
    assert not hand.key("Q")


def test_clicks_select_and_shift_clicks_toggle(hand: Hand) -> None:
    hand.click(hand.pixel((1, 1, 3)))
    hand.click(hand.pixel((2, 1, 3)), shift=True)
    assert hand.document.selection == {(1, 1, 3), (2, 1, 3)}
    hand.click(hand.pixel((1, 1, 3)), shift=True)
    assert hand.document.selection == {(2, 1, 3)}
    hand.document.select([(1, 1, 3), (2, 1, 3)])
    hand.click(hand.pixel((1, 1, 3)))
    assert hand.document.selection == {(1, 1, 3)}
    assert len(hand.document.history.entries) == 2


def test_a_drag_of_one_selected_point_takes_the_others_along(hand: Hand) -> None:
    hand.document.select([(1, 1, 3), (2, 1, 3)])
    before = hand.net.copy()
    hand.drag((1, 1, 3), (40.0, 40.0))
    moved = hand.net - before
    assert np.count_nonzero(moved.any(axis=-1)) == 2
    np.testing.assert_allclose(moved[1, 1, 3], moved[2, 1, 3], atol=1e-15)


@pytest.mark.parametrize(("key", "free"), [("X", [0]), ("Y", [1]), ("Z", [2])])
def test_keys_lock_to_an_axis_and_with_shift_to_the_plane(
    hand: Hand, key: str, free: list[int]
) -> None:
    begin, before = hand.pixel(POINT), hand.net.copy()
    hand.press(begin)
    hand.send("move", begin + [50, 20])
    hand.key(key)
    assert hand.tools.feedback.lock is not None
    assert np.flatnonzero(hand.net[POINT] - before[POINT]).tolist() == free
    hand.key(key, shift=True)
    assert key not in hand.tools.feedback.lock.name
    moved = hand.net[POINT] - before[POINT]
    assert np.flatnonzero(moved).tolist() == [k for k in range(3) if k not in free]
    hand.key(key, shift=True)  # the same again frees
    hand.send("move", begin + [50, 20])
    np.testing.assert_allclose(hand.pixel(POINT), begin + [50, 20], atol=1e-6)
    hand.release(begin + [50, 20])


@pytest.mark.parametrize("end", ["Escape", "right", "cancel"])
def test_escape_the_right_button_and_cancel_abort(hand: Hand, end: str) -> None:
    model, begin = hand.document.model, hand.pixel(POINT)
    hand.press(begin)
    hand.send("move", begin + [50, 20])
    assert hand.document.model is not model
    if end == "right":
        hand.send("press", begin, button="right")
    elif end == "cancel":
        hand.send("cancel")
    else:
        hand.key(end)
    assert hand.document.model is model
    assert not hand.tools.busy
    assert not hand.release(begin)


def test_loss_of_focus_commits(hand: Hand) -> None:
    begin = hand.pixel(POINT)
    hand.press(begin)
    hand.send("move", begin + [50, 20])
    hand.send("lost")
    assert len(hand.document.history.entries) == 3


def test_shift_moves_a_tenth_from_the_start_and_back(hand: Hand) -> None:
    begin, before = hand.pixel(POINT), hand.net[POINT].copy()
    hand.press(begin)
    hand.send("move", begin + [50, 20])
    full = hand.net[POINT] - before
    hand.send("move", begin + [50, 20], shift=True)
    np.testing.assert_allclose(hand.net[POINT] - before, full / 10, atol=1e-15)
    hand.send("move", begin + [50, 20])
    np.testing.assert_array_equal(hand.net[POINT] - before, full)
    hand.release(begin + [50, 20])


def test_control_snaps(hand: Hand) -> None:
    before = hand.net[POINT].copy()
    hand.drag(POINT, (83.0, -31.0), ctrl=True)
    moved = (hand.net[POINT] - before) / 0.01
    np.testing.assert_allclose(moved, np.round(moved), atol=1e-6)
    assert moved.any()


def test_the_weight_handle_stays_under_the_cursor(hand: Hand) -> None:
    hand.document.select([POINT])
    item = hand.document.model.active_lattice
    assert item is not None
    handle = np.array(weight_handle(hand.camera, item.current.control_points[POINT], 1.0))
    hand.press(handle)
    hand.send("move", handle + [0, -20])
    hand.release(handle + [0, -20])
    item = hand.document.model.active_lattice
    assert item is not None
    weight = item.current.weights[POINT]
    assert weight > 1
    assert hand.document.history.labels[2:] == ["Weight of point (2, 1, 2)"]
    place = item.current.control_points[POINT]
    np.testing.assert_allclose(weight_handle(hand.camera, place, weight), handle + [0, -20])


@pytest.mark.parametrize(
    ("pixels", "fine", "weight"), [(40, False, 2.0), (80, False, 4.0), (80, True, 2**0.2)]
)
def test_the_weight_doubles_every_forty_pixels_and_shift_is_fine(
    hand: Hand, pixels: float, fine: bool, weight: float
) -> None:
    hand.document.select([POINT])
    item = hand.document.model.active_lattice
    assert item is not None
    handle = np.array(weight_handle(hand.camera, item.current.control_points[POINT], 1.0))
    hand.press(handle)
    hand.send("move", handle - [0, pixels], shift=fine)
    hand.release(handle - [0, pixels])
    item = hand.document.model.active_lattice
    assert item is not None
    assert item.current.weights[POINT] == pytest.approx(weight)


def test_a_band_selects_what_is_inside(hand: Hand) -> None:
    hand.tools.options = Options(mode="box")
    low, high = hand.pixel((1, 1, 3)) - 5, hand.pixel((1, 1, 3)) + 5
    hand.press(low)
    hand.send("move", high)
    assert hand.tools.feedback.band is not None
    hand.release(high)
    assert (1, 1, 3) in hand.document.selection
    before = hand.document.selection
    hand.press((0, 0))
    hand.send("move", (800, 600))
    hand.key("Escape")
    assert hand.document.selection == before
    hand.press((0, 0))
    hand.release((800, 600))
    assert len(hand.document.selection) == 64


def test_arrow_keys_nudge_along_the_axis_most_like_the_arrow(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"), BOX)
    hand = Hand(document, look((0.5, -5.0, 0.5)))
    document.select([POINT])
    before = hand.net[POINT].copy()
    assert hand.key("Right")
    assert hand.key("Up")
    moved = hand.net[POINT] - before
    assert moved[0] == pytest.approx(moved[2])
    assert moved[0] > 0
    assert moved[1] == 0
    hand.key("Left", shift=True)
    assert (hand.net[POINT] - before)[0] == pytest.approx(0.9 * moved[0])
    document.select([])
    assert not hand.key("Right")


def test_rotation_turns_about_the_centroid_as_seen(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"), BOX)
    hand = Hand(document, look((0.5, 0.5, 9.0)))
    hand.tools.options = Options(mode="rotate")
    chosen = [(0, 0, 3), (3, 0, 3), (0, 3, 3), (3, 3, 3)]
    document.select(chosen)
    before = hand.net.copy()
    centre = hand.camera.project([0.5, 0.5, 1.1])[0]
    begin = hand.pixel((3, 3, 3))
    quarter = centre + np.array([begin[1] - centre[1], -(begin[0] - centre[0])])
    hand.press(begin)
    hand.send("move", begin + [0, 9])
    hand.send("move", quarter)
    assert hand.tools.feedback.text == "90°"
    hand.release(quarter)
    np.testing.assert_allclose(hand.net[3, 3, 3], before[0, 3, 3], atol=1e-6)
    np.testing.assert_allclose(hand.net[0, 3, 3], before[0, 0, 3], atol=1e-6)


def test_scaling_follows_the_distance_to_the_centroid_and_locks(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"), BOX)
    hand = Hand(document, look((0.5, 0.5, 9.0)))
    hand.tools.options = Options(mode="scale")
    document.select([(0, 0, 3), (3, 0, 3), (0, 3, 3), (3, 3, 3)])
    centre, begin = hand.camera.project([0.5, 0.5, 1.1])[0], hand.pixel((3, 3, 3))
    hand.press(begin)
    hand.send("move", centre + 2 * (begin - centre))
    np.testing.assert_allclose(hand.net[3, 3, 3], [1.7, 1.7, 1.1])
    hand.key("Y")
    np.testing.assert_allclose(hand.net[3, 3, 3], [1.1, 1.7, 1.1])
    hand.key("Y", shift=True)
    np.testing.assert_allclose(hand.net[3, 3, 3], [1.7, 1.1, 1.1])
    hand.release(begin)


def test_soft_selection_falls_off_and_the_wheel_changes_its_radius(hand: Hand) -> None:
    hand.tools.options = Options(soft=Soft(0.5, "linear"))
    begin, before = hand.pixel(POINT), hand.net.copy()
    hand.press(begin)
    hand.send("move", begin + [60, 0])
    full = np.linalg.norm(hand.net[POINT] - before[POINT])
    distance = np.linalg.norm(before - before[POINT], axis=-1)
    expected = full * np.clip(1 - distance / 0.5, 0, 1)
    np.testing.assert_allclose(np.linalg.norm(hand.net - before, axis=-1), expected, atol=1e-12)
    hand.send("wheel", begin + [60, 0], steps=2.0)
    assert hand.tools.feedback.radius == pytest.approx(0.5 * 1.1**2)
    hand.release(begin + [60, 0])
    changed = np.linalg.norm(hand.net - before, axis=-1) > 0
    assert np.array_equal(changed, distance < 0.5 * 1.1**2)
    assert len(hand.document.history.entries) == 3


def test_mirror_editing_moves_the_partner_and_keeps_the_plane(hand: Hand) -> None:
    box = replace(BOX, name="Odd", shape=(5, 4, 4))
    hand.document.do(box)
    hand.tools.options = Options(mirror=Mirror(0, 0.5))
    hand.document.select([(1, 1, 3), (2, 1, 3)])
    before = hand.net.copy()
    hand.drag((1, 1, 3), (60.0, -30.0))
    moved = hand.net - before
    assert moved[2, 1, 3][0] == 0
    assert moved[1, 1, 3][0] != 0
    np.testing.assert_allclose(moved[3, 1, 3], moved[1, 1, 3] * [-1, 1, 1], atol=1e-15)
    assert np.count_nonzero(moved.any(axis=-1)) == 3
    hand.tools.options = Options(mirror=Mirror(0, 0.5, both=False))
    hand.drag((1, 1, 3), (10.0, -30.0))
    np.testing.assert_array_equal(hand.net[3, 1, 3] - before[3, 1, 3], moved[3, 1, 3])


def test_flat_meshes_stay_in_their_plane(tmp_path: Path) -> None:
    box = c.CreateBox("Box", (-0.1, -0.1, -0.1), (1.1, 1.1, 0.1), (4, 4, 2), (3, 3, 1))
    document = opened(write_square(tmp_path / "square.su2"), box)
    hand = Hand(document, look((1.0, -3.0, 4.0)))
    before = hand.net.copy()
    hand.drag((1, 1, 1), (50.0, 10.0))
    moved = hand.net - before
    assert moved[..., 2].any() == False  # noqa: E712
    assert moved.any()


def test_frozen_and_hidden_points_cannot_be_dragged(hand: Hand) -> None:
    hand.document.do(c.FreezeLayers("lattice2", 1))
    hand.drag((3, 3, 3), (50.0, 10.0))
    assert not hand.document.model.lattices[0].deformed
    hand.document.do(c.Show(("lattice2",), False))
    assert not hand.press(hand.pixel((3, 3, 3)))


def test_dragging_a_frozen_point_says_why_nothing_moves(hand: Hand) -> None:
    hand.document.do(c.FreezeLayers("lattice2", 1))
    begin = hand.pixel((3, 3, 3))
    hand.press(begin)
    hand.send("move", begin + (40, 10))
    assert hand.tools.feedback.text.startswith("frozen")
    assert hand.tools.feedback.at == tuple(begin + (40, 10))
    hand.release(begin + (40, 10))
    assert not hand.tools.feedback.text
    assert not hand.tools.busy
    assert hand.document.editing is None


def test_a_free_point_is_hit_where_a_frozen_one_covers_it(hand: Hand) -> None:
    hand.document.do(c.FreezeLayers("lattice2", 1))
    covered, cover = hand.net[1, 2, 2], hand.net[1, 2, 3]
    hand.camera = look(eye=tuple(covered + 5 * (cover - covered)), at=tuple(covered))
    front, behind = hand.pixel((1, 2, 3)), hand.pixel((1, 2, 2))
    assert np.hypot(*(front - behind)) < 1e-6
    assert hand.tools.hit(PointerEvent("move", hand.camera, *front)) == (1, 2, 2)


def test_a_gesture_survives_that_its_edit_ends_elsewhere(hand: Hand) -> None:
    begin = hand.pixel(POINT)
    hand.press(begin)
    hand.send("move", begin + [50, 20])
    hand.document.undo()
    hand.send("move", begin + [60, 20])
    assert not hand.document.model.lattices[0].deformed
    hand.release(begin + [60, 20])
    assert not hand.tools.busy


def test_cancel_leaves_nothing_behind(hand: Hand) -> None:
    model, begin = hand.document.model, hand.pixel(POINT)
    hand.press(begin)
    hand.send("move", begin + [50, 20])
    hand.tools.cancel()
    assert hand.document.model is model
    assert hand.document.editing is None


@pytest.fixture
def flat(tmp_path: Path) -> Hand:
    """A flat mesh in a lattice of three directions, seen from the side."""
    box = c.CreateBox("Box", (-0.1, -0.1, -1.0), (1.1, 1.1, 1.0), (4, 4, 4), (3, 3, 3))
    return Hand(opened(write_square(tmp_path / "square.su2"), box))


@pytest.mark.parametrize("mode", ["move", "rotate", "scale"])
@pytest.mark.parametrize("key", ["X", "Y", "Z"])
@pytest.mark.parametrize("shift", [False, True])
def test_no_key_takes_a_flat_mesh_out_of_its_plane(
    flat: Hand, mode: str, key: str, shift: bool
) -> None:
    flat.tools.options = Options(mode=mode)
    flat.document.select([(1, 1, 2), (2, 2, 2)])
    before, begin = flat.net.copy(), flat.pixel((1, 1, 2))
    flat.press(begin)
    flat.send("move", begin + (30, 0))
    flat.key(key, shift=shift)
    flat.send("move", begin + (60, -40))
    flat.release(begin + (60, -40))
    assert np.abs((flat.net - before)[..., :2]).max() > 0.01
    assert np.abs((flat.net - before)[..., 2]).max() < 1e-12


def test_a_plane_lock_of_a_flat_mesh_leaves_the_axis_in_both(flat: Hand) -> None:
    before, begin = flat.net.copy(), flat.pixel((1, 1, 2))
    flat.press(begin)
    flat.send("move", begin + (30, 0))
    flat.key("X", shift=True)
    flat.send("move", begin + (60, -40))
    assert "[Y]" in flat.tools.feedback.text
    flat.key("X", shift=True)  # the same again frees
    assert "[" not in flat.tools.feedback.text
    flat.key("Escape")
    assert (flat.net == before).all()


def test_arrow_keys_keep_a_flat_mesh_in_its_plane(flat: Hand) -> None:
    flat.document.select([(1, 1, 2)])
    flat.camera = look(eye=(4.0, 0.5, 0.6))  # up on the screen is z
    before = flat.net.copy()
    for key in ("Up", "Left"):
        assert flat.key(key)
    assert ((flat.net - before)[..., 2] == 0).all()


def test_the_read_out_of_a_displacement_shows_no_rounding():
    assert vector_text(np.array([-1.1e-16, 0.05, 0.0]), None) == "Δ 0, 0.05, 0   length 0.05"
    assert vector_text(np.zeros(3), None) == "Δ 0, 0, 0   length 0"
