"""A point of the mesh goes where the mouse takes it, by the smallest move of control points."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.project.checks.guarding import DragGuard
from ffdstudio.project.commands import CreateBox
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.skin import handle_of, skin_under
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.view.camera import Camera
from tests.project.scenes import opened, write_cube

BOX = CreateBox("Box", (-0.1, -0.1, -0.1), (1.1, 1.1, 1.1), (4, 4, 4), (3, 3, 3))
CAMERA = Camera(
    np.array([[1.4, 0, 0.3, -0.7], [0, 1.4, 0.2, -0.7], [0, 0, -0.1, 0.05], [0, 0, 0, 1.0]]),
    400,
    400,
)


def tools_of(document, mode="free"):
    tools = Tools(document, Options("skin"))
    tools.guard_with(DragGuard(document, mode))
    return tools


def on_top(document):
    """Displayed point in the middle of the face z = 1."""
    [body] = document.model.bodies
    points = document.points(body.key)
    row = int(np.argmin(np.linalg.norm(points - [0.5, 0.5, 1], axis=1)))
    return body.key, row, CAMERA.project(points[row])[0]


def drag(tools, start, end):
    tools.handle(PointerEvent("press", CAMERA, *start, "left"))
    for step in np.linspace(0.1, 1, 6):
        tools.handle(PointerEvent("move", CAMERA, *(start + step * (np.array(end) - start))))
    said = tools.feedback
    tools.handle(PointerEvent("release", CAMERA, *end, "left"))
    return said


@pytest.fixture
def document(tmp_path):
    return opened(write_cube(tmp_path / "cube.su2", n=4), BOX)


def test_the_point_under_the_cursor_stays_under_it(document):
    key, row, start = on_top(document)
    drag(tools_of(document), start, start + [30, -20])
    now = CAMERA.project(document.points(key)[row])[0]
    assert np.abs(now - start - [30, -20]).max() < 0.01
    assert len(document.history.labels) == 3


def test_the_move_of_control_points_is_the_smallest_that_does_it(document):
    key, row, start = on_top(document)
    skin = skin_under(document, tools_of(document).occluders, CAMERA, *start)
    assert (skin.body, skin.row) == (key, row)
    handle = handle_of(document, skin)
    from ffdstudio.engine import embed

    item, wanted = document.model.active_lattice, np.array([0.1, -0.2, 0.05])
    jacobian = embed(item.rest, skin.place[None]).jacobian(item.current).toarray()
    least = np.linalg.lstsq(jacobian, wanted[None], rcond=None)[0].reshape(*item.rest.shape, 3)
    found = np.zeros_like(least)
    found[tuple(np.array(handle.points).T)] = handle.move(wanted)
    assert np.allclose(found, least, atol=1e-9)


def test_selected_points_are_held_and_frozen_ones_too(document):
    document.select([(1, 1, 3), (2, 2, 3)])
    key, row, start = on_top(document)
    before = document.model.active_lattice.current.control_points
    drag(tools_of(document), start, start + [25, 5])
    after = document.model.active_lattice.current.control_points
    for point in document.selection:
        assert (after[point] == before[point]).all()
    assert np.abs(CAMERA.project(document.points(key)[row])[0] - start - [25, 5]).max() < 0.01


def test_points_on_a_symmetry_plane_stay_on_it_and_the_skin_still_follows(tmp_path):
    path = write_cube(tmp_path / "half.su2", n=4, low="SYMMETRY")
    box = CreateBox("Box", (0.0, -0.1, -0.1), (1.1, 1.1, 1.1), (4, 4, 4), (3, 3, 3))
    document = opened(path, box)
    [body] = document.model.bodies
    points = document.points(body.key)
    row = int(np.argmin(np.linalg.norm(points - [0.25, 0.5, 1], axis=1)))
    start = CAMERA.project(points[row])[0]
    drag(tools_of(document), start, start + [12, -8])
    assert np.abs(CAMERA.project(document.points(body.key)[row])[0] - start - [12, -8]).max() < 0.01
    net = document.model.active_lattice.current.control_points
    assert (net[0, ..., 0] == 0).all()


def test_it_is_guarded(document):
    _, _, start = on_top(document)
    said = drag(tools_of(document, "stop"), start, start + [900, 0])
    assert said.verdict.held
    [body] = document.model.bodies
    assert document.volume(body.key).inverted == 0


def test_beside_the_mesh_the_drag_is_the_cameras(document):
    tools = tools_of(document)
    assert not tools.handle(PointerEvent("press", CAMERA, 2, 2, "left"))
