"""FFD boxes that follow a mesh of several zones, or that need not be understood."""

import numpy as np
import pytest

from ffdstudio import InputError, Lattice, read_lattice, read_mesh, write_lattice
from ffdstudio.exchange import su2
from ffdstudio.exchange.morphed import write_morphed
from tests.exchange.test_su2_boxes import BOX, SQUARE

TWO_ZONES = (
    "NZONE= 2\nIZONE= 1\n" + SQUARE + BOX + "IZONE= 2\n" + SQUARE + BOX.replace("TAG= A", "TAG= B")
)


def test_boxes_that_nothing_moves_are_written_as_they_are_even_unreadable(tmp_path):
    (tmp_path / "m.su2").write_text(SQUARE + BOX.replace("BEZIER", "NURBS"))
    mesh = read_mesh(tmp_path / "m.su2")
    rest = Lattice.box([-0.5, -0.5], [1.5, 1.5], shape=(4, 4))
    write_morphed(mesh, tmp_path / "out.su2", mesh.points, [(rest, rest)])
    assert (tmp_path / "out.su2").read_bytes() == (tmp_path / "m.su2").read_bytes()


def test_a_box_without_blending_is_bezier_as_in_su2(tmp_path):
    (tmp_path / "m.su2").write_text(SQUARE + BOX.replace("FFD_BLENDING= BEZIER\n", ""))
    assert read_lattice(tmp_path / "m.su2")[0].degrees == (1, 1)


def test_the_boxes_of_every_zone_follow_the_mesh_or_are_stripped(tmp_path):
    (tmp_path / "m.su2").write_text(TWO_ZONES)
    mesh = read_mesh(tmp_path / "m.su2")
    rest = Lattice.box([-1, -1], [2, 2], shape=(2, 2))
    current = rest.moved(rest.control_points + [0.0, 0.25, 0.0])
    new = mesh.points + [0.0, 0.25, 0.0]
    write_morphed(mesh, tmp_path / "out.su2", new, [(rest, current)])
    zones = (tmp_path / "out.su2").read_bytes().split(b"IZONE= 2")
    for text, tag in zip(zones, ("A", "B"), strict=True):
        box = su2.read(b"NDIME= 2\n" + text[text.index(b"FFD_NBOX") :], "m", tag).rest
        assert np.array_equal(box.control_points, current.control_points)
    write_morphed(mesh, tmp_path / "out.su2", new, [(rest, current)], "strip")
    assert b"FFD" not in (tmp_path / "out.su2").read_bytes()
    assert np.array_equal(read_mesh(tmp_path / "out.su2").points, new)


def test_an_embedding_by_numbers_of_one_zone_is_refused_to_follow(tmp_path):
    cached = "SURFACE_POINTS= 1\nwall\t0\t0.5\t0.5\t0.5"
    (tmp_path / "m.su2").write_text(TWO_ZONES.replace("SURFACE_POINTS= 0", cached))
    mesh = read_mesh(tmp_path / "m.su2")
    rest = Lattice.box([-2, -2], [2, 2], shape=(3, 3))
    current = rest.moved(rest.control_points + [0.0, 0.25, 0.0])
    with pytest.raises(InputError, match="FFD box A embeds nodes of wall, which is no marker"):
        write_morphed(mesh, tmp_path / "out.su2", mesh.points, [(rest, current)])


def test_boxes_of_every_zone_are_read_and_none_is_put_into_one(tmp_path):
    path = tmp_path / "m.su2"
    path.write_text(TWO_ZONES.replace("2.0\t2.0", "2.0\t2.5"))
    assert su2.tags(path.read_bytes(), "m") == ["A", "B"]
    assert read_lattice(path, "B")[0].control_points[..., 1].max() == 2.5
    with pytest.raises(InputError, match="cannot be put into a mesh of several zones"):
        write_lattice(path, Lattice.box([0, 0], [1, 1], shape=(3, 3)))
