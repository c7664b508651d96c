"""`ffdstudio info`, `lattice` and `convert`."""

from pathlib import Path

import numpy as np
import pytest

from ffdstudio import Lattice, Project, read_lattice, read_mesh, write_lattice
from ffdstudio.exchange import read_lattice_file
from ffdstudio.samples import sample

# ---- info -----------------------------------------------------------------------------------


def test_info_of_a_mesh(ffdstudio, square):
    result = ffdstudio.json("info", square)
    assert result == {
        "format": "su2",
        "dimension": 2,
        "nodes": 81,
        "cells": {"triangle": 128},
        "unchecked": {},
        "markers": {"bottom": 8, "top": 8},
        "bounds": [[0, 0, 0], [1, 1, 0]],
        "lattices": [],
    }
    assert ffdstudio("info", square) == 0
    assert "triangle 128" in ffdstudio.out


def test_info_tells_a_broken_box_from_the_mesh_and_the_other_boxes(ffdstudio, square):
    box = Lattice.box([0, 0], [1, 1], shape=(5, 4))
    for tag in ("FIRST", "WRONG", "LAST"):
        write_lattice(square, box, tag=tag)
    first, tag, rest = square.read_text().partition("FFD_TAG= WRONG")
    square.write_text(first + tag + rest.replace("BSPLINE_UNIFORM", "BSPLINE", 1))
    result = ffdstudio.json("info", square)
    assert ffdstudio.code == 0
    assert result["nodes"] == 81
    assert [lattice["tag"] for lattice in result["lattices"]] == ["FIRST", "WRONG", "LAST"]
    assert [lattice.get("shape") for lattice in result["lattices"]] == [[5, 4], None, [5, 4]]
    assert "FFD_BLENDING= 'BSPLINE' is not known" in result["lattices"][1]["broken"]
    assert ffdstudio("info", square) == 0
    assert "tag WRONG, broken " in ffdstudio.out


def test_info_reads_a_mesh_with_many_boxes_no_oftener_than_with_one(ffdstudio, square, monkeypatch):
    reads = []
    plain = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: reads.append(path) or plain(path))
    counts = []
    for tag in ("A", "B", "C"):
        write_lattice(square, Lattice.box([0, 0], [1, 1], shape=(5, 4)), tag=tag)
        reads.clear()
        assert ffdstudio("info", square) == 0
        counts.append(len(reads))
    assert counts[0] == counts[-1]


def test_info_of_real_meshes(ffdstudio, shared):
    result = ffdstudio.json("info", shared / "meshes" / "su2" / "mesh_brick_prism_ffd.su2")
    assert (result["nodes"], result["cells"]) == (16800, {"wedge": 29640})
    assert result["lattices"][0]["tag"] == "MAIN_BOX"
    assert result["lattices"][0]["shape"] == [5, 5, 2]
    result = ffdstudio.json("info", shared / "meshes" / "wing" / "oneram6_tets.su2")
    assert result["dimension"] == 3


def test_info_of_a_lattice_and_of_a_project(ffdstudio, square, tmp_path):
    path = tmp_path / "a.lattice.json"
    write_lattice(path, Lattice.box([0, 0], [1, 2], shape=(4, 3)), frozen=1, units="m")
    result = ffdstudio.json("info", path)
    assert (result["shape"], result["degrees"], result["frozen"]) == ([4, 3], [3, 2], 1)
    assert result["bounds"] == [[0, 0, 0], [1, 2, 0]]
    project = Project()
    project.add_mesh(square)
    project.save(tmp_path / "p.ffdproj")
    square.unlink()
    result = ffdstudio.json("info", tmp_path / "p.ffdproj")
    assert list(result["bodies"]) == ["square"]
    assert "missing" in result["problems"][0]


# ---- lattice --------------------------------------------------------------------------------


def made(ffdstudio, mesh, folder, *words):
    path = folder / "l.lattice.json"
    assert ffdstudio("lattice", mesh, *words, "-o", path) == 0
    return read_lattice(path)[0]


def corners(lattice):
    flat = lattice.control_points.reshape(-1, 3)
    return flat.min(axis=0), flat.max(axis=0)


def test_a_lattice_around_everything(ffdstudio, cube, tmp_path):
    words = ["--shape", 5, 4, 3, "--degree", 3, 2, 1, "--margin", 0.1]
    lattice = made(ffdstudio, cube, tmp_path, *words)
    assert (lattice.shape, lattice.degrees) == ((5, 4, 3), (3, 2, 1))
    low, high = corners(lattice)
    assert np.allclose([low, high], [[-0.1] * 3, [1.1] * 3], rtol=0, atol=1e-15)


def test_a_margin_may_be_given_for_each_direction(ffdstudio, cube, tmp_path):
    words = ["--shape", 3, 3, 3, "--margin", 0.1, 0.5, 2]
    low, high = corners(made(ffdstudio, cube, tmp_path, *words))
    assert np.allclose([low, high], [[-0.1, -0.5, -2], [1.1, 1.5, 3]], rtol=0, atol=1e-15)
    path = tmp_path / "x.lattice.json"
    assert ffdstudio("lattice", cube, "--shape", 3, 3, 3, "--margin", 1, 2, "-o", path) == 2
    assert "3 directions need 1 or 3 margins" in ffdstudio.err


def test_little_room_is_told(ffdstudio, tmp_path):
    words = ["lattice", sample("naca0012.su2"), "--marker", "airfoil"]
    words += ["-o", tmp_path / "x.lattice.json"]
    assert ffdstudio(*words, "--margin", 0.02) == 0
    assert "only before a cell inverts: a larger margin" in ffdstudio.out
    assert ffdstudio(*words) == 0
    assert "The skin can move by about 0.089 before a cell inverts." in ffdstudio.out


def test_the_reach_is_told_and_the_walls_in_a_far_field_are_hinted_at(ffdstudio, tmp_path):
    path = tmp_path / "l.lattice.json"
    result = ffdstudio.json("lattice", sample("naca0012.su2"), "--marker", "airfoil", "-o", path)
    assert result["reach"] >= 0.08
    assert len(result["margin"]) == 2
    assert ffdstudio("lattice", sample("naca0012.su2"), "-o", path) == 0
    assert "--marker airfoil lays the lattice around that alone" in ffdstudio.out
    skin = sample("wing_skin.vtu")  # nothing of a surface can invert
    assert ffdstudio.json("lattice", skin, "-o", path)["reach"] is None


def test_a_lattice_around_a_marker(ffdstudio, square, tmp_path):
    words = ["--shape", 4, 3, "--marker", "top", "--margin", 0.05]
    low, high = corners(made(ffdstudio, square, tmp_path, *words))
    assert low[1] < 1 < high[1]
    assert (low[0], high[0]) == (-0.05, 1.05)
    assert ffdstudio("lattice", square, "--marker", "hull", "-o", tmp_path / "x.lattice.json") == 2
    assert "no marker hull in this mesh; it has: bottom, top" in ffdstudio.err


@pytest.mark.parametrize(("mesh", "d"), [("square", 2), ("cube", 3)])
def test_the_default_has_the_dimension_of_the_mesh(ffdstudio, request, tmp_path, mesh, d):
    lattice = made(ffdstudio, request.getfixturevalue(mesh), tmp_path)
    assert lattice.shape == (8, 6, 4)[:d]
    assert lattice.degrees == (3, 3, 3)[:d]


def test_three_directions_around_a_plane_mesh_make_a_slab(ffdstudio, square, tmp_path):
    lattice = made(ffdstudio, square, tmp_path, "--shape", 4, 4, 2, "--margin", 0)
    low, high = corners(lattice)
    assert (low[2], high[2]) == (-0.5, 0.5)
    out = tmp_path / "out.su2"
    words = ["--move", "1,1,0=0.01,0,0", "--move", "1,1,1=0.01,0,0"]
    assert ffdstudio("morph", square, tmp_path / "l.lattice.json", "-o", out, *words) == 0


def test_directions_may_be_chosen(ffdstudio, cube, tmp_path):
    lattice = made(ffdstudio, cube, tmp_path, "--shape", 4, 3, "--axes", "zx")
    assert np.array_equal(lattice.axes, [[0, 0, 1], [1, 0, 0]])
    assert made(ffdstudio, cube, tmp_path, "--shape", 4).axes.tolist() == [[1, 0, 0]]


def test_a_lattice_may_be_written_for_another_tool(ffdstudio, cube, tmp_path):
    assert ffdstudio("lattice", cube, "--shape", 6, 4, 4, "-o", tmp_path / "l.xyz") == 0
    assert read_lattice_file(tmp_path / "l.xyz").format == "plot3d"


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        (["--shape", "1", "4"], "at least 2"),
        (["--shape", "4", "4", "4", "4"], "1 to 3 numbers"),
        (["--shape", "20000", "20000"], "20000 x 20000 control points are more than the 1,000,000"),
        (["--shape", "4", "4", "--degree", "4"], "degree 4"),
        (["--shape", "4", "4", "--degree", "0"], "degree 0"),
        (["--shape", "4", "4", "--degree", "1", "1", "1"], "as many degrees"),
        (["--shape", "4", "4", "--frozen", "2"], "leaves nothing"),
    ],
)
def test_wrong_lattices_are_refused(ffdstudio, square, tmp_path, words, cause):
    assert ffdstudio("lattice", square, *words, "-o", tmp_path / "l.lattice.json") == 2
    assert cause in ffdstudio.err
    assert ffdstudio.err.count("\n") == 1
    assert not (tmp_path / "l.lattice.json").exists()


def test_the_outermost_layer_is_frozen_where_mesh_lies_beyond(ffdstudio, square, tmp_path):
    words = ["lattice", square, "--marker", "top", "-o", tmp_path / "l.lattice.json"]
    result = ffdstudio.json(*words, "--shape", 5, 4)
    assert (result["frozen"], result["crossed_faces"]) == (1, ["j min"])
    assert read_lattice_file(tmp_path / "l.lattice.json").frozen == 1
    assert ffdstudio(*words, "--shape", 5, 4) == 0
    assert "both sides of j min: the outermost layer stays frozen" in ffdstudio.out
    result = ffdstudio.json(*words, "--shape", 5, 4, "--frozen", 0)
    assert (result["frozen"], result["crossed_faces"]) == (0, ["j min"])
    assert ffdstudio.json(*words, "--shape", 7, 6, "--frozen", 2)["frozen"] == 2


def test_a_net_without_inner_points_freezes_nothing_and_says_so(ffdstudio, square, tmp_path):
    words = ["lattice", square, "--marker", "top", "-o", tmp_path / "l.lattice.json"]
    assert ffdstudio(*words, "--shape", 5, 2) == 0
    assert "5x2 points leave none to freeze: nothing is frozen." in ffdstudio.out
    assert read_lattice_file(tmp_path / "l.lattice.json").frozen == 0


def test_nothing_is_frozen_around_everything(ffdstudio, cube, tmp_path):
    result = ffdstudio.json("lattice", cube, "-o", tmp_path / "l.lattice.json")
    assert (result["frozen"], result["crossed_faces"], result["on_planes"]) == (0, [], {})


def test_a_lattice_begins_at_the_symmetry_plane(ffdstudio, half, tmp_path):
    lattice = made(ffdstudio, half, tmp_path, "--shape", 5, 4, 4, "--margin", 0.25)
    low, high = corners(lattice)
    assert (low.tolist(), high.tolist()) == ([-0.25, 0, -0.25], [1.25, 1.25, 1.25])
    assert "The face j min lies on SYMMETRY, without a margin" in ffdstudio.out
    words = ["lattice", half, "--shape", 5, 4, "--axes", "xz", "-o", tmp_path / "l.lattice.json"]
    assert ffdstudio.json(*words)["on_planes"] == {}


def test_the_wings_lattice_begins_at_its_root(ffdstudio, shared, tmp_path):
    mesh = shared / "meshes" / "wing" / "oneram6_tets.su2"
    path = tmp_path / "m6.lattice.json"
    words = ["lattice", mesh, "--shape", 5, 4, 4, "--marker", "WING", "--margin", 0.3, "-o", path]
    result = ffdstudio.json(*words)
    assert result["on_planes"] == {"j min": "SYMMETRY"}
    assert result["crossed_faces"] == ["i min", "i max", "j max", "k min", "k max"]
    out = tmp_path / "out.su2"
    assert read_lattice_file(path).open_faces == ((1, 0),)
    moves = ["--move", "2,1,2=0,0.1,0", "--move", "2,0,2=0.1,0,0.05"]
    result = ffdstudio.json("morph", mesh, path, "-o", out, *moves)
    assert result["warnings"] == []
    before, after = read_mesh(mesh), read_mesh(out).points
    plane = before.marker_nodes("SYMMETRY")
    step = after[plane] - before.points[plane]
    assert np.abs(step[:, 1]).max() < 1e-13
    assert np.abs(step[:, 0]).max() > 0.01
    assert np.abs(after - before.points)[:, 1].max() > 0.005


def test_a_plane_case_is_open_in_front_and_back(ffdstudio, shared, tmp_path):
    mesh, path = shared / "meshes" / "openfoam" / "airFoil2D", tmp_path / "a.lattice.json"
    words = ["lattice", mesh, "--shape", 8, 6, 2, "--marker", "walls", "--margin", 0.3, "-o", path]
    result = ffdstudio.json(*words)
    assert result["frozen"] == 1
    assert result["on_planes"] == {"k min": "frontAndBack", "k max": "frontAndBack"}
    assert ffdstudio.json("info", path)["open_faces"] == ["k min", "k max"]
    words = ["morph", mesh, path, "-o", tmp_path / "case", "--move", "3,3,0=0,0.5,0"]
    [warning] = ffdstudio.json(*words)["warnings"]
    assert warning.startswith("front and back of frontAndBack are no longer opposite")
    words[4] = tmp_path / "other"
    result = ffdstudio.json(*words, "--move", "3,3,1=0,0.5,0")
    assert result["warnings"] == []
    assert result["moved"] > 1000
    assert ffdstudio("convert", path, tmp_path / "b.lattice.json") == 0
    assert read_lattice_file(tmp_path / "b.lattice.json").open_faces == ((2, 0), (2, 1))


def test_open_faces_that_are_none_are_refused(ffdstudio, tmp_path):
    path = tmp_path / "a.lattice.json"
    write_lattice(path, Lattice.box([0, 0], [1, 2], shape=(4, 3)), frozen=1, open_faces=[(1, 0)])
    text = path.read_text()
    for bad, cause in (("[[2, 0]]", "direction"), ('[["j", 0]]', "whole numbers"), ("3", "list")):
        path.write_text(text.replace("[[1, 0]]", bad))
        assert ffdstudio("info", path) == 2
        assert cause in ffdstudio.err


# ---- convert --------------------------------------------------------------------------------


def test_convert_says_whether_it_is_exact(ffdstudio, tmp_path):
    box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(6, 4, 4))
    write_lattice(tmp_path / "a.lattice.json", box, box.moved(box.control_points * 1.5))
    result = ffdstudio.json("convert", tmp_path / "a.lattice.json", tmp_path / "a.xyz")
    assert ffdstudio.code == 0
    assert result["import"]["exact"]
    assert not result["export"]["exact"]
    assert "one net" in result["export"]["reason"]
    assert ffdstudio("convert", tmp_path / "a.xyz", tmp_path / "b.lattice.json") == 0
    back = read_lattice(tmp_path / "b.lattice.json")[0]
    assert np.array_equal(back.control_points, box.control_points * 1.5)


def test_convert_refuses_what_is_not_exact_until_told(ffdstudio, tmp_path):
    box = Lattice.box([0, 0, 0], [1, 1, 1], (6, 4, 4), (2, 2, 2))
    write_lattice(tmp_path / "a.lattice.json", box)
    words = ["convert", tmp_path / "a.lattice.json", tmp_path / "a.xyz"]
    assert ffdstudio(*words) == 2
    assert "resample" in ffdstudio.err
    assert ffdstudio(*words, "--adapt", "resample") == 0
    assert "the shape differs by up to" in ffdstudio.out


def test_convert_chooses_a_block_and_says_how_many(ffdstudio, shared, tmp_path):
    source = shared / "meshes" / "plot3d" / "dpw4FFD.xyz"
    assert ffdstudio("convert", source, tmp_path / "a.lattice.json") == 0
    assert "holds 26 lattices" in ffdstudio.err
    assert ffdstudio("convert", source, tmp_path / "b.lattice.json", "--block", 1) == 0
    assert "not tied" in ffdstudio.err
    assert "holds 26" not in ffdstudio.err
    assert read_lattice(tmp_path / "b.lattice.json")[0] == read_lattice(source, block=1)[0]


def test_convert_puts_a_box_into_a_mesh(ffdstudio, square, tmp_path):
    box = Lattice.box([-0.1, -0.1], [1.1, 1.1], shape=(5, 4))
    write_lattice(tmp_path / "a.lattice.json", box)
    words = ["convert", tmp_path / "a.lattice.json", square, "--tag", "WING", "--marker", "top"]
    assert ffdstudio(*words) == 0
    text = square.read_text()
    assert "FFD_SURFACE_POINTS= 9\n" in text
    assert "bottom\t" not in text
    assert np.array_equal(read_lattice(square, block="WING")[0].control_points, box.control_points)
    assert len(read_mesh(square).points) == 81
    assert ffdstudio("convert", square, tmp_path / "b.g2", "--tag", "X") == 2
