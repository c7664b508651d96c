"""The document: one truth, undo to the same bytes, signals as promised, displayed points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ffdstudio.engine import embed
from ffdstudio.errors import InputError
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.running import no_progress
from tests.project.scenes import BOX, opened, write_cube, write_square


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    return write_cube(tmp_path / "cube.su2")


def heard(document: Document) -> list[str]:
    """Names of signals in the order they come from now on."""
    log: list[str] = []
    for name in ("moving", "moved", "structure_changed", "selection_changed", "history_changed"):
        getattr(document, name).connect(lambda name=name: log.append(name))
    return log


def test_displayed_points_are_what_the_engine_says(cube: Path) -> None:
    document = opened(cube, BOX)
    document.do(
        c.MovePoints("lattice2", ((1, 1, 1), (2, 1, 1)), ((0.5, 0.1, 0.2), (0.9, 0.3, 0.3)))
    )
    document.do(c.SetWeights("lattice2", ((2, 2, 2),), (3.0,)))
    body, item = document.model.bodies[0], document.model.lattices[0]
    nodes = document.surface("body1").nodes
    expected = embed(item.rest, body.mesh.points).deform(item.current)
    np.testing.assert_allclose(document.points("body1"), expected[nodes], rtol=0, atol=1e-15)
    volume = document.volume("body1")
    assert volume is not None
    assert np.array_equal(volume.points, expected)
    assert volume.inverted == 0


def test_inverted_cells_are_counted_on_release(cube: Path) -> None:
    document = opened(cube, BOX)
    drag = document.edit([(1, 1, 1)])
    drag.translate([3, 3, 3])
    drag.commit()
    assert document.volume("body1").inverted > 0  # type: ignore[union-attr, operator]
    document.undo()
    assert document.volume("body1").inverted == 0  # type: ignore[union-attr]


def test_a_drag_is_one_entry_and_abort_leaves_no_trace(cube: Path) -> None:
    document = opened(cube, BOX)
    model, points = document.model, document.points("body1").tobytes()
    drag = document.edit([(1, 1, 1), (2, 2, 2)])
    for step in range(10):
        drag.translate([0, 0, 0.01 * step])
        document.refresh()
    assert document.points("body1").tobytes() != points
    drag.abort()
    assert document.model is model
    assert document.points("body1").tobytes() == points
    drag = document.edit([(1, 1, 1), (2, 2, 2)])
    drag.translate([0, 0, 0.5])
    drag.translate([0, 0, 0.1])
    drag.commit()
    assert document.history.labels[2:] == ["Move 2 points"]
    moved = document.model.lattices[0].current.control_points - BOX.lattice.control_points
    assert np.count_nonzero(moved) == 2


def test_a_drag_that_changes_nothing_is_no_entry(cube: Path) -> None:
    document = opened(cube, BOX)
    drag = document.edit([(1, 1, 1)])
    drag.translate([1, 0, 0])
    drag.translate([0, 0, 0])
    drag.commit()
    assert len(document.history.entries) == 2


def test_fifty_moves_give_one_moving_until_refreshed(cube: Path) -> None:
    document = opened(cube, BOX)
    log = heard(document)
    drag = document.edit([(1, 1, 1)])
    for _ in range(50):
        drag.translate([0.1, 0, 0])
    assert log == ["moving"]
    document.refresh()
    drag.translate([0.2, 0, 0])
    drag.commit()
    assert log == ["moving", "moving", "moved", "history_changed"]


def test_preview_and_result_of_a_drag_agree(cube: Path) -> None:
    document = opened(cube, BOX)
    document.do(c.SetWeights("lattice2", ((1, 2, 1),), (2.5,)))
    drag = document.edit([(1, 1, 1), (1, 2, 1)])
    drag.translate([0.1, 0.2, -0.1])
    document.refresh()
    shown = document.points("body1").copy()
    drag.commit()
    np.testing.assert_allclose(shown, document.points("body1"), rtol=0, atol=1e-14)


def test_undo_all_the_way_and_back_gives_the_same_bytes(cube: Path) -> None:
    document = opened(cube, BOX)
    states = [(document.model, document.points("body1").tobytes())]
    for command in (
        c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)),
        c.InsertKnots("lattice2", 0, (0.45,)),
        c.ElevateDegree("lattice2", 2),
        c.SetWeights("lattice2", ((1, 1, 1),), (0.3,)),
        c.SaveShape("lattice2", "a"),
        c.ResetPoints("lattice2"),
        c.BlendShapes("lattice2", (("a", 0.5),)),
        c.FreezeLayers("lattice2", 1),
        c.Show(("body1",), False),
        c.Rename("body1", "wing"),
    ):
        document.do(command)
        states.append((document.model, document.points("body1").tobytes()))
    for position in (0, 3, 10, 5, 1):
        document.jump(2 + position)
        assert document.model is states[position][0]
    document.jump(2)
    assert document.points("body1").tobytes() == states[0][1]
    document.redo()
    assert document.points("body1").tobytes() == states[1][1]


def test_a_new_command_forgets_what_was_undone(cube: Path) -> None:
    document = opened(cube, BOX)
    document.do(c.Rename("body1", "a"))
    document.undo()
    document.do(c.Rename("body1", "b"))
    assert document.history.labels[2:] == ["Rename cube to b"]
    assert document.history.redo_label is None


def test_refinement_keeps_displayed_points_and_the_rest_of_the_net(cube: Path) -> None:
    document = opened(cube, BOX)
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    document.do(c.SetWeights("lattice2", ((2, 1, 1),), (4.0,)))
    before = document.points("body1")
    document.do(c.InsertKnots("lattice2", 1, (0.3, 0.6)))
    document.do(c.ElevateDegree("lattice2", 0))
    assert document.model.lattices[0].rest.shape == (5, 6, 4)
    np.testing.assert_allclose(document.points("body1"), before, rtol=0, atol=1e-14)
    document.do(c.RemoveKnots("lattice2", 1, (0.6,)))
    np.testing.assert_allclose(document.points("body1"), before, rtol=0, atol=1e-13)


def test_lattices_compose_in_order(cube: Path) -> None:
    second = c.CreateBox("Second", (0.4, -0.5, -0.5), (1.6, 1.5, 1.5), (3, 3, 3), (2, 2, 2))
    document = opened(cube, BOX, second)
    document.do(c.MovePoints("lattice3", ((1, 1, 1),), ((1.3, 0.9, 0.5),)))
    document.do(c.MovePoints("lattice2", ((2, 1, 1),), ((1.2, 0.2, 0.3),)))
    first, then = document.model.lattices
    nodes = document.model.bodies[0].mesh.points
    middle = embed(first.rest, nodes).deform(first.current)
    expected = embed(then.rest, middle).deform(then.current)
    surface = document.surface("body1").nodes
    np.testing.assert_allclose(document.points("body1"), expected[surface], rtol=0, atol=1e-15)
    untouched = ~embed(then.rest, middle).inside
    assert np.array_equal(expected[untouched], middle[untouched])
    document.do(c.Enable("lattice2", False))
    alone = embed(then.rest, nodes).deform(then.current)
    np.testing.assert_allclose(document.points("body1"), alone[surface], rtol=0, atol=1e-15)


def test_while_an_earlier_lattice_is_dragged_later_ones_carry_on(cube: Path) -> None:
    second = c.CreateBox("Second", (0.4, -0.5, -0.5), (1.6, 1.5, 1.5), (3, 3, 3), (2, 2, 2))
    document = opened(cube, BOX, second)
    document.do(c.MovePoints("lattice3", ((1, 1, 1),), ((1.3, 0.9, 0.5),)))
    document.do(c.Activate("lattice2"))
    start = document.points("body1")
    first = document.model.lattices[0]
    drag = document.edit([(1, 1, 1)])
    drag.translate([0.01, 0.02, 0.03])
    document.refresh()
    nodes = document.model.bodies[0].mesh.points[document.surface("body1").nodes]
    moved = embed(first.rest, nodes).deform(drag.current) - nodes
    np.testing.assert_allclose(document.points("body1"), start + moved, rtol=0, atol=1e-14)


def test_points_outside_and_undeformed_lattices_keep_every_bit(tmp_path: Path) -> None:
    path = write_cube(tmp_path / "cube.su2")
    half = c.CreateBox("Half", (0.0, 0.0, 0.0), (0.5, 1.0, 1.0), (3, 3, 3), (2, 2, 2))
    document = opened(path, half)
    nodes = document.model.bodies[0].mesh.points
    shown = nodes[document.surface("body1").nodes]
    assert document.points("body1").tobytes() == shown.tobytes()
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.3, 0.6, 0.4),)))
    outside = shown[:, 0] > 0.5
    assert document.points("body1")[outside].tobytes() == shown[outside].tobytes()
    document.do(c.ResetPoints("lattice2"))
    assert document.points("body1").tobytes() == shown.tobytes()


def test_frozen_points_do_not_move(cube: Path) -> None:
    document = opened(cube, BOX)
    document.do(c.MovePoints("lattice2", ((0, 0, 0),), ((0.5, 0.1, 0.2),)))
    document.do(c.FreezeLayers("lattice2", 1))
    assert not document.model.lattices[0].deformed
    with pytest.raises(InputError, match="frozen"):
        document.do(c.MovePoints("lattice2", ((0, 0, 0),), ((0.5, 0.1, 0.2),)))
    with pytest.raises(InputError, match="can move"):
        document.edit([(0, 1, 1)])
    drag = document.edit([(0, 1, 1), (1, 1, 1)])
    assert drag.points == ((1, 1, 1),)
    with pytest.raises(InputError, match="leave nothing"):
        document.do(c.FreezeLayers("lattice2", 2))


def test_a_command_that_fails_changes_nothing(cube: Path) -> None:
    document = opened(cube, BOX)
    model, lines = document.model, len(document.journal.steps)
    for command in (
        c.Rename("body1", "Box"),
        c.Rename("body1", "  "),
        c.Remove("body7"),
        c.Activate("body1"),
        c.SetWeights("lattice2", ((1, 1, 1),), (-1.0,)),
        c.SetWeights("lattice2", ((1, 1, 9),), (1.0,)),
        c.MovePoints("lattice2", ((1, 1, 1),), ((float("nan"), 0.0, 0.0),)),
        c.MovePoints("lattice2", ((1, 1, 1),), ()),
        c.InsertKnots("lattice2", 0, (7.0,)),
        c.RemoveKnots("lattice2", 0, (0.5,)),
        c.BlendShapes("lattice2", (("nothing", 1.0),)),
        c.ShowMarkers("body1", ("nothing",)),
    ):
        with pytest.raises(InputError):
            document.do(command)
    assert document.model is model
    assert len(document.journal.steps) == lines


def test_structure_changed_is_not_for_moved_points(cube: Path) -> None:
    document = opened(cube, BOX)
    log = heard(document)
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    assert "structure_changed" not in log
    document.do(c.Colour("body1", "#ff0000"))
    assert "structure_changed" in log


def test_selection_goes_when_the_net_is_another(cube: Path) -> None:
    document = opened(cube, BOX)
    document.select([(1, 1, 1)])
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    assert document.selection == {(1, 1, 1)}
    document.do(c.InsertKnots("lattice2", 0, (0.5,)))
    assert not document.selection
    with pytest.raises(InputError):
        document.select([(9, 0, 0)])


def test_undo_during_a_drag_takes_back_the_drag(cube: Path) -> None:
    document = opened(cube, BOX)
    drag = document.edit([(1, 1, 1)])
    drag.translate([1, 0, 0])
    document.undo()
    assert document.editing is None
    assert len(document.history.entries) == 2
    drag.translate([2, 0, 0])  # a late mouse move finds the edit ended
    assert not document.model.lattices[0].deformed


def test_a_command_during_a_drag_commits_it_first(cube: Path) -> None:
    document = opened(cube, BOX)
    document.edit([(1, 1, 1)]).translate([1, 0, 0])
    document.do(c.Rename("body1", "wing"))
    assert document.history.labels[2:] == ["Move point (1, 1, 1)", "Rename cube to wing"]


def test_keys_are_never_given_twice(cube: Path) -> None:
    document = opened(cube, BOX)
    document.do(c.Remove("lattice2"))
    document.do(BOX)
    assert [item.key for item in document.model.lattices] == ["lattice3"]


def test_a_box_can_be_fitted_anew_until_it_is_deformed(cube: Path) -> None:
    document = opened(cube, BOX)
    wider = c.CreateBox("Box", (-1.0, -1.0, -1.0), (2.0, 2.0, 2.0), (3, 3, 3), (2, 2, 2))
    document.do(c.Refit("lattice2", wider))
    assert document.model.lattices[0].rest == wider.lattice
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    with pytest.raises(InputError, match="reset"):
        document.do(c.Refit("lattice2", wider))


def test_saved_shapes_come_back_by_factor_and_in_sums(cube: Path) -> None:
    document = opened(cube, BOX)
    rest = BOX.lattice
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    document.do(c.SaveShape("lattice2", "a"))
    document.do(c.ResetPoints("lattice2"))
    document.do(c.SetWeights("lattice2", ((2, 2, 2),), (3.0,)))
    document.do(c.SaveShape("lattice2", "b"))
    document.do(c.BlendShapes("lattice2", (("a", 0.5), ("b", 2.0))))
    current = document.model.lattices[0].current
    half = (np.array([0.5, 0.1, 0.2]) - rest.control_points[1, 1, 1]) / 2
    np.testing.assert_allclose(current.control_points[1, 1, 1] - rest.control_points[1, 1, 1], half)
    assert current.weights[2, 2, 2] == 5
    document.do(c.BlendShapes("lattice2", (("a", 1.0),)))
    assert document.model.lattices[0].current.control_points[1, 1, 1].tolist() == [0.5, 0.1, 0.2]


def test_a_plane_mesh_is_drawn_with_its_boundary_and_counts_inverted_cells(tmp_path: Path) -> None:
    path = write_square(tmp_path / "square.su2")
    flat = c.CreateBox("Box", (-0.1, -0.1, 0.0), (1.1, 1.1, 0.0), (4, 4), (3, 3))
    document = opened(path, flat)
    surface = document.surface("body1")
    assert surface.lines.shape == (4, 2)
    assert not surface.has_volume
    document.do(c.MovePoints("lattice2", ((1, 1),), ((3.0, 3.0, 0.0),)))
    assert document.volume("body1").inverted > 0  # type: ignore[union-attr, operator]


class Later:
    """A runner whose work is done when the test says so."""

    def __init__(self) -> None:
        self.waiting: list = []

    def start(self, label, work, done, failed=None, key="", cancelled=None, line=""):  # type: ignore[no-untyped-def]
        if key:
            self.waiting = [job for job in self.waiting if job[2] != key]
        self.waiting.append((work, done, key, cancelled))

    def run(self) -> None:
        while self.waiting:
            work, done, _, _ = self.waiting.pop(0)
            done(work(no_progress))

    def cancel(self) -> None:
        """As the user does: whoever wants to know is told."""
        waiting, self.waiting = self.waiting, []
        for _, _, _, cancelled in waiting:
            if cancelled is not None:
                cancelled()


def test_embeddings_that_arrive_during_a_drag_are_taken(cube: Path) -> None:
    runner = Later()
    document = Document(runner)
    document.open_mesh(cube)
    runner.run()
    document.do(BOX)
    assert document.inside("body1") is None
    drag = document.edit([(1, 1, 1)])
    drag.translate([0.3, 0, 0])
    document.refresh()
    rest = document.points("body1").copy()
    runner.run()
    document.refresh()
    assert not np.array_equal(document.points("body1"), rest)
    drag.commit()
    assert document.volume("body1") is None
    runner.run()
    assert document.volume("body1") is not None


def test_a_check_that_was_cancelled_is_due_again(cube: Path) -> None:
    runner, told = Later(), []
    document = Document(runner)
    document.open_mesh(cube)
    runner.run()
    document.do(BOX)
    document.volume_changed.connect(told.append)
    assert document.checking("body1")
    runner.cancel()
    assert told == ["body1"]
    assert not document.checking("body1")
    assert document.volume("body1") is None
    document.check()
    assert document.checking("body1")
    runner.run()
    assert document.volume("body1") is not None
    document.check()
    assert runner.waiting == []


def test_work_for_a_body_that_is_gone_is_dropped(cube: Path) -> None:
    runner = Later()
    document = Document(runner)
    document.open_mesh(cube)
    runner.run()
    document.do(BOX)
    document.do(c.Remove("body1"))
    runner.run()
    assert not document.model.bodies
