"""Files of several lattices: all of them are opened, and what is not tied is said first."""

import numpy as np
import pytest

from ffdstudio import Lattice
from ffdstudio.cli.main import main
from ffdstudio.exchange import read_lattice_file
from ffdstudio.project.document import Document
from tests.project.scenes import write_cube


def plot3d(path, offsets, shape=(4, 3, 3)):
    lines = [str(len(offsets)), *(" ".join(map(str, shape)) for _ in offsets)]
    for offset in offsets:
        net = Lattice.box([0, 0, 0], [1, 1, 1], shape, spacing="uniform").control_points + offset
        lines += [" ".join(map(repr, net[..., axis].T.ravel().tolist())) for axis in range(3)]
    path.write_text("\n".join([*lines, ""]))
    return path


def gotools(path, offsets):
    lines = []
    for x, y, z in offsets:
        lines += ["700 1 0 0", "3 0", *["2 2", "0 0 1 1"] * 3]
        lines += [f"{x + i} {y + j} {z + k}" for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    path.write_text("\n".join([*lines, ""]))
    return path


ROW = [[0, 0, 0], [1, 0, 0], [5, 0, 0]]


@pytest.mark.parametrize(("name", "make", "shared"), [("a.xyz", plot3d, 9), ("a.g2", gotools, 4)])
def test_a_common_face_is_named_and_a_gap_is_not(tmp_path, name, make, shared):
    path = make(tmp_path / name, ROW)
    for block, partner in (("0", "1"), ("1", "0")):
        (note,) = read_lattice_file(path, block).notes
        assert f"shares {shared} control points with" in note
        assert f" {partner};" in note
    assert read_lattice_file(path, "2").notes == ()


def test_the_command_line_says_it_before_anything_moves(tmp_path, capsys):
    write_cube(tmp_path / "cube.su2")
    path = plot3d(tmp_path / "a.xyz", ROW)
    out = str(tmp_path / "out.su2")
    main(["morph", str(tmp_path / "cube.su2"), str(path), "--move", "1,1,1=0.1,0,0", "-o", out])
    said = capsys.readouterr().err
    assert "holds 3 lattices; the first is taken" in said
    assert "they are not tied here" in said


@pytest.mark.parametrize(("name", "make"), [("a.xyz", plot3d), ("a.g2", gotools)])
def test_the_window_opens_all_and_says_what_is_not_tied(tmp_path, name, make):
    document, told = Document(), []
    document.problem.connect(lambda title, cause, kind: told.append((cause, kind)))
    document.import_lattice(make(tmp_path / name, ROW))
    assert [item.name for item in document.model.lattices] == ["a 0", "a 1", "a 2"]
    lows = [float(item.rest.control_points[..., 0].min()) for item in document.model.lattices]
    assert lows == [0, 1, 5]
    assert sum("not tied" in cause for cause, _ in told) == 2
    assert {kind for _, kind in told} == {"note"}


def test_one_block_is_opened_by_its_name_alone(tmp_path):
    document = Document()
    document.problem.connect(lambda *_: None)
    document.import_lattice(plot3d(tmp_path / "a.xyz", ROW), "2")
    assert [item.name for item in document.model.lattices] == ["a"]


def test_more_lattices_than_a_project_takes_are_refused(tmp_path):
    document, told = Document(), []
    document.problem.connect(lambda title, cause, kind: told.append(cause))
    offsets = [[2.0 * k, 0, 0] for k in range(101)]
    document.import_lattice(plot3d(tmp_path / "a.xyz", offsets, (2, 2, 2)))
    assert not document.model.lattices
    assert "holds 101 lattices" in told[0]


NESTED = """NDIME= 3
NELEM= 0
NPOIN= 1
0 0 0
NMARK= 0
FFD_NBOX= 2
FFD_NLEVEL= 2
{}{}"""
BOX = """FFD_TAG= {tag}
FFD_LEVEL= {level}
FFD_DEGREE_I= 2
FFD_DEGREE_J= 2
FFD_DEGREE_K= 2
FFD_PARENTS= {parents}
FFD_CHILDREN= {children}
FFD_CORNER_POINTS= 8
0 0 {z}
1 0 {z}
1 1 {z}
0 1 {z}
0 0 {z}.5
1 0 {z}.5
1 1 {z}.5
0 1 {z}.5
FFD_CONTROL_POINTS= 0
FFD_SURFACE_POINTS= 0
"""


def test_a_box_that_rides_on_another_in_su2_says_that_it_does_not_here(tmp_path):
    path = tmp_path / "a.su2"
    outer = BOX.format(tag="OUTER", level=0, parents=0, children="1\nINNER", z=0)
    inner = BOX.format(tag="INNER", level=1, parents="1\nOUTER", children=0, z=3)
    path.write_text(NESTED.format(outer, inner))
    assert "carries INNER" in read_lattice_file(path, "OUTER").notes[0]
    assert "rides on its parent OUTER" in read_lattice_file(path, "INNER").notes[0]
    assert np.isfinite(read_lattice_file(path, "INNER").rest.control_points).all()
