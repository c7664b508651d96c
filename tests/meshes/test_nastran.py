"""Nastran: all field widths, promotion of moved nodes, included files, frames."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.formats.nastran_reals import sixteen
from tests.meshes.oracles import with_meshio

DECK = """\
SOL 101
CEND
BEGIN BULK
$ small, large and free fields
GRID           1              0.     1.5  2.5-16              7\r
grid    2               1.       0.      1.D+0
GRID*                  3               0              1.              1.*
*                     0.               0
GRID,4,,0.,1.,0. $ last
GRID*,5,,0.5,0.5,*A
*A,-1.5
CQUAD4         1       9       1       2       3       4     30.
CTRIA3,2,10,1,2,5
CTETRA         3      11       1       2       3       5
CBAR           4      12       1       2      1.      0.      0.
CBUSH          5      12       1
ENDDATA
"""
POINTS = [[0, 1.5, 2.5e-16], [1, 0, 1], [1, 1, 0], [0, 1, 0], [0.5, 0.5, -1.5]]


@pytest.fixture
def deck(tmp_path) -> Path:
    (tmp_path / "a.bdf").write_bytes(DECK.encode())
    return tmp_path / "a.bdf"


def test_all_field_widths_are_read(deck):
    mesh = read_mesh(deck)
    assert mesh.points.tolist() == POINTS
    assert mesh.counts == {"triangle": 1, "quad": 1, "tetra": 1, "line": 1}
    assert mesh.cells["tetra"].tolist() == [[0, 1, 2, 4]]
    assert mesh.marker_counts == {
        "property 9": 1,
        "property 10": 1,
        "property 11": 1,
        "property 12": 1,
    }


def test_at_rest_the_deck_keeps_its_bytes(deck, tmp_path, shared):
    for path in (deck, *(shared / "meshes" / "nastran").glob("*.bdf")):
        write_mesh(read_mesh(path), tmp_path / "out.bdf")
        assert (tmp_path / "out.bdf").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("node", range(5))
def test_a_moved_node_becomes_a_large_card_and_nothing_else_changes(deck, tmp_path, node):
    mesh = read_mesh(deck)
    points = mesh.points.copy()
    points[node] = [0.125, -0.25, 1 / 1024]
    write_mesh(mesh, tmp_path / "out.bdf", points)
    again = read_mesh(tmp_path / "out.bdf")
    assert np.array_equal(again.points, points)
    new = (tmp_path / "out.bdf").read_text().splitlines()
    old = DECK.splitlines()
    gone = [line for line in old if line not in new]
    assert len(gone) <= 2
    assert all(line.lower().startswith(("grid", "*")) for line in gone)
    added = [line for line in new if line not in old]
    assert [line[:5] for line in added if not line.startswith("$")] == ["GRID*", "*    "]
    kept = ("" if node else "7") in added[-1]
    assert kept


def test_meshio_finds_the_coordinates_to_sixteen_characters(shared, tmp_path):
    (path,) = (shared / "meshes" / "nastran").glob("*.bdf")
    mesh = read_mesh(path)
    points = mesh.points + np.random.default_rng(0).normal(0, 1, mesh.points.shape)
    with pytest.warns(MeshWarning, match="16 characters"):
        write_mesh(mesh, tmp_path / "out.bdf", points)
    found = with_meshio(tmp_path / "out.bdf")
    assert np.abs(found / points - 1).max() < 1e-11
    assert np.abs(found - points).max() < 1e-13 * np.abs(points).max()
    assert np.array_equal(found, read_mesh(tmp_path / "out.bdf").points)


def test_sixteen_characters_hold_the_closest_number():
    rng = np.random.default_rng(5)
    for value in (rng.normal(size=300) * 10.0 ** rng.integers(-30, 30, 300)).tolist():
        text = sixteen(value)
        assert len(text) <= 16
        plain = float(re.sub(r"(?<=[\d.])([+-])", r"e\1", text))
        assert plain == pytest.approx(value, rel=1e-10)
    assert [sixteen(x) for x in (0.0, -2.0, 0.1, 1e22)] == ["0.", "-2.", ".1", "1.+22"]


def test_included_files_follow_their_deck(tmp_path):
    (tmp_path / "in" / "parts").mkdir(parents=True)
    main, part = tmp_path / "in" / "a.bdf", tmp_path / "in" / "parts" / "nodes.bdf"
    main.write_text("BEGIN BULK\nINCLUDE 'parts/nodes.bdf'\nGRID,9,,1.,1.,1.\n")
    part.write_text("GRID,1,,0.,0.,0.\n$ here\nGRID,2,,1.,0.,0.\nCROD,1,1,1,2\n")
    mesh = read_mesh(main)
    assert mesh.points.tolist() == [[1, 1, 1], [0, 0, 0], [1, 0, 0]]
    moved = mesh.points + np.array([[0, 0, 0], [0.5, 0, 0], [0, 0, 0]])
    write_mesh(mesh, tmp_path / "out.bdf", moved)
    assert (tmp_path / "out.bdf").read_bytes() == main.read_bytes()
    assert (
        (tmp_path / "parts" / "nodes.bdf")
        .read_text()
        .endswith("\n$ here\nGRID,2,,1.,0.,0.\nCROD,1,1,1,2\n")
    )
    assert np.array_equal(read_mesh(tmp_path / "out.bdf").points, moved)
    before = part.read_bytes()
    with pytest.raises(InputError, match="would be overwritten"):
        write_mesh(mesh, tmp_path / "in" / "other.bdf", moved)
    assert part.read_bytes() == before
    assert not (tmp_path / "in" / "other.bdf").exists()
    write_mesh(mesh, main, moved)
    assert np.array_equal(read_mesh(main).points, moved)


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("GRID,4,,", "GRID,4,3,", "line 9: GRID 4 is given in the local frame 3"),
        ("GRID,4,", "GRID,1,", "GRID 1 occurs twice, in different places"),
        ("1.D+0", "1.X+0", "line 6: expected a number in a field, found '1.X"),
        (",10,1,2,5", ",10,1,2,6", "an element refers to GRID 6, not there"),
        ("GRID,4,,0.,", "GRID,4,,1e999,", "line 9: expected a number"),
        ("CEND", "INCLUDE 'a.bdf'", "included already"),
        ("BEGIN BULK", "GRDSET,,3", "local frame 3"),
        ("*A,-1.5", "*B,-1.5", "line 10: the next line is not the continuation of this card, .A"),
        ("*A,-1.5\n", "", "line 10: the next line is not the continuation"),
        (",10,1,2,5", ",10,1,2", "this element needs 3 nodes"),
        ("CTETRA", "+,7\n=,*1,=,=\nCTETRA", "line 15: '=' repeats cards of one line"),
    ],
)
def test_damage_is_refused_with_place_and_cause(deck, old, new, cause):
    assert old in DECK
    deck.write_bytes(DECK.replace(old, new, 1).encode())
    with pytest.raises(InputError, match=cause):
        read_mesh(deck)


def test_comments_and_empty_lines_may_stand_before_a_continuation(tmp_path):
    large = DECK.replace("1.*\n", "1.*\n$--\n\n$ longer than a field\n")
    hexa = "CHEXA          1       1       1       2       3       4       5       1+\n"
    hexa += "$ c\n+              2       3\n"
    large = large.replace("*                     0.", "*                    .25")
    (tmp_path / "a.bdf").write_text(large.replace("ENDDATA", hexa + "ENDDATA"))
    mesh = read_mesh(tmp_path / "a.bdf")
    assert mesh.points[2].tolist() == [1, 1, 0.25]
    assert mesh.cells["hexahedron"].tolist() == [[0, 1, 2, 3, 4, 0, 1, 2]]
    moved = mesh.points.round(3) + 0.5
    write_mesh(mesh, tmp_path / "b.bdf", moved)
    assert np.array_equal(read_mesh(tmp_path / "b.bdf").points, moved)
    assert "$ longer than a field" in (tmp_path / "b.bdf").read_text()


def test_a_continuation_that_stands_elsewhere_is_refused(tmp_path):
    cards = "".join(f"GRID*{k:>19}{'':16}{k:>15}.{0:>15}.*A{k}\n" for k in (1, 2))
    (tmp_path / "a.bdf").write_text("BEGIN BULK\n" + cards + "*A1,5.\n*A2,6.\nENDDATA\n")
    with pytest.raises(InputError, match=r"line 2: the next line is not the continuation .* \*A1"):
        read_mesh(tmp_path / "a.bdf")


def test_cards_behind_the_end_are_not_read_and_names_may_be_indented(tmp_path):
    text = DECK.replace("GRID,4", " GRID,4").replace("GRID           1", " GRID          1")
    (tmp_path / "a.bdf").write_text(text + "GRID,9,,1.,1.,1.\nINCLUDE 'nowhere'\n")
    assert read_mesh(tmp_path / "a.bdf").points.tolist() == POINTS


def test_nodes_in_the_middle_of_edges_may_be_left_out(tmp_path):
    text = DECK.replace("CTRIA3", "CTRIA6").replace("CBUSH", "CQUAD8,6,13,1,2,3,4\nCBUSH")
    (tmp_path / "a.bdf").write_text(text)
    assert read_mesh(tmp_path / "a.bdf").counts == {
        "triangle": 1,
        "quad": 2,
        "tetra": 1,
        "line": 1,
    }


def test_a_second_export_replaces_the_included_files_of_the_first(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.bdf").write_text("BEGIN BULK\nINCLUDE 'n.bdf'\n")
    (tmp_path / "in" / "n.bdf").write_text("GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\n")
    mesh = read_mesh(tmp_path / "in" / "a.bdf")
    for points in (mesh.points + 0.125, mesh.points):
        write_mesh(mesh, tmp_path / "out.bdf", points)
        assert np.array_equal(read_mesh(tmp_path / "out.bdf").points, points)


def test_names_of_included_files_go_over_lines_and_may_be_seen_from_their_own_folder(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.bdf").write_text("BEGIN BULK\nINCLUDE 'sub/\n   b.bdf'\n")
    (tmp_path / "sub" / "b.bdf").write_text("INCLUDE 'c.bdf'\nGRDSET,,\n")
    (tmp_path / "sub" / "c.bdf").write_text("GRID,1,,0.,0.,0.\n")
    mesh = read_mesh(tmp_path / "a.bdf")
    (tmp_path / "out").mkdir()
    write_mesh(mesh, tmp_path / "out" / "a.bdf", mesh.points + 0.5)
    assert read_mesh(tmp_path / "out" / "a.bdf").points.tolist() == [[0.5, 0.5, 0.5]]
    (tmp_path / "sub" / "b.bdf").write_text("INCLUDE 'c.bdf'\nGRDSET,,5\n")
    with pytest.raises(InputError, match=r"c\.bdf, line 1: GRID 1 is given in the local frame 5"):
        read_mesh(tmp_path / "a.bdf")


# ---- local frames ----------------------------------------------------------------------------


def small(name, *fields):
    """Card of fields of eight characters."""
    return f"{name:8}" + "".join(f"{field!s:>8}" for field in fields) + "\n"


def large(name, *fields):
    """Line of a card of fields of sixteen characters."""
    return f"{name:8}" + "".join(f"{field!s:>16}" for field in fields) + "\n"


FRAMES = "BEGIN BULK\n" + small("CORD2R", 1, 0, "1.", "2.", "3.", "1.", "2.", "4.")
FRAMES += small("+", "1.", "3.", "3.") + "CORD2C,2,1,0.,0.,0.,0.,0.,1.\n,0.,1.,1.\n"
FRAMES += large("CORD2S*", 3, 2, "1.", "90.") + large("*", "0.", "1.", "90.", "1.")
FRAMES += large("*", "2.", "90.", "0.") + small("CORD1R", 4, 11, 12, 13)
FRAMES += small("GRID", 1, 1, ".5", ".25", "1.") + small("GRID", 2, 2, "2.", "350.", "-1.")
FRAMES += small("GRID", 3, 3, "2.", "30.", "170.") + large("GRID*", 4, 4, ".5", ".25")
FRAMES += large("*", ".75") + small("GRID", 11, "", "10.", "0.", "0.")
FRAMES += small("GRID", 12, "", "10.", "0.", "2.") + small("GRID", 13, "", "11.", "1.", "0.")
FRAMES += "GRID,14,0,1.,2.,3.\n" + small("CTETRA", 1, 1, 1, 2, 3, 4) + "ENDDATA\n"


@pytest.fixture
def framed(tmp_path) -> Path:
    (tmp_path / "a.bdf").write_text(FRAMES)
    return tmp_path / "a.bdf"


def turned(*points) -> np.ndarray:
    """Origin and axes through three points, by the definition."""
    a, b, c = np.array(points, dtype=float)
    z = (b - a) / np.linalg.norm(b - a)
    x = (c - a) - ((c - a) @ z) * z
    x /= np.linalg.norm(x)
    return np.vstack([a, x, np.cross(z, x), z])


def test_nodes_in_local_frames_are_where_the_definition_puts_them(framed):
    mesh = read_mesh(framed)
    one = turned([1, 2, 3], [1, 2, 4], [1, 3, 3])
    assert mesh.points[0] == pytest.approx(one[0] + [0.5, 0.25, 1] @ one[1:])
    two = turned(*[one[0] + np.array(p) @ one[1:] for p in ([0, 0, 0], [0, 0, 1], [0, 1, 1])])
    t = np.radians(350)
    assert mesh.points[1] == pytest.approx(two[0] + [2 * np.cos(t), 2 * np.sin(t), -1] @ two[1:])

    def cylindrical(r, t, z):
        return (
            two[0] + np.array([r * np.cos(np.radians(t)), r * np.sin(np.radians(t)), z]) @ two[1:]
        )

    three = turned(cylindrical(1, 90, 0), cylindrical(1, 90, 1), cylindrical(2, 90, 0))
    t, p = np.radians(30), np.radians(170)
    local = 2 * np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    assert mesh.points[2] == pytest.approx(three[0] + local @ three[1:])
    four = turned([10, 0, 0], [10, 0, 2], [11, 1, 0])
    assert mesh.points[3] == pytest.approx(four[0] + [0.5, 0.25, 0.75] @ four[1:])


def test_a_moved_node_is_put_back_into_its_frame_and_others_keep_their_lines(framed, tmp_path):
    mesh = read_mesh(framed)
    for node in range(4):
        points = mesh.points.copy()
        points[node] += [0.31, -0.27, 0.11]
        write_mesh(mesh, tmp_path / "out.bdf", points)
        assert np.abs(read_mesh(tmp_path / "out.bdf").points - points).max() < 1e-12
        old, new = FRAMES.splitlines(), (tmp_path / "out.bdf").read_text().splitlines()
        assert len(set(old) - set(new)) == (1 if node < 3 else 2)
    write_mesh(mesh, tmp_path / "out.bdf", mesh.points.copy())
    assert (tmp_path / "out.bdf").read_text() == FRAMES


def test_a_frame_by_nodes_moves_with_them_and_its_nodes_stay_where_they_are_put(framed, tmp_path):
    mesh = read_mesh(framed)
    random = np.random.default_rng(4)
    moved = mesh.points + random.normal(0, 0.2, mesh.points.shape)
    write_mesh(mesh, tmp_path / "out.bdf", moved)
    assert np.abs(read_mesh(tmp_path / "out.bdf").points - moved).max() < 1e-11
    points = mesh.points.copy()
    points[5] += [0.5, 0.25, 0]  # a node of the frame: node 4 stays, its numbers change
    write_mesh(mesh, tmp_path / "out.bdf", points)
    assert np.abs(read_mesh(tmp_path / "out.bdf").points - points).max() < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("CORD1R         4", "CORD1R         5", "local frame 4"),
        ("1.      3.      3.\nCORD2C", "1.      2.      9.\nCORD2C", "lie on a line"),
        ("CORD2C,2,1", "CORD2C,2,3", "local frame [23]"),  # given in each other
        ("11      12      13", "11      12      99", "local frame 4"),
    ],
)
def test_frames_that_cannot_be_made_are_refused(framed, old, new, cause):
    assert old in FRAMES
    framed.write_text(FRAMES.replace(old, new))
    with pytest.raises(InputError, match=cause):
        read_mesh(framed)


# ---- tabs, duplicates, repeats, what is not there, superelements -------------------------------

TABS = "BEGIN BULK\nGRID\t1\t\t0.0\t0.5\t-1.\nGRID*\t2\t\t\t\t1.0\t\t0.25\n*\t3.\n"
TABS += "GRID\t,3,,1.,1.\t,1. $\ta comment\nCTRIA3\t1\t1\t1\t2\t3\nENDDATA\n"


def test_tabs_go_on_to_the_next_field_and_stay_where_nothing_moves(tmp_path):
    (tmp_path / "a.bdf").write_text(TABS)
    mesh = read_mesh(tmp_path / "a.bdf")
    assert mesh.points.tolist() == [[0, 0.5, -1], [1, 0.25, 3], [1, 1, 1]]
    points = mesh.points + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.5]])
    write_mesh(mesh, tmp_path / "b.bdf", points)
    text = (tmp_path / "b.bdf").read_text()
    assert np.array_equal(read_mesh(tmp_path / "b.bdf").points, points)
    assert text.startswith(TABS[: TABS.index("GRID\t,3")])
    assert text.endswith("CTRIA3\t1\t1\t1\t2\t3\nENDDATA\n")
    assert "$\ta comment" in text


@pytest.mark.parametrize(
    "again", ["GRID,2,,1.,0.,0.", small("GRID", 2, "", 1.0, "0.", "0.").strip()]
)
def test_a_card_that_repeats_another_counts_once_and_both_follow(tmp_path, again):
    text = f"BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\n{again}\nGRID,3,,0.,1.,0.\n"
    tria = "CTRIA3,1,1,1,2,3\n"
    (tmp_path / "a.bdf").write_text(text + tria + tria + "CTRIA3,1,1,1,3,2\n")
    mesh = read_mesh(tmp_path / "a.bdf")
    assert mesh.counts == {"triangle": 2}
    moved = mesh.points + np.array([[0, 0, 0], [0.5, 0, 0], [0, 0, 0]])
    write_mesh(mesh, tmp_path / "b.bdf", moved)
    assert np.array_equal(read_mesh(tmp_path / "b.bdf").points, moved)
    assert (tmp_path / "b.bdf").read_text().count("GRID*") == 2


REPEATED = """BEGIN BULK
GRID,1,,0.,0.,0.
=,*1,=,*1.,== $ to the right
=(2)
GRID          11              0.      1.      0.
=           *(1)       =   *(.5)      ==
=3
CQUAD4,1,1,1,2,12,11
=,*1,=,*1,*1,*1,*1
ENDDATA
"""


def test_repeated_cards_are_written_out_and_only_a_group_that_moves_changes(tmp_path):
    (tmp_path / "a.bdf").write_text(REPEATED)
    mesh = read_mesh(tmp_path / "a.bdf")
    first = [[x, 0, 0] for x in (0, 1, 2, 3)]
    assert mesh.points.tolist() == first + [[x, 1, 0] for x in (0, 0.5, 1, 1.5, 2)]
    assert mesh.cells["quad"].tolist() == [[0, 1, 5, 4], [1, 2, 6, 5]]
    write_mesh(mesh, tmp_path / "b.bdf", mesh.points.copy())
    assert (tmp_path / "b.bdf").read_text() == REPEATED
    for node in (0, 2, 8):
        points = mesh.points.copy()
        points[node] += [1 / 8, 1 / 4, 0]
        write_mesh(mesh, tmp_path / "b.bdf", points)
        again = read_mesh(tmp_path / "b.bdf")
        assert np.array_equal(again.points, points)
        assert again.cells["quad"].tolist() == mesh.cells["quad"].tolist()
        text = (tmp_path / "b.bdf").read_text()
        assert ("=(2)" in text) == (node == 8)
        assert ("=3" in text) == (node != 8)
        assert text.count("GRID*") == 1


@pytest.mark.parametrize("line", ["=,*1,=,*x", "=(99999999999)", "=(2)", "=,*1e"])
def test_lines_that_repeat_what_they_cannot_are_refused(tmp_path, line):
    text = "BEGIN BULK\nGRID,1,,0.,0.,0.\n"
    (tmp_path / "a.bdf").write_text(text + line + "\n")
    with pytest.raises(InputError, match="line 3"):
        read_mesh(tmp_path / "a.bdf")


@pytest.mark.parametrize(
    "where", ["BEGIN BULK\nINCLUDE 'loads.inc'\n", "INCLUDE 'case.inc'\nBEGIN BULK\n"]
)
def test_an_included_file_that_is_not_there_is_told(tmp_path, where):
    nodes = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nCROD,1,1,1,2\n"
    (tmp_path / "a.bdf").write_text(where + nodes)
    with pytest.warns(MeshWarning, match=r"(loads|case)\.inc, which it includes, is not there"):
        mesh = read_mesh(tmp_path / "a.bdf")
    assert mesh.counts == {"line": 1}
    (tmp_path / "a.bdf").write_text(where + nodes.replace("GRID,2,,1.,0.,0.\n", ""))
    with pytest.warns(MeshWarning), pytest.raises(InputError, match="GRID 2, not there"):
        read_mesh(tmp_path / "a.bdf")


def test_superelements_have_numbers_of_their_own(tmp_path):
    part = "GRID,1,,{0}.,0.,0.\nGRID,2,,{0}.,1.,0.\nGRID,3,,{0}.,0.,1.\nCTRIA3,1,1,1,2,3\n"
    text = "BEGIN BULK\n" + part.format(0) + "GRID,9,,9.,9.,9.\nBEGIN SUPER=2\n" + part.format(5)
    (tmp_path / "a.bdf").write_text(text + "BEGIN SUPER=3\nINCLUDE 'b.bdf'\nENDDATA\n")
    (tmp_path / "b.bdf").write_text(part.format(7) + "CROD,2,1,1,9\n")
    mesh = read_mesh(tmp_path / "a.bdf")
    assert mesh.counts == {"triangle": 3, "line": 1}
    x = mesh.points[mesh.cells["triangle"], 0]
    assert x.tolist() == [[0] * 3, [5] * 3, [7] * 3]
    assert mesh.points[mesh.cells["line"][0], 0].tolist() == [7, 9]  # of the main section
    (tmp_path / "out").mkdir()
    write_mesh(mesh, tmp_path / "out" / "a.bdf", mesh.points + 0.5)
    assert np.array_equal(read_mesh(tmp_path / "out" / "a.bdf").points, mesh.points + 0.5)
