"""`ffdstudio morph`."""

import os
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import Lattice, read_lattice, read_mesh, write_lattice
from ffdstudio.exchange import su2


def lattice_file(folder, shape=(5, 5), frozen=0, **box):
    path = folder / "box.lattice.json"
    d = len(shape)
    lattice = Lattice.box(box.get("lower", [0.0] * d), box.get("upper", [1.0] * d), shape)
    write_lattice(path, lattice, frozen=frozen)
    return path, lattice


def moved_text(old, new):
    return [
        i for i, (a, b) in enumerate(zip(old.splitlines(), new.splitlines(), strict=True)) if a != b
    ]


def test_nothing_moved_gives_the_same_bytes(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    out = tmp_path / "out.su2"
    result = ffdstudio.json("morph", square, path, "-o", out)
    assert ffdstudio.code == 0
    assert out.read_bytes() == square.read_bytes()
    assert (result["moved"], result["max_displacement"], result["inverted"]) == (0, 0.0, 0)


def test_a_move_changes_the_lines_of_moved_nodes_and_nothing_else(ffdstudio, square, tmp_path):
    path, lattice = lattice_file(tmp_path)
    out = tmp_path / "out.su2"
    result = ffdstudio.json("morph", square, path, "-o", out, "--move", "2,2=0.01,0.02,0")
    assert ffdstudio.code == 0
    before, after = read_mesh(square).points, read_mesh(out).points
    changed = moved_text(square.read_text(), out.read_text())
    assert len(changed) == result["moved"] == int((before != after).any(axis=1).sum()) > 0
    from ffdstudio import embed

    points = lattice.control_points.copy()
    points[2, 2] += [0.01, 0.02, 0]
    expected = embed(lattice, before).deform(lattice.moved(points))
    assert np.array_equal(after, expected)
    assert result["max_displacement"] == np.linalg.norm(after - before, axis=1).max()
    assert result["nodes"] == 81
    assert result["safe_amplitude"] > 1


def test_moves_of_one_point_add_up_and_weights_pull(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    out, again = tmp_path / "out.su2", tmp_path / "again.su2"
    ffdstudio("morph", square, path, "-o", out, "--move", "2,2=0.01,0,0", "--move", "2,2=0.01,0,0")
    ffdstudio("morph", square, path, "-o", again, "--move", "2,2=0.02,0,0")
    assert out.read_bytes() == again.read_bytes()
    result = ffdstudio.json("morph", square, path, "-o", out, "--weight", "3,3=2")
    step = read_mesh(out).points - read_mesh(square).points
    assert result["moved"] > 0
    assert step.sum() > 0  # towards the control point, which lies up and to the right of the middle


def test_inverted_cells_are_exit_code_1_and_still_written(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    out = tmp_path / "out.su2"
    result = ffdstudio.json("morph", square, path, "-o", out, "--move", "2,2=1.5,0,0")
    assert ffdstudio.code == 1
    old, new = read_mesh(square), read_mesh(out)
    a, b, c = (new.points[old.cells["triangle"][:, k]] for k in range(3))
    area = np.cross(b - a, c - a)[:, 2]
    assert result["inverted"] == int((area <= 0).sum()) > 0
    assert 0 < result["safe_amplitude"] < 1


def test_frozen_layers_stay_and_the_file_says_how_many(ffdstudio, square, tmp_path):
    out = tmp_path / "out.su2"
    path, _ = lattice_file(tmp_path, (6, 6), frozen=2)
    words = ["morph", square, path, "-o", out, "--move", "1,2=0.1,0,0", "--weight", "4,2=3"]
    assert ffdstudio.json(*words)["moved"] == 0
    assert ffdstudio.json(*words, "--frozen", "0")["moved"] > 0
    assert ffdstudio.json(*words, "--frozen", "1")["moved"] > 0
    assert ffdstudio(*words, "--frozen", "3") == 2
    assert "frozen" in ffdstudio.err


def test_a_move_of_a_frozen_point_is_warned_of(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path, (6, 6), frozen=1)
    words = ["morph", square, path, "-o", tmp_path / "out.su2"]
    told = ffdstudio.json(*words, "--move", "0,2=0.1,0", "--move", "2,2=0.1,0", "--weight", "5,5=2")
    assert told["held"] == ["--move 0,2=0.1,0", "--weight 5,5=2"]
    assert "--move 0,2=0.1,0: this control point is frozen" in ffdstudio.err
    assert told["moved"] > 0


def test_how_far_each_marker_moves_is_told(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    out = tmp_path / "out.su2"
    told = ffdstudio.json("morph", square, path, "-o", out, "--move", "2,4=0,0.05")
    assert told["markers"]["bottom"] == 0
    before, after = read_mesh(square), read_mesh(out)
    step = np.linalg.norm(after.points - before.points, axis=1)
    assert told["markers"]["top"] == pytest.approx(step[before.marker_nodes("top")].max())
    ffdstudio("morph", square, path, "-o", out, "--move", "2,4=0,0.05")
    assert "(top by up to 0.0" in ffdstudio.out


def test_frozen_layers_of_a_deformed_lattice_are_reset(ffdstudio, square, tmp_path):
    rest = Lattice.box([0, 0], [1, 1], shape=(6, 6))
    write_lattice(tmp_path / "l.lattice.json", rest, rest.moved(rest.control_points * [1.1, 1, 1]))
    out = tmp_path / "out.su2"
    ffdstudio("morph", square, tmp_path / "l.lattice.json", "-o", out, "--frozen", "1")
    before, after = read_mesh(square).points, read_mesh(out).points
    border = ((before[:, :2] == 0) | (before[:, :2] == 1)).any(axis=1)
    assert np.array_equal(before[border], after[border])
    assert not np.array_equal(before, after)


def test_bodies_that_touch_stay_together_to_the_bit(ffdstudio, cubes, tmp_path):
    curved = Lattice.box([-0.2, -0.1, -0.1], [2.2, 1.1, 1.1], shape=(6, 5, 4))
    bend = 0.1 * np.sin(2 * curved.control_points[..., :1]) * [0.3, 1, 1]
    rest = curved.moved(curved.control_points + bend)
    write_lattice(tmp_path / "l.lattice.json", rest)
    words = [*cubes, tmp_path / "l.lattice.json", "-o", tmp_path / "out"]
    moves = ["--move", "2,2,2=0.03,0.05,0.02", "--weight", "3,2,1=1.7"]
    result = ffdstudio.json("morph", *words, *moves)
    assert len(result["meshes"]) == 2
    assert result["moved"] == sum(mesh["moved"] for mesh in result["meshes"])
    old = [read_mesh(path).points for path in cubes]
    new = [read_mesh(tmp_path / "out" / path.name).points for path in cubes]
    key = [{tuple(p): i for i, p in enumerate(points)} for points in old]
    shared = key[0].keys() & key[1].keys()
    assert len(shared) == 16
    for point in shared:
        a, b = new[0][key[0][point]], new[1][key[1][point]]
        assert a.tobytes() == b.tobytes()
        assert not np.array_equal(a, point)


def test_an_upright_surface_of_another_tool_is_an_extruded_lattice(ffdstudio, cube, tmp_path):
    path, out = tmp_path / "xz.g2", tmp_path / "out.su2"
    knots = "2 2\n0 0 1 1\n"
    path.write_text(f"200 1 0 0\n3 0\n{knots}{knots}0 0 0\n1 0 0\n0 0 1\n1 0 1\n")
    assert ffdstudio("morph", cube, path, "--move", "0,0=0,0,.1", "-o", out) == 0
    before, after = read_mesh(cube).points, read_mesh(out).points
    x, _, z = before.T
    assert np.allclose(after[:, 2], z + 0.1 * (1 - x) * (1 - z), rtol=0, atol=1e-15)
    assert np.array_equal(after[:, :2], before[:, :2])


def test_one_direction_stretches(ffdstudio, cube, tmp_path):
    lattice = Lattice.box([0], [1], shape=(4,))
    write_lattice(tmp_path / "l.lattice.json", lattice)
    out = tmp_path / "out.su2"
    assert (
        ffdstudio("morph", cube, tmp_path / "l.lattice.json", "-o", out, "--move", "3=0.5,0,0") == 0
    )
    before, after = read_mesh(cube).points, read_mesh(out).points
    assert np.allclose(after[:, 0], before[:, 0] + 0.5 * before[:, 0] ** 3, rtol=0, atol=1e-15)
    assert np.array_equal(after[:, 1:], before[:, 1:])


def test_the_box_in_an_su2_mesh_deforms_that_mesh_and_follows(ffdstudio, square, tmp_path):
    write_lattice(square, Lattice.box([-0.1, -0.1], [1.1, 1.1], shape=(4, 4)), tag="BOX")
    out = tmp_path / "out.su2"
    assert ffdstudio("morph", square, square, "-o", out, "--move", "2,2=0,0.05,0") == 0
    assert ffdstudio.err == ""
    old, new = read_lattice(square)[0], read_lattice(out)[0]
    step = new.control_points - old.control_points
    assert step[2, 2, 1] == pytest.approx(0.05)
    assert np.count_nonzero(step) == 1
    assert (
        ffdstudio("morph", square, square, "-o", out, "--move", "2,2=0,0.05,0", "--boxes", "keep")
        == 0
    )
    assert "FFD boxes" in ffdstudio.err
    assert read_lattice(out)[0] == old
    assert ffdstudio("morph", square, square, "-o", out, "--boxes", "strip") == 0
    assert su2.tags(out.read_bytes(), "out") == []


def test_a_broken_box_is_named_with_the_ways_past_it(ffdstudio, square, tmp_path):
    write_lattice(square, Lattice.box([0, 0], [1, 1], shape=(5, 4)))
    square.write_text(square.read_text().replace("BSPLINE_UNIFORM", "BSPLINE"))
    path, _ = lattice_file(tmp_path)
    words = ["morph", square, path, "--move", "1,1=0,.1", "-o", tmp_path / "out.su2"]
    assert ffdstudio(*words) == 2
    assert ffdstudio.err == (
        f"ffdstudio: error: {square}: an FFD box in this file cannot follow the shape: "
        "FFD_BLENDING= 'BSPLINE' is not known; keep or strip the boxes (--boxes keep|strip)\n"
    )
    for way in ("keep", "strip"):
        assert ffdstudio(*words, "--boxes", way) == 0


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        (["--move", "5,0=0,0,0"], "I runs from 0 to 4"),
        (["--move", "0,0,0=0,0,0"], "2 directions"),
        (["--move", "0=0,0,0"], "2 directions"),
        (["--move=-1,0=0,0,0"], "must read I,J=DX,DY[,DZ]"),
        (["--move", "0,0=0"], "two or three displacements"),
        (["--move", "0,0=nan,0,0"], "must read"),
        (["--move", "0,0=inf,0,0"], "must read"),
        (["--move", "0,0"], "must read"),
        (["--move", f"{'9' * 5000},2=0,1"], f"--move {'9' * 57}...: must read I,J=DX,DY[,DZ]"),
        (["--move", "\N{ARABIC-INDIC DIGIT THREE},2=0,1"], "must read I,J=DX,DY[,DZ]"),
        (["--weight", "0,0=0"], "positive"),
        (["--weight", "0,0=-1"], "positive"),
        (["--weight", "0,0=1,2"], "one positive number"),
        (["--weight", "0,0=x"], "must read I,J=W"),
        (["--move", "2,2=0,0,0.1"], "cannot move in z"),
        (["--block", "7"], "no lattice"),
        (["--frozen", "-1"], "--frozen"),
    ],
)
def test_wrong_edits_are_refused_and_write_nothing(ffdstudio, square, tmp_path, words, cause):
    path, _ = lattice_file(tmp_path)
    assert ffdstudio("morph", square, path, "-o", tmp_path / "out.su2", *words) == 2
    assert cause in ffdstudio.err
    assert ffdstudio.err.count("\n") == 1
    assert not (tmp_path / "out.su2").exists()


def test_a_broken_mesh_among_several_leaves_nothing(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    (tmp_path / "bad.su2").write_text("NDIME= 2\n")
    assert ffdstudio("morph", square, tmp_path / "bad.su2", path, "-o", tmp_path / "out") == 2
    assert not (tmp_path / "out").exists()


def test_names_that_collide_and_files_for_folders_are_refused(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    (tmp_path / "a").mkdir()
    twin = tmp_path / "a" / "square.su2"
    twin.write_bytes(square.read_bytes())
    assert ffdstudio("morph", square, twin, path, "-o", tmp_path / "out") == 2
    assert "same name" in ffdstudio.err
    assert ffdstudio("morph", square, square, path, "-o", square) == 2
    assert ffdstudio("morph", square, path, "-o", tmp_path / "a") == 0
    assert twin.read_bytes() == square.read_bytes()


def test_the_form_that_is_shown_is_the_one_of_the_lattice(ffdstudio, cube, tmp_path):
    path, _ = lattice_file(tmp_path, (3,))
    words = ["morph", cube, path, "-o", tmp_path / "out.su2"]
    assert ffdstudio(*words, "--move", "0,0") == 2
    assert "must read I=DX,DY,DZ" in ffdstudio.err
    assert ffdstudio(*words, "--move", "0=1,0") == 2
    assert "0=1,0: three displacements" in ffdstudio.err


def test_the_lattice_that_is_read_is_not_overwritten(ffdstudio, square, tmp_path):
    box = tmp_path / "box.su2"
    box.write_bytes(square.read_bytes())
    write_lattice(box, Lattice.box([0, 0], [1, 1], shape=(4, 4)))
    before = box.read_bytes()
    assert ffdstudio("morph", square, box, "--move", "1,1=0,0.1", "-o", box) == 2
    assert "would overwrite the lattice that is read" in ffdstudio.err
    assert box.read_bytes() == before


@pytest.mark.parametrize("command", ["morph", "lattice", "fit", "demo", "optimize", "replay"])
def test_an_output_without_a_name_is_refused(ffdstudio, square, tmp_path, monkeypatch, command):
    path, _ = lattice_file(tmp_path)
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    inputs = {"morph": [square, path], "fit": [square, square], "demo": []}.get(command, [square])
    assert ffdstudio(command, *inputs, "-o", "") == 2
    assert "a name is needed" in ffdstudio.err
    assert not list(Path.cwd().iterdir())


@pytest.mark.parametrize("old", [True, False])
def test_a_disk_that_is_full_after_the_first_of_several_meshes_changes_none(
    ffdstudio, cubes, tmp_path, monkeypatch, old
):
    path, _ = lattice_file(tmp_path, (4, 4, 4))
    out, flushed, flush = tmp_path / "out", [], os.fsync
    out.mkdir()
    for mesh in cubes if old else []:
        (out / mesh.name).write_bytes(b"old")

    def full(descriptor):
        flushed.append(descriptor)
        if len(flushed) > 1:
            raise OSError(28, "No space left on device")
        flush(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    assert ffdstudio("morph", *cubes, path, "--move", "1,1,1=0,0,.1", "-o", out) == 2
    assert "right.su2': no space left on device" in ffdstudio.err
    assert {p.name: p.read_bytes() for p in out.iterdir()} == (
        {mesh.name: b"old" for mesh in cubes} if old else {}
    )


@pytest.mark.parametrize("folder", [False, True])
def test_the_mesh_that_is_read_is_not_overwritten(ffdstudio, square, tmp_path, folder):
    path, _ = lattice_file(tmp_path)
    before = square.read_bytes()
    out = square.parent if folder else square
    assert ffdstudio("morph", square, path, "--move", "1,1=0,0.1", "-o", out) == 2
    assert "would overwrite the mesh that is read" in ffdstudio.err
    assert square.read_bytes() == before


def test_a_motion_beyond_all_bounds_is_refused(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path)
    out = tmp_path / "out.su2"
    assert ffdstudio("morph", square, path, "--move", "1,1=0,1e300", "-o", out) == 2
    assert "beyond 1e+100" in ffdstudio.err
    assert not out.exists()


# ---- what is said of planes, smoothness and the map ------------------------------------------


def test_a_symmetry_plane_that_bends_is_told_before_writing(ffdstudio, half, tmp_path):
    path, _ = lattice_file(tmp_path, (4, 4, 4), lower=[-0.1] * 3, upper=[1.1] * 3)
    out = tmp_path / "out.su2"
    result = ffdstudio.json("morph", half, path, "-o", out, "--move", "2,1,2=0,0.1,0")
    before, after = read_mesh(half), read_mesh(out).points
    off = np.abs(after[before.marker_nodes("SYMMETRY"), 1])
    [warning] = result["warnings"]
    count = f"{int((off > 0).sum())} of 25 nodes leave it"
    assert warning == f"SYMMETRY is no longer planar: {count}, by up to {off.max():.3g}"
    assert warning in ffdstudio.err
    assert ffdstudio.code == 0


def test_points_on_the_plane_keep_it_plane_and_leave_it_when_told(ffdstudio, half, tmp_path):
    path = tmp_path / "l.lattice.json"
    assert ffdstudio("lattice", half, "--shape", 4, 4, 4, "-o", path) == 0
    out = tmp_path / "out.su2"
    words = ["morph", half, path, "-o", out]
    slide = ["--move", "2,0,2=0.1,0,0.05", "--move", "1,1,1=0,0.05,0"]
    assert ffdstudio.json(*words, *slide)["warnings"] == []
    mesh = read_mesh(half)
    after = read_mesh(out).points[mesh.marker_nodes("SYMMETRY")]
    assert (after[:, 1] == 0).all()
    warnings = ffdstudio.json(*words, "--move", "2,0,2=0,0.1,0")["warnings"]
    assert warnings[0] == "a control point on SYMMETRY leaves its plane, by up to 0.1"
    assert "no longer planar" in warnings[1]
    assert (read_mesh(out).points[mesh.marker_nodes("SYMMETRY"), 1] > 0).any()


def test_moving_a_face_with_mesh_beyond_is_told(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path, (4, 4), lower=[-0.1, -0.1], upper=[1.1, 0.6])
    words = ["morph", square, path, "-o", tmp_path / "out.su2"]
    [warning] = ffdstudio.json(*words, "--move", "1,3=0,0.02")["warnings"]
    assert "move at j max, where mesh lies on both sides" in warning
    assert ffdstudio.json(*words, "--move", "1,2=0,0.02")["warnings"] == []
    assert ffdstudio.json(*words, "--move", "1,0=0,0.02")["warnings"] == []  # no mesh beyond j min
    assert ffdstudio.json(*words, "--move", "1,3=0,0.02", "--frozen", 1)["warnings"] == []


def test_whether_the_lattice_is_invertible_is_said_with_the_place(ffdstudio, square, tmp_path):
    path, _ = lattice_file(tmp_path, (5, 4))
    words = ["morph", square, path, "-o", tmp_path / "out.su2"]
    result = ffdstudio.json(*words, "--move", "2,2=0.01,0,0")
    assert (result["locally_invertible"], result["not_invertible_in"]) == (True, [])
    result = ffdstudio.json(*words, "--move", "0,0=1.5,0", "--move", "0,1=1.5,0")
    assert result["locally_invertible"] is False
    assert result["not_invertible_in"][0] == [[0, 0.5], [0, 1]]
    assert ffdstudio.json(*words, "--weight", "2,2=2")["locally_invertible_method"].startswith(
        "sampled at 12x12 points"
    )
    ffdstudio(*words, "--move", "0,0=1.5,0", "--move", "0,1=1.5,0")
    assert "the lattice folds in 1 knot span (" in ffdstudio.out
    assert "at i 0 to 0.5, j 0 to 1" in ffdstudio.out


def test_a_lattice_with_swapped_corners_is_refused_by_its_name(ffdstudio, cube, tmp_path):
    path = tmp_path / "swapped.cfg"
    corners = ["0,0,0", "1,0,0", "0,1,0", "1,1,0", "0,0,1", "1,0,1", "0,1,1", "1,1,1"]
    path.write_text(
        f"FFD_DEFINITION= (A, {', '.join(corners)})\nFFD_DEGREE= (2, 2, 2)\nFFD_BLENDING= BEZIER\n"
    )
    assert ffdstudio("morph", cube, path, "-o", tmp_path / "out.su2") == 2
    assert "swapped.cfg: the lattice at rest is folded" in ffdstudio.err
    assert "corners are in the wrong order" in ffdstudio.err
