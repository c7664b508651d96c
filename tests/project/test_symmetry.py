"""Control points on a symmetry plane slide in it, whatever edits them, and a replay agrees."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.cli.main import main
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.interaction.numeric_edits import set_displacement, set_position, transform
from ffdstudio.project.interaction.spread import Soft
from ffdstudio.project.interaction.tools import Options
from ffdstudio.project.interaction.transforms import rotation
from tests.project.scenes import opened, write_cube
from tests.project.test_tools import Hand

SEATED = c.CreateBox("Box", (0.0, -0.1, -0.1), (1.1, 1.1, 1.1), (4, 4, 4), (3, 3, 3))
ON, OFF = (0, 1, 2), (1, 1, 2)


@pytest.fixture
def half(tmp_path: Path) -> Document:
    """Cube that ends at the marker SYMMETRY, x = 0, where its lattice begins."""
    return opened(write_cube(tmp_path / "half.su2", low="SYMMETRY"), SEATED)


def step(document: Document, point: tuple[int, ...]) -> np.ndarray:
    item = document.model.lattices[0]
    return item.current.control_points[point] - item.rest.control_points[point]


def off_plane(document: Document) -> float:
    volume, mesh = document.volume("body1"), document.model.bodies[0].mesh
    assert volume is not None
    return float(np.abs(volume.points[mesh.marker_nodes("SYMMETRY"), 0]).max())


def test_a_drag_loses_its_part_across_the_plane(half: Document) -> None:
    half.select([ON])
    hand = Hand(half)
    hand.drag(ON, (60, -40))
    on = step(half, ON)
    assert on[0] == 0
    assert np.abs(on[1:]).min() > 0.01
    assert half.model.lattices[0].current.control_points[ON][0] == 0
    assert off_plane(half) == 0
    volume = half.volume("body1")
    assert volume is not None
    assert volume.moved > 0
    assert volume.broken == ()


def test_points_on_and_off_the_plane_are_dragged_together(half: Document) -> None:
    edit = half.edit([ON, OFF])
    edit.translate([0.05, 0.02, 0.01])
    half.refresh()
    edit.commit()
    assert step(half, ON) == pytest.approx([0, 0.02, 0.01], abs=1e-15)
    assert step(half, OFF) == pytest.approx([0.05, 0.02, 0.01], abs=1e-15)
    assert off_plane(half) == 0


def test_what_is_displayed_during_a_drag_is_what_is_committed(half: Document) -> None:
    edit = half.edit([ON])
    edit.translate([0.05, 0.1, 0.02])
    half.refresh()
    shown = half.points("body1").copy()
    edit.commit()
    assert half.points("body1") == pytest.approx(shown, abs=1e-14)


def test_typed_values_turns_and_soft_drags_slide_too(half: Document) -> None:
    half.select([ON])
    set_displacement(half, (0.3, 0.1, None))
    assert step(half, ON) == pytest.approx([0, 0.1, 0], abs=1e-15)
    set_position(half, (0.3, None, 0.4))
    assert half.model.lattices[0].current.control_points[ON][[0, 2]].tolist() == [0, 0.4]
    half.select([ON, OFF, (0, 2, 1)])
    transform(half, rotation([0, 1, 0], 20, [0.5, 0.5, 0.5]))
    assert (half.model.lattices[0].current.control_points[0, :, :, 0] == 0).all()
    hand = Hand(half)
    hand.tools.options = Options(soft=Soft(0.9))
    hand.drag(OFF, (80, 10))
    assert (half.model.lattices[0].current.control_points[0, :, :, 0] == 0).all()
    hand.key("Right")
    assert (half.model.lattices[0].current.control_points[0, :, :, 0] == 0).all()
    assert off_plane(half) == 0


def test_a_command_that_says_otherwise_slides_and_a_replay_gives_the_same_bytes(
    half: Document, tmp_path: Path
) -> None:
    half.do(c.MovePoints("lattice2", (ON, OFF), ((0.3, 0.2, 0.7), (0.45, 0.3, 0.7))))
    assert half.model.lattices[0].current.control_points[ON].tolist() == [0, 0.2, 0.7]
    half.export_mesh("body1", tmp_path / "out.su2")
    half.journal.save(tmp_path / "a.journal")
    assert main(["replay", str(tmp_path / "a.journal"), "-o", str(tmp_path / "again")]) == 0
    data = (tmp_path / "out.su2").read_bytes()
    assert (tmp_path / "again" / "half.su2").read_bytes() == data


def test_a_lattice_over_the_plane_bends_it_and_the_volume_tells(tmp_path: Path) -> None:
    box = c.CreateBox("Box", (-0.1,) * 3, (1.1,) * 3, (4, 4, 4), (3, 3, 3))
    document = opened(write_cube(tmp_path / "half.su2", low="SYMMETRY"), box)
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.2, 0.4, 0.3),)))
    volume = document.volume("body1")
    assert volume is not None
    [sentence] = volume.broken
    assert sentence.startswith("SYMMETRY is no longer planar: 16 of 16 nodes leave it")


def test_without_a_plane_nothing_is_held(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"), SEATED)
    edit = document.edit([ON])
    edit.translate([0.05, 0.1, 0.02])
    edit.commit()
    assert step(document, ON) == pytest.approx([0.05, 0.1, 0.02], abs=1e-15)


def test_nothing_is_frozen_on_the_face_at_the_plane_whatever_comes_of_the_lattice(
    tmp_path: Path,
) -> None:
    box = replace(SEATED, frozen=1, open_faces=((0, 0),))
    document = opened(write_cube(tmp_path / "half.su2", low="SYMMETRY"), box)
    edit = document.edit([ON, (0, 2, 2), (1, 0, 1), (3, 1, 1)])
    assert edit.points == (ON, (0, 2, 2))
    edit.translate([0.1, 0.05, 0.02])
    edit.commit()
    document.do(c.InsertKnots("lattice2", 1, (0.5,)))
    document.do(c.FreezeLayers("lattice2", 0))
    document.do(c.FreezeLayers("lattice2", 1))
    assert step(document, ON)[1] > 0
    document.save(tmp_path / "p.ffdproj")
    document.export_lattice("lattice2", tmp_path / "l.lattice.json")
    again = Document()
    again.open(tmp_path / "p.ffdproj")
    again.import_lattice(tmp_path / "l.lattice.json")
    assert [item.open_faces for item in again.model.lattices] == [((0, 0),)] * 2
    mask = again.model.lattices[0].frozen_mask
    assert np.array_equal(mask, document.model.lattices[0].frozen_mask)
    assert not mask[0, 1:-1, 1:-1].any()
    again.do(c.ResetPoints("lattice3"))
    again.do(c.Refit("lattice3", SEATED))
    assert again.model.lattices[1].open_faces == ()
