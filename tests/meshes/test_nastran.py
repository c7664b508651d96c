"""Nastran: all field widths, promotion of moved nodes, included files, frames."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.formats.grids import sixteen
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
        ("GRID,4,", "GRID,1,", "GRID 1 occurs twice"),
        ("1.D+0", "1.X+0", "line 6: expected a number in a field, found '1.X"),
        (",10,1,2,5", ",10,1,2,6", "an element refers to GRID 6, not there"),
        ("GRID,4,,0.,", "GRID,4,,1e999,", "line 9: expected a number"),
        ("CEND", "INCLUDE 'nowhere.bdf'", "cannot read .*nowhere.bdf"),
        ("CEND", "INCLUDE 'a.bdf'", "included already"),
        ("BEGIN BULK", "GRDSET,,3", "local frame 3"),
        ("*A,-1.5", "*B,-1.5", "line 10: the next line is not the continuation of this card, .A"),
        ("*A,-1.5\n", "", "line 10: the next line is not the continuation"),
        (",10,1,2,5", ",10,1,2", "this element needs 3 nodes"),
        ("CTRIA3", "=,*1,=,=\nCTRIA3", "line 13: cards repeated by '='"),
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
