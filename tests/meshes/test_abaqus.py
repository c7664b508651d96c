"""Abaqus: parts with their own numbers, sets of all kinds, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
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
        ("*NODE, NSET=all", "*NODE, SYSTEM=C", "line 5: nodes in cylindrical"),
        ("20, 30", "20, 31", "refers to node 31, which is not there"),
        ("20, 30", "20", "line 10: elements of this type have 3 nodes"),
        (" 20, 1.", " 10, 1.", "node 10 occurs twice"),
        (" 20, 1.", " 20, nan", "line 8: a number is not finite"),
        (" 20, 1., 0., 0.", " 20, 1., 0.", "line 8: a node needs its number and 3"),
        ("10, 12, 2", "10, 12, 0", "GENERATE needs"),
        (" 7, 10,\n 20, 30", " 7, 10,, 30", "line 11: an element with a node left blank"),
        (" 20, 1., 0., 0.", " , 1., , 0.", "line 8: a node without a number"),
        ("*NODE, NSET=all", "*NODE, INPUT=n.inp", "line 5: its nodes are in n.inp"),
        ("*PART, NAME=one", "*SYSTEM\n1., 0., 0.", "a local frame"),
    ],
)
def test_damage_is_refused_with_place_and_cause(deck, old, new, cause):
    assert old in DECK
    deck.write_text(DECK.replace(old, new, 1))
    with pytest.raises(InputError, match=cause):
        read_mesh(deck)


def test_a_deck_without_nodes_names_what_it_includes(deck):
    deck.write_text("*INCLUDE, INPUT=mesh.inp\n*STEP\n")
    with pytest.raises(InputError, match=r"it includes mesh\.inp: open that file"):
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


@pytest.mark.filterwarnings("ignore:.*CONN3D2")
def test_an_included_file_with_nodes_is_refused_and_any_other_named(deck, tmp_path):
    deck.write_text(DECK + "*INCLUDE, INPUT=more.inp\n")
    (tmp_path / "more.inp").write_text("*MATERIAL\n")
    with pytest.warns(UserWarning, match=r"what it includes is not read: more\.inp"):
        read_mesh(deck)
    (tmp_path / "more.inp").write_text("*NODE\n1, 0., 0., 0.\n")
    with pytest.raises(InputError, match=r"the nodes in more\.inp, which it includes, would not"):
        read_mesh(deck)


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
