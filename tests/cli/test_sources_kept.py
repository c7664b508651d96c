"""No command overwrites what it has read, under whatever name; nothing is half written."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import Lattice, read_mesh
from ffdstudio.cli.main import main
from ffdstudio.exchange import write_lattice
from ffdstudio.samples import sample
from tests.meshes.specimens import SPECIMENS
from tests.meshes.test_openfoam import make
from tests.project.scenes import write_cube


def bytes_of(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.fixture
def cube(tmp_path):
    write_cube(tmp_path / "cube.su2")
    box = Lattice.box([-0.1] * 3, [1.1] * 3, (4, 4, 4))
    net = box.control_points.copy()
    net[1:3, 1:3, 1:3] += 0.05
    write_lattice(tmp_path / "box.lattice.json", box, box.moved(net))
    return tmp_path


JOURNAL = """{"format": "ffdstudio-journal", "schema": 1}
{"do": "open mesh", "path": "cube.su2", "sha256": "", "name": "cube"}
{"do": "open mesh", "path": "other.su2", "sha256": "", "name": "other"}
{"do": "create box", "name": "B", "lower": [-1, -1, -1], "upper": [2, 2, 2], "shape": [4, 4, 4],
"""


def journal(folder):
    shutil.copy(folder / "cube.su2", folder / "other.su2")
    (folder / "j.jsonl").write_text(
        JOURNAL.rstrip("\n") + ' "degrees": [3, 3, 3]}\n'
        '{"do": "move points", "item": "lattice3", "points": [[1, 1, 1]], '
        '"positions": [[0.1, 0.1, 0.1]]}\n'
    )
    return str(folder / "j.jsonl")


@pytest.mark.parametrize("where", [".", "linked", "renamed"])
def test_replay_beside_its_meshes_changes_nothing(cube, where, monkeypatch, capsys):
    said = journal(cube)
    target = cube
    if where == "linked":  # the whole folder by another name
        target = cube / "again"
        target.symlink_to(cube)
    if where == "renamed":  # the last of two meshes alone: the first is not written either
        target = cube / "out"
        target.mkdir()
        os.link(cube / "other.su2", target / "other.su2")
    before = bytes_of(cube)
    assert main(["replay", said, "-o", str(target)]) == 2
    assert "overwrite a file that is read" in capsys.readouterr().err
    assert bytes_of(cube) == before


def test_replay_elsewhere_writes_both(cube):
    said = journal(cube)
    assert main(["replay", said, "-o", str(cube / "out")]) == 0
    assert sorted(p.name for p in (cube / "out").iterdir()) == ["cube.su2", "other.su2"]


def test_a_link_to_the_mesh_is_the_mesh(cube, capsys):
    (cube / "link.su2").symlink_to(cube / "cube.su2")
    os.link(cube / "cube.su2", cube / "twin.su2")
    before = bytes_of(cube)
    for name in ("link.su2", "twin.su2", "cube.su2", "./cube.su2"):
        out = str(cube / name)
        assert (
            main(["morph", str(cube / "cube.su2"), str(cube / "box.lattice.json"), "-o", out]) == 2
        )
        assert "overwrite" in capsys.readouterr().err
    assert bytes_of(cube) == before


@pytest.fixture
def case(tmp_path):
    return make(tmp_path / "case")


@pytest.mark.parametrize("out", ["case/c.foam", "link/c.foam", "."])
def test_a_case_is_not_written_over_itself_by_another_name(case, capsys, out):
    box = Lattice.around(read_mesh(case).points, (3, 3, 3))
    lattice = case.parent / "box.lattice.json"
    write_lattice(lattice, box, box.moved(box.control_points + 0.1))
    (case.parent / "link").symlink_to(case)
    before = bytes_of(case)
    assert main(["morph", str(case), str(lattice), "-o", str(case.parent / out)]) == 2
    assert "overwrite" in capsys.readouterr().err
    assert {k: v for k, v in bytes_of(case).items() if k != "c.foam"} == before
    assert main(["morph", str(case), str(lattice), "-o", str(case.parent / "new")]) in (0, 1)


def test_a_fit_does_not_replace_its_target(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(sample("rae2822.dat"), "contour.dat")
    before = bytes_of(tmp_path)
    assert (
        main(["fit", "naca0012", "contour.dat", "--regular", "--evaluations", "3", "-o", "."]) == 2
    )
    assert "contour.dat: this would overwrite" in capsys.readouterr().err
    assert bytes_of(tmp_path) == before


def test_a_study_does_not_replace_what_it_reads_and_says_so_before_it_runs(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    shutil.copy(sample("rae2822.dat"), "contour.dat")
    Path("case.toml").write_text(
        '[shape]\nsource = "naca0012"\npoints = 61\n[lattice]\nshape = [5, 2]\n'
        '[objective]\nkind = "contour"\ntarget = "contour.dat"\n[budget]\niterations = 1\n'
    )
    assert main(["optimize", "case.toml", "-o", "."]) == 2
    assert "contour.dat: this would overwrite a file that is read" in capsys.readouterr().err
    assert not Path("history.csv").exists()
    assert main(["optimize", "case.toml", "-o", "out"]) == 0
    assert main(["optimize", "case.toml", "-o", "out", "--resume"]) == 0


def test_a_lattice_is_not_converted_over_itself_but_a_mesh_takes_a_box(cube):
    lattice = str(cube / "box.lattice.json")
    before = (cube / "box.lattice.json").read_bytes()
    assert main(["convert", lattice, lattice]) == 2
    assert (cube / "box.lattice.json").read_bytes() == before
    mesh = str(cube / "cube.su2")
    assert main(["convert", lattice, mesh, "--adapt", "resample"]) == 0
    assert b"FFD_NBOX" in Path(mesh).read_bytes()
    assert main(["convert", mesh, mesh, "--tag", "SECOND"]) in (0, 2)


def test_a_lattice_is_not_written_over_its_mesh(cube):
    mesh = cube / "cube.su2"
    before = mesh.read_bytes()
    os.link(mesh, cube / "a.lattice.json")
    assert main(["lattice", str(mesh), "-o", str(cube / "a.lattice.json")]) == 2
    assert mesh.read_bytes() == before


@pytest.mark.parametrize("name", ["a.b8.ugrid", "plain.cgns"])
def test_a_morph_keeps_both_suffixes_of_its_own(tmp_path, name):
    from ffdstudio.cli.optimize import _mesh_name

    SPECIMENS[name](tmp_path / name)
    mesh = read_mesh(tmp_path / name)
    assert _mesh_name(mesh, [mesh]) == "morphed" + name[name.index(".") :]
    assert np.isfinite(mesh.points).all()


@pytest.mark.parametrize("name", ["a.xdmf", "a.wkt"])
def test_a_format_that_can_only_be_read_says_so_before_the_work(
    tmp_path, name, capsys, monkeypatch
):
    import meshio

    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    meshio.Mesh(points, {"triangle": [[0, 1, 2]]}).write(tmp_path / name)
    box = Lattice.box([-1] * 3, [2] * 3, (3, 3, 3))
    write_lattice(tmp_path / "box.lattice.json", box)
    monkeypatch.setattr("ffdstudio.cli.morph.measured", lambda *_: pytest.fail("it has worked"))
    words = ["morph", str(tmp_path / name), str(tmp_path / "box.lattice.json")]
    assert main([*words, "-o", str(tmp_path / f"out{name[1:]}")]) == 2
    assert "can only be read" in capsys.readouterr().err
