"""Symmetry planes, FFD boxes and folds in a window: builder, hover, status, panel, export."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("PySide6")

from PySide6.QtTest import QTest

from ffdstudio.engine import Lattice
from ffdstudio.exchange import write_lattice
from ffdstudio.gui.readouts import hover_text
from ffdstudio.project.commands import CreateBox
from ffdstudio.project.files.replaying import export, replay
from tests.project.scenes import write_cube

pytestmark = pytest.mark.display
ON, OFF = (0, 1, 2), (1, 1, 2)


@pytest.fixture
def half(user: Any, tmp_path: Path) -> Any:
    """Window with a cube that ends at a symmetry plane, in a lattice that begins there."""
    user.open(write_cube(tmp_path / "half.su2", low="SYMMETRY"))
    user.build()
    return user


def move(user: Any, vector: tuple[float, float, float], point: tuple[int, ...]) -> None:
    edit = user.window.document.edit([point])
    edit.translate(vector)
    edit.commit()
    user.idle()


def bend(user: Any) -> None:
    """Deform by a lattice that reaches over the plane."""
    box = CreateBox("Over", (-0.5,) * 3, (1.5,) * 3, (4, 4, 4), (3, 3, 3))
    user.window.document.do(box)
    move(user, (0.3, 0.0, 0.0), (1, 1, 1))


def test_the_form_begins_at_the_plane_and_says_so(user: Any, tmp_path: Path) -> None:
    user.open(write_cube(tmp_path / "half.su2", low="SYMMETRY"))
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    assert builder.low[0].value == 0
    assert builder.high[0].value > 1
    assert "The face i min lies on SYMMETRY" in builder.seat.text()
    builder.margin.setValue(20)
    assert builder.low[0].value == 0
    builder.around.setCurrentIndex(builder.around.count() - 1)
    builder.around.activated.emit(builder.around.count() - 1)  # typed bounds: still on the plane
    assert "The face i min lies on SYMMETRY" in builder.seat.text()


def test_a_typed_bound_keeps_the_seat_and_what_is_laid_around(user: Any, tmp_path: Path) -> None:
    user.open(write_cube(tmp_path / "half.su2", low="SYMMETRY"))
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    around, low = builder.around.currentText(), builder.low[1].value
    field = builder.high[2]
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "1.75")
    assert builder.around.currentText() == around
    assert "The face i min lies on SYMMETRY" in builder.seat.text()
    assert builder.draft().open_faces == ((0, 0),)
    builder.counts[1].setValue(5)  # anew, but for what was typed
    assert builder.high[2].value == 1.75
    builder.margins[1].setValue(50)
    assert not builder.auto.isChecked()
    assert (builder.high[2].value, builder.low[1].value) == (1.75, -0.5)
    assert low != -0.5
    field = builder.low[0]
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.25")  # off the plane: the face is not seated any more
    assert builder.seat.text() == ""
    assert builder.draft().open_faces == ()


def test_layers_are_frozen_on_all_faces_but_the_one_at_the_plane(user: Any, tmp_path: Path) -> None:
    user.open(write_cube(tmp_path / "half.su2", low="SYMMETRY"))
    user.build(frozen=1)
    item = user.lattice
    assert (item.frozen, item.open_faces) == (1, ((0, 0),))
    assert not item.frozen_mask[0, 1:-1, 1:-1].any()
    assert item.frozen_mask[-1].all()
    user.trigger("lattice.refit")
    assert user.window.lattice.builder.draft().open_faces == ((0, 0),)


def test_a_point_on_the_plane_slides_under_the_mouse_and_says_so(half: Any) -> None:
    assert half.lattice.rest.domain[0, 0] == 0
    lines = hover_text(half.lattice, ON, ("SYMMETRY",))
    assert lines[-1] == "slides in SYMMETRY"
    half.window.studio.state.hover(ON)
    half.painted()
    half.click(half.at(ON))
    start = half.at(ON)
    from PySide6.QtCore import QPoint

    half.drag(start, start + QPoint(60, -45))
    step = half.lattice.current.control_points[ON] - half.lattice.rest.control_points[ON]
    assert step[0] == 0
    assert abs(step[1:]).max() > 0.01
    assert half.window.document.volume("body1").broken == ()


def test_a_plane_that_bends_is_shown_and_asked_before_export(half: Any, tmp_path: Path) -> None:
    half.trigger("quality.show")
    bend(half)

    assert "SYMMETRY is no longer planar" in half.window.status.cells.text()
    note = half.window.quality.panel.planes
    assert "SYMMETRY is no longer planar: 16 of 16 nodes leave it" in note.text()
    half.script.answers = ["cancel"]
    half.trigger("file.export_mesh")
    assert "no longer planar" in half.script.asked[-1].detail
    half.script.answers, half.script.targets = ["export"], [tmp_path / "out.su2"]
    half.trigger("file.export_mesh")
    half.idle()
    assert (tmp_path / "out.su2").exists()


def test_what_becomes_of_ffd_boxes_is_asked_and_replayed(user: Any, tmp_path: Path) -> None:
    mesh = write_cube(tmp_path / "boxed.su2")
    write_lattice(mesh, Lattice.box([-0.2] * 3, [1.2] * 3, (3, 3, 3)), tag="BOX")
    user.open(mesh)
    user.build()
    move(user, (0.1, 0.05, 0.0), OFF)
    user.script.answers, user.script.targets = ["strip"], [tmp_path / "out.su2"]
    user.trigger("file.export_mesh")
    user.idle()
    [question] = user.script.asked
    assert [key for key, _ in question.answers] == ["update", "strip", "keep", "cancel"]
    data = (tmp_path / "out.su2").read_bytes()
    assert b"FFD_" not in data
    document = user.window.document
    assert document.history.labels[-1] == "Strip FFD boxes of boxed"
    document.journal.save(tmp_path / "a.journal")
    export(replay(tmp_path / "a.journal"), tmp_path / "again")
    assert (tmp_path / "again" / "boxed.su2").read_bytes() == data
    user.script.answers = ["cancel"]
    user.trigger("file.export_mesh")
    assert user.script.asked[-1].answers[0][0] == "strip"  # the choice made last comes first


def test_a_lattice_that_folds_is_told_with_the_place(half: Any) -> None:
    half.trigger("quality.show")
    note = half.window.quality.panel.folds
    assert note.isHidden()
    move(half, (0.05, 0.02, 0.0), OFF)
    name = half.lattice.name
    assert note.text() == f"{name} is locally invertible."
    assert "does not mean that the cells are valid" in note.toolTip()
    move(half, (9.0, 0.0, 0.0), OFF)
    assert note.text().startswith(f"{name} folds in 1 knot span, at i 0 to 1.05")
    half.window.document.undo()
    half.idle()
    assert note.text() == f"{name} is locally invertible."
