"""No cell goes unseen: a cell that is turned inside out is counted, or said to be unchecked."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ffdstudio.cli.main import main
from ffdstudio.meshes import (
    Mesh,
    coverage,
    inverted,
    quality,
    read_mesh,
    safe_amplitude,
    write_mesh,
)
from ffdstudio.meshes.measures.cell_coverage import Coverage, together
from tests.meshes.cell_files import (
    ABAQUS,
    NASTRAN,
    STRIPS,
    VTK_KINDS,
    abaqus,
    cgns_polyhedra,
    nastran,
    vtk_file,
)

MIRROR = np.array([-1.0, 1.0, 1.0])


def seen_or_said(mesh: Mesh) -> bool:
    """Whether turning the whole mesh inside out is noticed, in every way that is asked for it."""
    bad, step = mesh.points * MIRROR, mesh.points * (MIRROR - 1)
    counted = inverted(mesh, bad).count
    limit = safe_amplitude(mesh, step)
    missing = coverage(mesh).missing
    assert (counted > 0) == np.isfinite(limit)
    assert not counted or limit == pytest.approx(0.5)
    return counted + missing > 0


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
@pytest.mark.parametrize("number", VTK_KINDS)
@pytest.mark.parametrize("suffix", ["vtu", "vtk"])
def test_a_cell_of_vtk_turned_inside_out_is_seen(tmp_path, suffix, number):
    path = vtk_file(tmp_path / f"one.{suffix}", number)
    mesh = read_mesh(path)
    assert sum(coverage(mesh).checked.values()) + coverage(mesh).missing == 1
    assert seen_or_said(mesh)


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
@pytest.mark.parametrize("kind", ABAQUS)
def test_an_element_of_abaqus_turned_inside_out_is_seen(tmp_path, kind):
    mesh = read_mesh(abaqus(tmp_path / "one.inp", kind))
    assert seen_or_said(mesh)


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
@pytest.mark.parametrize("card", NASTRAN)
def test_a_card_of_nastran_turned_inside_out_is_seen(tmp_path, card):
    mesh = read_mesh(nastran(tmp_path / "one.bdf", card))
    assert seen_or_said(mesh)


@pytest.mark.parametrize("name", STRIPS)
def test_triangles_of_strips_all_look_the_same_way(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(STRIPS[name])
    mesh = read_mesh(path)
    assert mesh.counts == {"triangle": 3}
    rows = mesh.points[mesh.cells["triangle"]]
    assert (np.cross(rows[:, 1] - rows[:, 0], rows[:, 2] - rows[:, 0])[:, 2] > 0).all()
    assert seen_or_said(mesh)


def unseen_deck(tmp_path):
    """A hexahedron beside an element that is not known here, and a lattice around them."""
    deck = nastran(tmp_path / "deck.bdf", "CHEXA", more="CHEXOTIC,9,1,1,2,3,4\n")
    lattice = tmp_path / "box.lattice.json"
    assert main(["lattice", str(deck), "--shape", "3", "3", "3", "-o", str(lattice)]) == 0
    return deck, lattice


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
def test_morph_says_what_it_did_not_check_and_exits_1(tmp_path, capsys):
    deck, lattice = unseen_deck(tmp_path)
    capsys.readouterr()
    command = ["morph", str(deck), str(lattice), "-o", str(tmp_path / "out.bdf")]
    command += ["--move", "1,1,1=0.01,0,0", "--frozen", "0"]
    assert main(command) == 1
    line = capsys.readouterr().out
    assert "1 cell not checked (1 CHEXOTIC)" in line
    assert "safe at any multiple" not in line
    assert main([*command, "--allow-unchecked", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["unchecked"] == 1
    assert told["unchecked_types"] == {"CHEXOTIC": 1}


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
def test_morph_that_moves_nothing_needs_no_check(tmp_path):
    deck, lattice = unseen_deck(tmp_path)
    assert main(["morph", str(deck), str(lattice), "-o", str(tmp_path / "out.bdf")]) == 0


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
def test_quality_and_info_name_what_was_not_checked(tmp_path, capsys):
    deck, _ = unseen_deck(tmp_path)
    capsys.readouterr()
    assert main(["quality", str(deck)]) == 0
    assert "1 cell not checked (1 CHEXOTIC)" in capsys.readouterr().out
    assert main(["info", str(deck)]) == 0
    assert "unchecked  CHEXOTIC 1" in capsys.readouterr().out
    assert quality(read_mesh(deck)).coverage.unchecked == {"CHEXOTIC": 1}


def test_coverage_adds_up():
    both = together([Coverage({"tetra": 2}, {}), Coverage({"tetra": 1}, {"CSHEAR": 1})])
    assert both == Coverage({"tetra": 3}, {"CSHEAR": 1})
    assert together([]).missing == 0


@pytest.mark.parametrize("offsets", [True, False])
def test_polyhedra_of_cgns_are_read_and_checked(tmp_path, offsets):
    mesh = read_mesh(cgns_polyhedra(tmp_path / "two.cgns", offsets))
    assert mesh.counts == {"hexahedron": 2}
    assert mesh.marker_counts == {"hull": 1}
    assert sum(map(len, mesh.surface().values())) == 10
    assert coverage(mesh).missing == 0
    assert inverted(mesh, mesh.points * MIRROR).count == 2
    moved = mesh.with_points(mesh.points + [0, 0, 0.25])
    write_mesh(moved, tmp_path / "out.cgns")
    assert (read_mesh(tmp_path / "out.cgns").points == moved.points).all()
