"""Everything that moves a mesh ends before the first inverted cell, or says that it has passed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ffdstudio.meshes import inverted
from ffdstudio.project.checks import motion_guard
from ffdstudio.project.checks.guarding import DragGuard
from ffdstudio.project.commands import CreateBox
from ffdstudio.project.interaction import numeric_edits
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.spread import Mirror, Soft
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.interaction.transforms import rotation
from ffdstudio.project.view.camera import Camera
from tests.project.scenes import opened, write_cube

BOX = CreateBox("Box", (-0.1, -0.1, -0.1), (1.1, 1.1, 1.1), (4, 4, 4), (3, 3, 3))
INNER = [(i, j, k) for i in (1, 2) for j in (1, 2) for k in (1, 2, 3)]
CAMERA = Camera(
    np.array([[1.4, 0, 0, -0.7], [0, 1.4, 0, -0.7], [0, 0, -0.1, 0.05], [0, 0, 0, 1.0]]), 400, 400
)


@pytest.fixture
def document(tmp_path):
    return opened(write_cube(tmp_path / "cube.su2", n=6), BOX)


def tools_of(document, mode, options=None):
    tools = Tools(document, options or Options())
    tools.guard_with(DragGuard(document, mode))
    return tools


def count(document):
    [body] = document.model.bodies
    volume = document.volume(body.key)
    assert volume is not None
    assert volume.inverted == inverted(body.mesh, volume.points).count
    return volume.inverted


def drag(tools, start, end):
    """Press at a pixel, move to another in steps, let go."""
    tools.handle(PointerEvent("press", CAMERA, *start, "left"))
    for step in np.linspace(0.1, 1, 10):
        x, y = np.array(start) + step * (np.array(end) - start)
        tools.handle(PointerEvent("move", CAMERA, x, y))
    said = tools.feedback
    tools.handle(PointerEvent("release", CAMERA, *end, "left"))
    return said


def at(document, point):
    return CAMERA.project(document.model.active_lattice.current.control_points[point])[0]


def far(document, tools):
    """A drag of the chosen points that inverts cells by far, unless it is stopped."""
    start = at(document, (2, 2, 3))
    if tools.options.mode == "rotate":
        centre = CAMERA.project(tools.pivot())[0]
        a = np.radians(170)
        turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        return start, centre + turn @ (start - centre)
    return start, start + [0, 3000]


MOTIONS = {
    "rotate": (Options("rotate"), INNER),
    "scale": (Options("scale"), INNER),
    "soft": (Options(soft=Soft(0.5)), [(2, 2, 3)]),
    "mirror": (Options(mirror=Mirror(0, 0.5)), [(2, 2, 3)]),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_is_stopped_before_the_first_cell_inverts_and_ends_near_it(
    document, tmp_path, name
):
    options, chosen = MOTIONS[name]
    if name == "rotate":  # a coarse net only twists, which inverts nothing
        document = opened(tmp_path / "cube.su2", replace(BOX, shape=(10, 10, 4)))
        chosen = [(i, j, k) for i in range(2, 8) for j in range(2, 8) for k in range(4)]
    for mode in ("free", "warn", "stop"):
        document.select(chosen)
        tools = tools_of(document, mode, options)
        said = drag(tools, *far(document, tools))
        if mode == "stop":
            assert count(document) == 0
            assert said.verdict.held
            assert said.verdict.reason == "a cell inverts"
            assert said.verdict.stop.amplitude < 1
            assert not np.array_equal(
                document.model.active_lattice.current.control_points,
                document.model.active_lattice.rest.control_points,
            )
        else:
            assert count(document) > 0
            assert (said.verdict.beyond if mode == "warn" else True) is True
            document.undo()


def test_a_rotation_is_stopped_within_a_hair_of_where_it_inverts(tmp_path):
    path = write_cube(tmp_path / "cube.su2", n=6)
    document = opened(path, replace(BOX, shape=(10, 10, 4)))
    document.select([(i, j, k) for i in range(2, 8) for j in range(2, 8) for k in range(4)])
    tools = tools_of(document, "stop", Options("rotate"))
    said = drag(tools, *far(document, tools))
    limit = said.verdict.place
    assert 30 < limit < 90
    assert float(said.text.rstrip("°")) == pytest.approx(limit, rel=2e-3)
    document.undo()
    for share, broken in ((0.9999, False), (1.0001, True)):
        edit = document.edit()
        edit.guarded = True
        edit.place(rotation([0, 0, 1], share * limit, tools.pivot())(edit.start))
        edit.commit()
        assert (count(document) > 0) is broken
        document.undo()


def test_weights_are_guarded(document):
    document.select([(1, 1, 1)])
    start = document.model.active_lattice.current
    edit = document.edit()
    edit.place(edit.start + [0.3, 0.25, 0.2])
    edit.commit()
    tools = tools_of(document, "stop")
    from ffdstudio.project.interaction.feedback import weight_handle

    place = document.model.active_lattice.current.control_points[1, 1, 1]
    x, y = weight_handle(CAMERA, place, 1.0)
    drag(tools, (x, y), (x, y - 390))
    assert count(document) == 0
    assert document.model.active_lattice.current.weights[1, 1, 1] > 1
    assert start.weights[1, 1, 1] == 1


def test_typed_values_are_stopped_and_said_and_small_ones_are_not(document):
    tools_of(document, "stop")
    told = []
    document.told.connect(told.append)
    document.select([(2, 2, 2)])
    numeric_edits.set_displacement(document, (0.01, 0, 0))
    assert told == []
    item = document.model.active_lattice
    assert item.current.control_points[2, 2, 2, 0] - item.rest.control_points[2, 2, 2, 0] == (
        pytest.approx(0.01)
    )
    numeric_edits.set_displacement(document, (-50.0, 0, 0))
    assert count(document) == 0
    assert len(told) == 1
    assert told[0].endswith("a cell of cube inverts")
    document.undo()
    numeric_edits.set_weight(document, 2.0)
    assert document.model.active_lattice.current.weights[2, 2, 2] == 2


def test_where_a_worker_has_to_be_asked_a_drag_waits_and_never_runs_ahead(document, monkeypatch):
    monkeypatch.setattr(motion_guard, "AT_ONCE", 0)
    waiting = []

    class Later:
        def start(self, label, work, done, failed=None, key="", cancelled=None, line=""):
            waiting.append((work, done))

    options, chosen = MOTIONS["scale"]
    document.select(chosen)
    tools = tools_of(document, "stop", options)
    document.runner = Later()
    start, end = far(document, tools)
    tools.handle(PointerEvent("press", CAMERA, *start, "left"))
    tools.handle(PointerEvent("move", CAMERA, *end))
    before = document.model.active_lattice.rest.control_points
    assert tools.feedback.verdict.state == "waiting"
    assert np.allclose(document.model.active_lattice.current.control_points, before)
    while waiting:  # the set-up, then the answer
        work, done = waiting.pop(0)
        done(work(lambda fraction, text: None))
    assert tools.feedback.verdict.held
    assert not np.allclose(document.model.active_lattice.current.control_points, before)
    tools.cancel()
