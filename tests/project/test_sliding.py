"""Control points on planes slide in them, and lattices begin at planes."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.engine import Lattice
from ffdstudio.engine.boxes import Frame
from ffdstudio.meshes.planes import Plane
from ffdstudio.project.checks.plane_snapping import seat_sentence, seated
from ffdstudio.project.plane_constraints import alike, leaving, names_at, slid

NONE = np.arange(0)


def plane(normal: list[float], offset: float = 0.0, name: str = "SYM") -> Plane:
    unit = np.array(normal) / np.linalg.norm(normal)
    return Plane(name, "symmetry", NONE, unit, offset)


BOX = Lattice.box([0, 0, 0], [1, 2, 3], shape=(3, 3, 3))


def everywhere() -> tuple[np.ndarray, ...]:
    return tuple(np.array(list(np.ndindex(3, 3, 3))).T)


def test_points_on_a_plane_keep_their_height_bit_for_bit_and_others_go_freely() -> None:
    where = everywhere()
    rest = BOX.control_points[where]
    wanted = rest + np.random.default_rng(0).standard_normal(rest.shape)
    new = slid(BOX, where, wanted, [plane([0, 1, 0])])
    on = rest[:, 1] == 0
    assert (new[on, 1] == 0).all()
    assert np.array_equal(new[on][:, [0, 2]], wanted[on][:, [0, 2]])
    assert np.array_equal(new[~on], wanted[~on])


def test_on_two_planes_the_common_line_is_free_and_on_three_nothing() -> None:
    oblique = plane([1, 1, 0])  # through the edge x = y = 0, with plane y = 0
    corner, wanted = tuple(np.zeros((3, 1), dtype=int)), np.array([[0.5, 0.25, 0.75]])
    planes = [plane([0, 1, 0]), oblique]
    assert slid(BOX, corner, wanted, planes) == pytest.approx(np.array([[0, 0, 0.75]]), abs=1e-15)
    planes.append(plane([0, 0, 1]))
    assert slid(BOX, corner, wanted, planes) == pytest.approx(np.zeros((1, 3)), abs=1e-15)


def test_in_an_oblique_plane_the_motion_is_the_projection_found_by_least_squares() -> None:
    normal = np.array([0.6, 0.0, 0.8])
    corner, wanted = tuple(np.zeros((3, 1), dtype=int)), np.array([[0.5, 0.25, 0.75]])
    basis = np.linalg.svd(normal[None])[2][1:].T
    nearest = basis @ np.linalg.lstsq(basis, wanted[0], rcond=None)[0]
    found = slid(BOX, corner, wanted, [plane(normal.tolist())])
    assert found[0] == pytest.approx(nearest, abs=1e-15)


def test_a_vector_is_the_same_for_all_points_only_if_their_planes_are() -> None:
    vector, planes = np.array([1.0, 2.0, 3.0]), [plane([0, 1, 0])]
    on, off = np.array([[0, 0, 0], [1, 0, 1]]), np.array([[1, 1, 1]])
    assert alike(BOX, tuple(off.T), vector, planes) is vector
    found = alike(BOX, tuple(on.T), vector, planes)
    assert found is not None
    assert found.tolist() == [1, 0, 3]
    assert alike(BOX, tuple(np.concatenate([on, off]).T), vector, planes) is None
    assert alike(BOX, tuple(on.T), vector, []) is vector


def test_points_that_leave_are_counted() -> None:
    planes = [plane([0, 1, 0])]
    net = BOX.control_points.copy()
    net[0, 0, 0, 0] += 5  # within the plane
    assert leaving(BOX, BOX.moved(net), planes) == []
    net[0, 0, 0, 1] += 0.5
    net[1, 0, 0, 1] -= 0.25
    net[1, 1, 0, 1] += 3  # not on it
    found = leaving(BOX, BOX.moved(net), planes)
    assert found == ["2 control points on SYM leave its plane, by up to 0.5"]
    assert names_at(BOX, (1, 0, 2), planes) == ("SYM",)
    assert names_at(BOX, (1, 1, 2), planes) == ()


# ---- where a lattice begins -------------------------------------------------------------------


def cloud() -> np.ndarray:
    return np.random.default_rng(0).uniform(0, 1, (50, 3)) * [1, 1, 1] + [0, 1e-12, 0]


def test_a_margin_that_would_reach_over_a_plane_ends_there() -> None:
    frame, nodes = Frame.of(None, 3), cloud()
    bounds = frame.bounds(nodes, 0.2)
    lower, upper, faces = seated(frame, bounds, nodes, [plane([0, 1, 0]), plane([0, 0, 1], 1.0)])
    assert faces == {(1, 0): "SYM", (2, 1): "SYM"}
    assert (lower[1], upper[2]) == (0, 1)
    assert lower[[0, 2]].tolist() == bounds[0][[0, 2]].tolist()
    assert upper[:2].tolist() == bounds[1][:2].tolist()
    assert "The faces j min and k max lie on SYM" in seat_sentence(faces)


def test_planes_far_away_oblique_or_through_the_nodes_change_nothing() -> None:
    frame, nodes = Frame.of(None, 3), cloud()
    bounds = frame.bounds(nodes, 0.2)
    for other in (plane([0, 1, 0], -5), plane([0, 1, 1e-3], 0), plane([0, 1, 0], 0.5)):
        lower, upper, faces = seated(frame, bounds, nodes, [other])
        assert faces == {}
        assert (lower.tolist(), upper.tolist()) == (bounds[0].tolist(), bounds[1].tolist())


def test_in_a_turned_frame_the_face_that_faces_the_plane_is_put_there() -> None:
    axes = np.array([[0, -1.0, 0], [0, 0, 1], [-1, 0, 0]])
    frame, nodes = Frame.of(axes, 3), cloud()
    _, upper, faces = seated(frame, frame.bounds(nodes, 0.2), nodes, [plane([0, 1, 0])])
    assert faces == {(0, 1): "SYM"}
    assert upper[0] == 0


def test_a_box_for_the_nodes_of_the_plane_itself_keeps_its_room() -> None:
    frame, nodes = Frame.of(None, 3), cloud() * [1, 0, 1]
    lower, upper, faces = seated(frame, frame.bounds(nodes, 0.2), nodes, [plane([0, 1, 0])])
    assert faces == {}
    assert lower[1] < 0 < upper[1]
