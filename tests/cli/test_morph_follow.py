"""`morph --follow`: the lattice moves walls, the volume follows them."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import Lattice, write_lattice
from ffdstudio.meshes import quality, read_mesh
from ffdstudio.samples import sample


@pytest.fixture
def tight(tmp_path):
    """A lattice that fits the section tightly and cuts the air, moved by a fifth of a chord."""
    path = tmp_path / "tight.lattice.json"
    write_lattice(path, Lattice.box((-0.01, -0.07), (1.01, 0.07), (6, 2), (3, 1)))
    return path


MOVES = ("--move", "2,1=0,0.1", "--move", "3,1=0,0.1")


def test_a_tight_lattice_moves_the_section_and_the_air_follows(ffdstudio, tight, tmp_path):
    mesh, out = read_mesh(sample("naca0012.su2")), tmp_path / "out.su2"
    words = ["morph", mesh.path, tight, *MOVES, "-o", out, "--frozen", 0]
    carried = ffdstudio.json(*words)
    assert carried["follow"] is None
    assert carried["inverted"] > 0
    section = read_mesh(out).points[mesh.marker_nodes("airfoil")]
    result = ffdstudio.json(*words, "--follow")
    assert ffdstudio.code == 0
    assert result["follow"] == {
        "method": "inverse distance weighting with rotations", "walls": ["airfoil"], "steps": 1,
    }  # fmt: skip
    assert result["inverted"] == 0
    assert result["warnings"] == []
    points = read_mesh(out).points
    assert np.array_equal(points[mesh.marker_nodes("airfoil")], section)
    ratio = quality(mesh, points).measures["first_layer_ratio"]
    assert 0.97 < np.nanmin(ratio) <= np.nanmax(ratio) < 1.03


def test_the_text_says_what_the_volume_followed(ffdstudio, tight, tmp_path):
    ffdstudio("morph", sample("naca0012.su2"), tight, *MOVES, "-o", tmp_path / "o.su2", "--follow")
    assert "; the volume follows airfoil;" in ffdstudio.out


def test_nothing_moved_gives_the_same_bytes(ffdstudio, tight, tmp_path):
    source, out = sample("naca0012.su2"), tmp_path / "out.su2"
    assert ffdstudio.json("morph", source, tight, "-o", out, "--follow")["follow"]["walls"] == []
    assert out.read_bytes() == source.read_bytes()


def test_walls_are_chosen_by_name(ffdstudio, tight, tmp_path):
    source, out = sample("naca0012.su2"), tmp_path / "out.su2"
    words = ["morph", source, tight, *MOVES, "-o", out, "--follow", "--frozen", 0]
    ffdstudio.json(*words, "--walls", "farfield")  # outside of the lattice: nothing moves
    assert out.read_bytes() == source.read_bytes()
    assert ffdstudio(*words, "--walls", "hull") == 2
    assert "no marker hull" in ffdstudio.err


def test_a_body_without_volume_is_carried(ffdstudio, tmp_path):
    path, out = tmp_path / "l.lattice.json", tmp_path / "out.vtu"
    skin = sample("wing_skin.vtu")
    low, high = read_mesh(skin).bounds
    write_lattice(path, Lattice.box(low - 0.1, high + 0.1, (4, 4, 4)))
    words = ["morph", skin, path, "--move", "2,2,2=0,0,0.2", "-o", out]
    ffdstudio.json(*words)
    carried = read_mesh(out).points
    assert ffdstudio.json(*words, "--follow")["follow"]["walls"] == []
    assert np.array_equal(read_mesh(out).points, carried)
    assert (carried != read_mesh(skin).points).any()


def test_the_motion_for_the_solver_is_written_beside_it(ffdstudio, tight, tmp_path):
    source, motion = sample("naca0012.su2"), tmp_path / "motion.dat"
    out = tmp_path / "out.su2"
    ffdstudio.json(
        "morph", source, tight, *MOVES, "-o", out, "--follow", "--solver-motion", motion
    )  # fmt: skip
    rows = np.loadtxt(motion)
    after = read_mesh(out)
    assert rows[:, 0].astype(int).tolist() == after.marker_nodes("airfoil").tolist()
    assert np.array_equal(rows[:, 1:], after.points[after.marker_nodes("airfoil"), :2])


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        (["--walls", "airfoil"], "--walls says which"),
        (["--solver-motion", "OUT"], "a file of its own"),
        (["--solver-motion", "LATTICE"], "a file of its own"),
        (["--follow", "--move", "2,1=0,1e300"], "beyond 1e+100"),
    ],
)
def test_options_that_cannot_be_meant_write_nothing(ffdstudio, tight, tmp_path, words, cause):
    out = tmp_path / "out.su2"
    names = {"OUT": out, "LATTICE": tight}
    words = [names.get(word, word) for word in words]
    before = tight.read_bytes()
    assert ffdstudio("morph", sample("naca0012.su2"), tight, *MOVES, "-o", out, *words) == 2
    assert cause in ffdstudio.err
    assert not out.exists()
    assert tight.read_bytes() == before
