"""The guard of a drag, from mouse events to where the drag ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.meshes import inverted
from ffdstudio.project.checks.guarding import DragGuard
from ffdstudio.project.commands import CreateBox, Enable
from ffdstudio.project.document import Document
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.tools import Tools
from tests.project.scenes import BOX, look, opened, write_cube, write_square

POINT = (2, 2, 2)
LAYER = [(2, j, k) for j in range(4) for k in range(4)]
FAR = np.array([-9.0, 1.2, 0.6])


class Later:
    """Runner whose work is done when the test says so."""

    def __init__(self) -> None:
        self.waiting: list = []

    def start(self, label, work, done, failed=None, key="", cancelled=None, line=""):  # type: ignore[no-untyped-def]
        self.waiting.append((work, done, cancelled))

    def cancel(self) -> None:
        waiting, self.waiting = self.waiting, []
        for _, _, cancelled in waiting:
            cancelled()

    def catch_up(self) -> None:
        while self.waiting:
            work, done, _ = self.waiting.pop(0)
            done(work(lambda fraction, text="": None))


def dragged(document: Document, vector: np.ndarray) -> int:
    """Cells that are inverted after a drag of `POINT`."""
    edit = document.edit([POINT])
    edit.translate(vector)
    edit.commit()
    body = document.model.bodies[0]
    volume = document.volume(body.key)
    assert volume is not None
    return inverted(body.mesh, volume.points).count


@pytest.fixture
def cube(tmp_path: Path) -> Document:
    return opened(write_cube(tmp_path / "cube.su2"), BOX)


def test_a_guard_that_was_cancelled_is_made_for_the_next_drag(cube: Document) -> None:
    warden, runner = DragGuard(cube, "stop"), Later()
    cube.runner = runner
    assert warden.judge([POINT], FAR).state == "waiting"
    runner.cancel()
    assert warden.judge([POINT], FAR).state == "waiting"
    runner.catch_up()
    assert warden.judge([POINT], FAR).state == "ready"


def test_a_stopped_drag_inverts_nothing_and_a_little_more_does(cube: Document) -> None:
    warden = DragGuard(cube, "stop")
    verdict = warden.judge([POINT], FAR)
    assert verdict.state == "ready"
    assert verdict.beyond
    assert verdict.reason == "a cell inverts"
    limit = FAR * verdict.stop.amplitude
    assert dragged(cube, verdict.vector) == 0
    cube.undo()
    assert dragged(cube, 1.001 * limit) > 0


def test_the_guard_starts_where_earlier_drags_have_led(cube: Document) -> None:
    warden = DragGuard(cube, "stop")
    first = warden.judge([POINT], FAR).vector
    assert dragged(cube, 0.5 * first) == 0
    rest = warden.judge([POINT], FAR).vector
    np.testing.assert_allclose(rest, 0.5 * first, rtol=5e-3)


def test_warning_leaves_the_drag_alone_and_says_it(cube: Document) -> None:
    verdict = DragGuard(cube, "warn").judge([POINT], FAR)
    assert verdict.vector is FAR
    assert verdict.beyond


def test_a_short_drag_is_not_touched(cube: Document) -> None:
    short = 1e-3 * FAR
    verdict = DragGuard(cube, "stop").judge([POINT], short)
    assert verdict.vector is short
    assert not verdict.beyond


def test_free_drags_are_not_judged(cube: Document) -> None:
    verdict = DragGuard(cube, "free").judge([POINT], FAR)
    assert (verdict.state, verdict.beyond) == ("none", False)


def test_limits_of_a_solver_are_met_before_inversion(cube: Document) -> None:
    shear = np.array([0.0, 20.0, 0.0])
    warden = DragGuard(cube, "stop")
    inversion = warden.judge(LAYER, shear).stop.amplitude
    warden.set(limits="OpenFOAM")
    verdict = warden.judge(LAYER, shear)
    assert verdict.stop.amplitude < min(1.0, inversion)
    assert verdict.reason in ("non-orthogonality", "face skewness")


def test_unknown_choices_are_refused(cube: Document) -> None:
    with pytest.raises(InputError, match="stop, warn, free"):
        DragGuard(cube).set(mode="hold")


def test_frozen_points_are_nothing_to_guard(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "c.su2"), BOX)
    assert DragGuard(document).judge([], FAR).state == "none"


def test_no_guard_where_a_later_lattice_deforms_too(cube: Document) -> None:
    cube.do(CreateBox("Second", (0, 0, 0), (1, 1, 1), (4, 4, 4), (3, 3, 3)))
    first, second = (item.key for item in cube.model.lattices)
    assert dragged(cube, np.array([0.05, 0, 0])) == 0
    from ffdstudio.project.commands import Activate

    cube.do(Activate(first))
    assert DragGuard(cube).judge([POINT], FAR).state == "none"
    cube.do(Enable(second, False))
    assert DragGuard(cube).judge([POINT], FAR).state == "ready"


def test_a_plane_mesh_is_guarded_in_its_plane(tmp_path: Path) -> None:
    box = CreateBox("Box", (-0.1, -0.1), (1.1, 1.1), (4, 4), (3, 3))
    document = opened(write_square(tmp_path / "s.su2"), box)
    verdict = DragGuard(document, "stop").judge([(2, 2)], FAR)
    assert verdict.beyond
    assert verdict.vector[0] < 0


def test_a_drag_by_the_mouse_is_held_at_the_limit(cube: Document) -> None:
    tools, camera = Tools(cube), look()
    tools.guard_with(DragGuard(cube, "stop"))
    cube.select(LAYER)
    net = cube.model.lattices[0].current.control_points
    x, y = camera.project(net[POINT])[0]
    tools.handle(PointerEvent("press", camera, x, y, "left"))
    tools.handle(PointerEvent("move", camera, x - 800, y - 20))
    verdict = tools.feedback.verdict
    assert verdict is not None
    assert verdict.beyond
    tools.handle(PointerEvent("release", camera, x - 800, y - 20, "left"))
    body = cube.model.bodies[0]
    volume = cube.volume(body.key)
    assert volume is not None
    assert volume.moved > 0
    assert volume.inverted == 0


def test_a_guard_that_arrives_during_the_drag_holds_it(tmp_path: Path) -> None:
    later = Later()
    document = Document(later)
    document.open_mesh(write_cube(tmp_path / "cube.su2"))
    later.catch_up()
    document.do(BOX)
    later.catch_up()
    document.select(LAYER)
    tools, camera = Tools(document), look()
    tools.guard_with(DragGuard(document, "stop"))
    x, y = camera.project(document.model.lattices[0].current.control_points[POINT])[0]
    tools.handle(PointerEvent("press", camera, x, y, "left"))
    tools.handle(PointerEvent("move", camera, x - 800, y - 20))
    asked = document.model.lattices[0].current.control_points[POINT].copy()
    assert tools.feedback.verdict is not None
    assert tools.feedback.verdict.state == "waiting"
    later.catch_up()
    assert tools.feedback.verdict.state == "ready"
    held = document.model.lattices[0].current.control_points[POINT]
    start = document.model.lattices[0].rest.control_points[POINT]
    assert np.linalg.norm(held - start) < np.linalg.norm(asked - start)
    tools.cancel()
