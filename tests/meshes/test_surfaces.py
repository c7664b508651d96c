"""Small things that other programs put into surface files and grids."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from tests.meshes.specimens import SPECIMENS


def test_comments_of_an_obj_may_stand_at_the_end_of_any_line(tmp_path):
    text = "v 0 0 0 # a\nv 1 0 0\nv 0 1 0\n#f 1 1 1\ng part#1\nf 1 2 3 # tri 4/5\nl 1 2 #\n"
    (tmp_path / "a.obj").write_text(text)
    mesh = read_mesh(tmp_path / "a.obj")
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2]]
    assert mesh.cells["line"].tolist() == [[0, 1]]
    assert list(mesh.markers) == ["part#1"]
    write_mesh(mesh, tmp_path / "b.obj", mesh.points + [0, 0, 2])
    assert (tmp_path / "b.obj").read_text() == text.replace(" 0 # a", " 2.0 # a").replace(
        "v 1 0 0", "v 1 0 2.0"
    ).replace("v 0 1 0", "v 0 1 2.0")


@pytest.mark.filterwarnings("ignore:.*single precision")
def test_a_few_bytes_behind_a_binary_stl_are_kept(tmp_path):
    SPECIMENS["binary.stl"](tmp_path / "a.stl")
    data = b"solid".ljust(80) + (tmp_path / "a.stl").read_bytes()[80:]
    (tmp_path / "b.stl").write_bytes(data + b"\0\n")
    mesh = read_mesh(tmp_path / "b.stl")
    assert mesh.counts == read_mesh(tmp_path / "a.stl").counts
    write_mesh(mesh, tmp_path / "c.stl", mesh.points + 1)
    assert (tmp_path / "c.stl").read_bytes().endswith(b"\0\n")
    assert len((tmp_path / "c.stl").read_bytes()) == len(data) + 2
    (tmp_path / "b.stl").write_bytes(data + bytes(50))
    with pytest.raises(InputError, match=r"b\.stl"):
        read_mesh(tmp_path / "b.stl")


def test_commas_between_the_numbers_of_a_grid_stay(tmp_path):
    (tmp_path / "a.xyz").write_text("1\n2, 2, 1\n0.,1.,0.,1.\n0.,0.,1.,1.\n0.,0.,0.,0.5\n")
    mesh = read_mesh(tmp_path / "a.xyz")
    assert mesh.points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]]
    write_mesh(mesh, tmp_path / "b.xyz", mesh.points + [0, 0, 2])
    assert (tmp_path / "b.xyz").read_text().endswith("\n2.0,2.0,2.0,2.5\n")


def test_repeated_numbers_of_a_grid_are_written_out_where_they_part(tmp_path):
    (tmp_path / "a.xyz").write_text("1\n2 2 1\n4*0.0\n4*1.0 4*2.0\n")
    mesh = read_mesh(tmp_path / "a.xyz")
    assert mesh.points.tolist() == [[0, 1, 2]] * 4
    points = mesh.points.copy()
    points[1, 0] = 0.5
    write_mesh(mesh, tmp_path / "b.xyz", points)
    assert (tmp_path / "b.xyz").read_text() == "1\n2 2 1\n0.0 0.5 0.0 0.0\n4*1.0 4*2.0\n"


def test_keywords_of_legacy_vtk_may_be_in_lower_case(tmp_path):
    text = "# vtk DataFile Version 3.0\nt\nascii\ndataset polydata\npoints 3 double\n"
    (tmp_path / "a.vtk").write_text(text + "0 0 0 1 0 0 0 1 0\npolygons 1 4\n3 0 1 2\n")
    mesh = read_mesh(tmp_path / "a.vtk")
    assert mesh.counts == {"triangle": 1}
    assert np.array_equal(mesh.points[1], [1, 0, 0])
