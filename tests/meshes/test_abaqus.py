"""Abaqus: parts with their own numbers, sets of all kinds, refusals."""

from __future__ import annotations

import pytest

from ffdstudio import InputError, read_mesh, write_mesh

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
