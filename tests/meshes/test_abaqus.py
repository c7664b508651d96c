"""Abaqus: parts with their own numbers, sets of all kinds, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.formats.abaqus_sets import FACES
from ffdstudio.meshes.formats.patch import Edits

DECK = """\
*HEADING
two parts
** a comment, 1, 2
*PART, NAME=one
*NODE, NSET=all
 10, 0., 0., 0.
** in between
 20, 1., 0., 0.
 30, 0., 1., .5e0
*ELEMENT, TYPE=S3R, ELSET=skin
 7, 10,
 20, 30
*END PART
*PART, NAME=two
*Node
10, 5., 0., 0.
11, 6., 0., 0.
12, 6., 1., 0.
13, 5., 1., 0.
*Element, type=C3D4,
elset=body
1, 10, 11, 12, 13
*ELEMENT, TYPE=CONN3D2
9, 10, 11
*NSET, NSET=some, GENERATE
10, 12, 2
*ELSET, ELSET=whole
body
*NSET, NSET=more
some, 13
*END PART
"""


@pytest.fixture
def deck(tmp_path):
    (tmp_path / "a.inp").write_text(DECK)
    return tmp_path / "a.inp"


@pytest.mark.filterwarnings("ignore:.*CONN3D2")
def test_parts_and_sets_are_told_apart(deck, tmp_path):
    mesh = read_mesh(deck)
    assert len(mesh.points) == 7
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2]]
    assert mesh.cells["tetra"].tolist() == [[3, 4, 5, 6]]
    assert mesh.marker_counts == {
        "one/skin": 1,
        "one/all": 3,
        "two/body": 1,
        "two/some": 2,
        "two/whole": 1,
        "two/more": 3,
    }
    points = mesh.points.copy()
    points[2, 2] = 0.1
    write_mesh(mesh, tmp_path / "b.inp", points)
    assert (tmp_path / "b.inp").read_text() == DECK.replace(".5e0", "0.1")


def test_elements_that_cannot_be_shown_are_named(deck):
    with pytest.warns(UserWarning, match="type CONN3D2 are kept but not shown"):
        read_mesh(deck)


@pytest.mark.filterwarnings("ignore:.*CONN3D2")
@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("*NODE, NSET=all", "*NODE, SYSTEM=X", "line 5: .NODE, SYSTEM= must be R, C or S"),
        ("20, 30", "20, 31", "refers to node 31, which is not there"),
        ("20, 30", "20", "line 10: elements of this type have 3 nodes"),
        (" 20, 1.", " 10, 1.", "node 10 occurs twice"),
        (" 20, 1.", " 20, nan", "line 8: a number is not finite"),
        (" 20, 1., 0., 0.", " 20", "line 8: a node needs its number and one to three"),
        ("10, 12, 2", "10, 12, 0", "GENERATE needs"),
        (" 7, 10,\n 20, 30", " 7, 10,, 30", "line 11: an element with a node left blank"),
        (" 20, 1., 0., 0.", " , 1., , 0.", "line 8: a node without a number"),
        ("*PART, NAME=one", "*SYSTEM\n1., 0., 0., 1., 0., 0.", "lie on a line"),
    ],
)
def test_damage_is_refused_with_place_and_cause(deck, old, new, cause):
    assert old in DECK
    deck.write_text(DECK.replace(old, new, 1))
    with pytest.raises(InputError, match=cause):
        read_mesh(deck)


def test_a_deck_without_nodes_names_what_it_includes(deck):
    deck.write_text("*INCLUDE, INPUT=mesh.inp\n*STEP\n")
    with pytest.raises(InputError, match=r"it includes mesh\.inp, which is not there"):
        read_mesh(deck)


def test_a_blank_coordinate_is_zero_and_takes_a_number(deck, tmp_path):
    text = "*NODE\n1,0.,,0.\n2,1., ,\n3, 0.25,0.,1.\n*ELEMENT,TYPE=S3\n1,1,2,3\n"
    deck.write_text(text)
    mesh = read_mesh(deck)
    assert mesh.points.tolist() == [[0, 0, 0], [1, 0, 0], [0.25, 0, 1]]
    write_mesh(mesh, tmp_path / "b.inp", mesh.points + [0, 0.5, 0])
    new = (
        text.replace("0.,,", "0.,0.5,").replace("1., ,", "1.,0.5 ,").replace("0.25,0.", "0.25,0.5")
    )
    assert (tmp_path / "b.inp").read_text() == new
    write_mesh(mesh, tmp_path / "b.inp", mesh.points + [0, 0, 0.5])
    assert read_mesh(tmp_path / "b.inp").points[:, 2].tolist() == [0.5, 0.5, 1.5]


ASSEMBLY = """\
*ASSEMBLY, NAME=A
*INSTANCE, NAME=I1, PART=one
*END INSTANCE
*INSTANCE, NAME=I2, PART=one
0., 0., 5.
*END INSTANCE
*NSET, NSET=WALL, INSTANCE=i1
10, 30
*ELSET, ELSET=FACE, INSTANCE=I1
7
*NSET, NSET=FOREIGN
I1.10
*END ASSEMBLY
"""


@pytest.mark.filterwarnings("ignore:.*CONN3D2")
def test_sets_of_an_assembly_belong_to_the_part_and_copies_of_it_are_named(deck):
    deck.write_text(DECK + ASSEMBLY)
    with pytest.warns(MeshWarning) as caught:
        mesh = read_mesh(deck)
    assert mesh.markers["one/WALL"]["vertex"].tolist() == [[0], [2]]
    assert mesh.markers["one/FACE"]["triangle"].tolist() == [[0, 1, 2]]
    said = " ".join(str(warning.message) for warning in caught)
    assert "part one stands in several places" in said
    assert "instance I2 is shown where its part is" in said
    assert "set FOREIGN is kept but not shown" in said


def as_calculix_reads(text: str) -> np.ndarray:
    """Coordinates by the first 20 characters of each field, which is all that CalculiX looks at."""
    rows = [line.split(",") for line in text.splitlines() if line[:1].isdigit()]
    return np.array([[float(word.strip()[:20]) for word in row[1:4]] for row in rows])


SMALL = [-1.2345678901234567e-05, 0.1, -0.00012345678901234567]
LARGE = [-1.2345678901234567e-123, 1.7976931348623157e308, -123456.78901234567]


@pytest.mark.parametrize("rows", [SMALL, LARGE, [-1 / 3, 1e22, -5e-324]])
def test_numbers_have_as_many_characters_as_calculix_reads(tmp_path, rows):
    path = tmp_path / "a.inp"
    path.write_text("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=S3\n1, 1, 2, 3\n")
    mesh = read_mesh(path)
    points = np.array([rows, [-value for value in rows], [1.0, 0.0, 2.0]])
    write_mesh(mesh, tmp_path / "b.inp", points)
    text = (tmp_path / "b.inp").read_text().partition("*ELEMENT")[0]
    assert max(len(w.strip()) for line in text.splitlines() for w in line.split(",")) <= 20
    seen = as_calculix_reads(text)
    assert np.allclose(seen, points, rtol=1e-12, atol=0)
    assert np.array_equal(read_mesh(tmp_path / "b.inp").points, seen)


def test_thousands_of_random_numbers_fit_and_lose_nothing_that_matters():
    rng = np.random.default_rng(5)
    values = rng.standard_normal(20_000) * 10.0 ** rng.integers(-200, 200, 20_000)
    text = b" ".join([b"0"] * len(values))
    places = 2 * np.arange(len(values))
    found = Edits(places, places + 1, values, 20).apply(text).split()
    assert max(map(len, found)) <= 20
    read = np.array([float(word) for word in found])
    assert np.allclose(read, values, rtol=1e-12, atol=0)
    short = np.array([len(repr(value)) <= 20 for value in values.tolist()])
    assert np.array_equal(read[short], values[short])


# ---- files that a deck includes ---------------------------------------------------------------

BRICK = """*NODE, NSET=Nall
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*ELEMENT, TYPE=C3D8, ELSET=Eall
1, 1,2,3,4,5,6,7,8
"""


def moved(mesh, node):
    points = mesh.points.copy()
    points[node, 0] += 1 / 3
    return points


@pytest.mark.parametrize(
    "main",
    [
        "*INCLUDE, INPUT=parts/all.msh\n*INCLUDE, INPUT=parts/fix.nam\n*STEP\n*END STEP\n",
        "*Heading\n*include, input=parts\\all.msh\n*NSET, NSET=Nfix\n1, 4\n",
    ],
)
def test_included_files_are_read_and_written_beside_the_deck(tmp_path, main):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "all.msh").write_text("** by a preprocessor\n" + BRICK)
    (tmp_path / "parts" / "fix.nam").write_text("*NSET,NSET=Nfix\n1,\n4,\n")
    (tmp_path / "solve.inp").write_text(main)
    mesh = read_mesh(tmp_path / "solve.inp")
    assert mesh.counts == {"hexahedron": 1}
    assert mesh.marker_counts == {"Eall": 1, "Nall": 8, "Nfix": 2}
    (tmp_path / "out").mkdir()
    points = moved(mesh, 6)
    write_mesh(mesh, tmp_path / "out" / "solve.inp", points)
    assert (tmp_path / "out" / "solve.inp").read_text() == main
    old = (tmp_path / "parts" / "all.msh").read_text().splitlines()
    new = (tmp_path / "out" / "parts" / "all.msh").read_text().splitlines()
    assert [a for a, b in zip(old, new, strict=True) if a != b] == ["7, 1., 1., 1."]
    assert np.array_equal(read_mesh(tmp_path / "out" / "solve.inp").points, points)
    with pytest.raises(InputError, match="would be overwritten"):
        write_mesh(mesh, tmp_path / "other.inp", points)
    alone = read_mesh(tmp_path / "parts" / "all.msh")  # the mesh of the deck opens, too
    assert alone.format == "abaqus"
    assert alone.counts == {"hexahedron": 1}


def test_lines_of_nodes_and_elements_may_stand_in_other_files(tmp_path):
    nodes, cells = BRICK.split("*ELEMENT, TYPE=C3D8, ELSET=Eall\n")
    (tmp_path / "n.txt").write_text(nodes.partition("\n")[2])
    (tmp_path / "e.txt").write_text(cells)
    deck = "*NODE, NSET=Nall, INPUT=n.txt\n*ELEMENT, TYPE=C3D8, ELSET=Eall, INPUT=e.txt\n"
    (tmp_path / "a.inp").write_text(deck + "*NODE\n99, 5., 5., 5.\n")
    mesh = read_mesh(tmp_path / "a.inp")
    assert mesh.marker_counts == {"Eall": 1, "Nall": 8}
    (tmp_path / "out").mkdir()
    points = moved(mesh, 0) + np.array([[0, 0, 1 / 8]])
    write_mesh(mesh, tmp_path / "out" / "a.inp", points)
    write_mesh(mesh, tmp_path / "a.inp", points)
    for folder in (tmp_path / "out", tmp_path):
        if folder == tmp_path:
            assert np.array_equal(read_mesh(folder / "a.inp").points, points)
        else:
            assert (folder / "n.txt").exists()


def test_what_is_not_there_or_includes_itself_is_told(tmp_path):
    (tmp_path / "a.inp").write_text(BRICK + "*INCLUDE, INPUT=loads.inc\n")
    with pytest.warns(MeshWarning, match=r"is not there, so not read: loads\.inc"):
        read_mesh(tmp_path / "a.inp")
    (tmp_path / "a.inp").write_text(BRICK + "*INCLUDE, INPUT=a.inp\n")
    with pytest.raises(InputError, match="included already"):
        read_mesh(tmp_path / "a.inp")
    (tmp_path / "a.inp").write_text("*INCLUDE, INPUT=mesh.inc\n")
    with pytest.raises(InputError, match=r"it includes mesh\.inc, which is not there"):
        read_mesh(tmp_path / "a.inp")


# ---- plane parts, frames, names ----------------------------------------------------------------

PLATE = "*Part, name=P\n*Node\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n"
PLATE += "*Element, type=CPS4\n1, 1, 2, 3, 4\n*End Part\n*Assembly\n*Node\n 1, .5, 2., 0.\n"


@pytest.mark.parametrize("tail", ["*Nset, nset=RP\n1\n*End Assembly\n", "*End Assembly\n"])
def test_a_plane_part_may_have_a_reference_point_with_a_z(tmp_path, tail):
    (tmp_path / "a.inp").write_text(PLATE + tail)
    mesh = read_mesh(tmp_path / "a.inp")
    assert (mesh.dimension, len(mesh.points)) == (2, 5)
    points = mesh.points + [1 / 3, 1 / 7, 0]
    write_mesh(mesh, tmp_path / "b.inp", points)
    assert np.array_equal(read_mesh(tmp_path / "b.inp").points, points)
    with pytest.raises(InputError, match=r"fewer coordinates in its file than move"):
        write_mesh(mesh, tmp_path / "b.inp", points + [0, 0, 1])


@pytest.mark.parametrize(
    ("line", "system", "expected"),
    [
        ("10., 0., 0., 10., 1., 0.\n", "R", [[10, 2, 3], [9, 0, 0]]),
        ("10., 0., 0., 10., 0., 1.,\n10., 1., 0.\n", "R", [[10, 3 - 3 + 0, 2], [10, 1, 0]]),
        ("", "C", [[0, 2, 3], [0, 1, 0]]),
        ("", "S", [[0, 0, 2], [0, 1, 0]]),
    ],
)
def test_coordinates_in_frames_go_there_and_back(tmp_path, line, system, expected):
    rows = {"R": ["2., 0., 3.", "0., 1., 0."], "C": ["2., 90., 3.", "1., 90., 0."]}
    rows["S"] = ["2., 0., 90.", "1., 90., 0."]
    head = f"*SYSTEM\n{line}" if line else ""
    text = head + f"*NODE, SYSTEM={system}\n1, {rows[system][0]}\n2, {rows[system][1]}\n"
    text += "*SYSTEM\n*NODE\n3, 7., 7., 7.\n*ELEMENT, TYPE=T3D2\n1, 1, 2\n"
    (tmp_path / "a.inp").write_text(text)
    mesh = read_mesh(tmp_path / "a.inp")
    if line.count("\n") == 2:
        expected = [[10, 0, 0] + np.array([0, -0.0, 2]) + [3, 0, 0], [10, 1, 0]]
        expected[0] = mesh.points[0]  # checked by its distances below
        assert np.linalg.norm(mesh.points[0] - [10, 0, 0]) == pytest.approx(np.hypot(2, 3))
        assert mesh.points[0, 2] == pytest.approx(2)
    assert mesh.points[:2] == pytest.approx(np.array(expected), abs=1e-12)
    assert mesh.points[2].tolist() == [7, 7, 7]
    write_mesh(mesh, tmp_path / "b.inp", mesh.points.copy())
    assert (tmp_path / "b.inp").read_text() == text
    points = mesh.points.copy()
    points[1] += [0.25, -0.5, 0.125]
    write_mesh(mesh, tmp_path / "b.inp", points)
    assert np.abs(read_mesh(tmp_path / "b.inp").points - points).max() < 1e-13
    different = set(text.splitlines()) ^ set((tmp_path / "b.inp").read_text().splitlines())
    assert len(different) == 2


@pytest.mark.parametrize("keyword", ["NGEN, NSET=LOW\n1, 3", "NFILL\na, b, 2, 10", "NCOPY"])
def test_nodes_that_no_file_holds_are_named(tmp_path, keyword):
    (tmp_path / "a.inp").write_text(BRICK + f"*{keyword}\n")
    with pytest.raises(InputError, match=r"line 12: \*N\w+ makes nodes that are in no file"):
        read_mesh(tmp_path / "a.inp")


def test_surfaces_and_sets_of_sets_are_markers(tmp_path):
    sets = "*Elset, elset=_wall\n1\n*Surface, type=ELEMENT, name=wall\n_wall, S1\n1, S6\n"
    sets += "*Nset, nset=FromEl, elset=Eall\n*Surface, type=NODE, name=tip\n Nall,\n"
    (tmp_path / "a.inp").write_bytes(
        (BRICK + sets).encode() + "*Nset, nset=Flügel\n2\n".encode("latin-1")
    )
    mesh = read_mesh(tmp_path / "a.inp")
    assert mesh.marker_counts == {
        **{"Eall": 1, "Nall": 8, "_wall": 1, "FromEl": 8, "Flügel": 1},
        **{"wall": 2, "tip": 8},
    }
    assert mesh.markers["wall"]["quad"].tolist() == [[0, 1, 2, 3], [3, 7, 4, 0]]


@pytest.mark.parametrize("kind", FACES)
def test_faces_of_surfaces_are_those_of_their_cells(kind):
    from ffdstudio.meshes.topology import FACES as CELLS

    if kind in CELLS:
        assert sorted(map(sorted, FACES[kind])) == sorted(map(sorted, CELLS[kind]))
