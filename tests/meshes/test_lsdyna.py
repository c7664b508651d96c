"""LS-DYNA: fixed columns, commas, long fields, degenerate solids, parts, sets, includes."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning

XYZ = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]


def node(number: int, xyz: list, width: int = 16, first: int = 8) -> str:
    return f"{number:>{first}}" + "".join(f"{x!r:>{width}}" for x in map(float, xyz)) + "       0\n"


def short(number: int, xyz: list) -> str:
    """Line that ends behind the last coordinate that is not zero."""
    last = max((k for k in range(3) if xyz[k]), default=-1)
    return f"{number:8}" + "".join(f"{x:16}" for x in xyz[: last + 1]) + "\n"


def card(*fields: int, width: int = 8) -> str:
    return "".join(f"{value:>{width}}" for value in fields) + "\n"


NODES = "*NODE\n$ number, x, y, z\n" + "".join(node(k, xyz) for k, xyz in enumerate(XYZ, start=11))
SOLIDS = "*ELEMENT_SOLID\n" + card(1, 3, *range(11, 19)) + card(2, 3) + card(*range(11, 19), 0, 0)
SOLIDS += card(3, 3, 11, 12, 13, 15, 15, 15, 15, 15) + card(4, 4, 11, 12, 13, 14, 15, 15, 15, 15)
SOLIDS += card(5, 4, 11, 12, 13, 14, 15, 15, 18, 18)
SHELLS = "*ELEMENT_SHELL\n" + card(6, 5, 11, 12, 13, 14) + card(7, 5, 11, 12, 13, 13)
SHELLS += "*ELEMENT_SHELL_THICKNESS\n" + card(8, 5, 15, 16, 17, 18) + "  0.1  0.1  0.1  0.1\n"
BEAMS = "*ELEMENT_BEAM\n" + card(9, 6, 11, 12, 13) + "*ELEMENT_MASS\n" + card(10, 11)
PARTS = "*PART\n$ a comment\nWing skin\n" + card(5, 1, 1, width=10)
SETS = "*SET_NODE_LIST_TITLE\nclamped\n" + card(1, width=10) + card(11, 14, 0, width=10)
DECK = "*KEYWORD\n*TITLE\na deck\n" + NODES + SOLIDS + SHELLS + BEAMS + PARTS + SETS + "*END\n"


@pytest.fixture
def deck(tmp_path):
    (tmp_path / "a.k").write_text(DECK)
    return tmp_path / "a.k"


def test_cells_parts_and_sets_are_read(deck):
    mesh = read_mesh(deck)
    assert mesh.points.tolist() == XYZ
    assert mesh.counts == {
        **{"hexahedron": 2, "tetra": 1, "pyramid": 1, "wedge": 1},
        **{"quad": 2, "triangle": 1, "line": 1},
    }
    assert mesh.marker_counts == {
        **{"part 3": 3, "part 4": 2, "Wing skin": 3, "part 6": 1, "clamped": 2},
    }
    assert mesh.cells["wedge"].tolist() == [[0, 1, 4, 3, 2, 7]]


def test_at_rest_the_deck_keeps_its_bytes_and_a_moved_node_changes_its_columns(deck, tmp_path):
    mesh = read_mesh(deck)
    write_mesh(mesh, tmp_path / "b.k", mesh.points.copy())
    assert (tmp_path / "b.k").read_text() == DECK
    points = mesh.points.copy()
    points[6, 1] += 1 / 8
    write_mesh(mesh, tmp_path / "b.k", points)
    pairs = zip(DECK.splitlines(), (tmp_path / "b.k").read_text().splitlines(), strict=True)
    [(old, new)] = [(a, b) for a, b in pairs if a != b]
    assert (old[:24], old[40:]) == (new[:24], new[40:])
    assert float(new[24:40]) == 1.125
    assert np.array_equal(read_mesh(tmp_path / "b.k").points, points)


def test_numbers_are_rounded_to_their_columns_and_that_is_said(deck, tmp_path):
    mesh = read_mesh(deck)
    points = mesh.points - np.array([1 / 3, 1e-7 / 3, 1e5 / 3])
    with pytest.warns(MeshWarning, match="rounded to the 16 characters"):
        write_mesh(mesh, tmp_path / "b.k", points)
    lines = (tmp_path / "b.k").read_text().split("*ELEMENT")[0].splitlines()[5:]
    cut = [[float(line[k : k + 16]) for k in (8, 24, 40)] for line in lines]
    assert np.abs(np.array(cut) - points).max() < 1e-9
    assert np.array_equal(read_mesh(tmp_path / "b.k").points, np.array(cut))


@pytest.mark.parametrize(
    "text",
    [
        "*KEYWORD LONG=Y\n*NODE\n" + "".join(node(k, xyz, 20, 20) for k, xyz in enumerate(XYZ)),
        "*NODE\n" + "".join(f"{k}, {x}, {y}., {z}\n" for k, (x, y, z) in enumerate(XYZ)),
        "*NODE\n" + "".join(short(k, xyz) for k, xyz in enumerate(XYZ, start=1)),
    ],
)
def test_nodes_may_have_long_fields_commas_or_blanks(tmp_path, text):
    (tmp_path / "a.k").write_text(text)
    mesh = read_mesh(tmp_path / "a.k")
    assert mesh.points.tolist() == XYZ
    points = mesh.points + [0.5, 0.25, 0.125]
    write_mesh(mesh, tmp_path / "b.k", points)
    assert np.array_equal(read_mesh(tmp_path / "b.k").points, points)


def test_included_files_follow_and_those_that_are_not_there_are_told(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "sub" / "nodes.k").write_text(NODES)
    (tmp_path / "a.k").write_text("*INCLUDE\nsub/nodes.k\n*INCLUDE\nloads.k\n" + SHELLS)
    with pytest.warns(MeshWarning, match=r"loads\.k, which it includes, is not there"):
        mesh = read_mesh(tmp_path / "a.k")
    write_mesh(mesh, tmp_path / "out" / "a.k", mesh.points + 0.5)
    with pytest.warns(MeshWarning):
        again = read_mesh(tmp_path / "out" / "a.k")
    assert np.array_equal(again.points, mesh.points + 0.5)
    with pytest.raises(InputError, match="would be overwritten"):
        write_mesh(mesh, tmp_path / "b.k", mesh.points + 0.5)


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        (card(6, 5, 11, 12, 13, 14), card(6, 5, 11, 12, 13, 99), "node 99, which is not there"),
        (card(6, 5, 11, 12, 13, 14), card(6, 5, 11), "too few nodes"),
        (node(12, XYZ[1]), node(11, XYZ[1]), "node 11 occurs twice"),
        (
            node(12, XYZ[1]),
            node(12, XYZ[1]).replace("1.0", "1.x"),
            "line 7: not the line of a node",
        ),
        (NODES, "", "no .NODE with nodes"),
    ],
)
def test_damage_is_refused_with_place_and_cause(deck, old, new, cause):
    assert old in DECK
    deck.write_text(DECK.replace(old, new, 1))
    with pytest.raises(InputError, match=cause):
        read_mesh(deck)


def test_cells_that_are_not_known_are_counted(deck):
    deck.write_text(DECK.replace("*END", "*ELEMENT_SOLID_NURBS_PATCH\n" + card(1, 2) + "*END"))
    with pytest.warns(MeshWarning, match="kept but not shown"):
        assert read_mesh(deck).unread == {"*ELEMENT_SOLID_NURBS_PATCH": 1}
