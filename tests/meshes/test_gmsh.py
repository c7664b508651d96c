"""Gmsh: elements in several groups, meshes that are partitioned."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.pairs import pairs_of
from tests.meshes.gmsh_specimens import gmsh_box
from tests.meshes.oracles import with_gmsh, with_meshio
from tests.meshes.specimens import SPECIMENS


@pytest.mark.parametrize("binary", [False, True])
def test_an_element_of_two_groups_is_one_cell_in_both(tmp_path, binary):
    gmsh_box(tmp_path / "new.msh", 4.1, binary, groups=2)
    gmsh_box(tmp_path / "old.msh", 2.2, binary, groups=2)
    new, old = read_mesh(tmp_path / "new.msh"), read_mesh(tmp_path / "old.msh")
    assert old.counts == new.counts
    assert old.marker_counts == new.marker_counts
    assert old.marker_counts["air"] == old.marker_counts["fluid"] == old.counts["tetra10"]


@pytest.mark.parametrize("binary", [False, True])
def test_a_partitioned_mesh_keeps_its_groups(tmp_path, binary):
    gmsh_box(tmp_path / "whole.msh", 4.1, binary)
    gmsh_box(tmp_path / "parts.msh", 4.1, binary, partitions=3)
    whole, parts = read_mesh(tmp_path / "whole.msh"), read_mesh(tmp_path / "parts.msh")
    assert set(whole.marker_counts.items()) <= set(parts.marker_counts.items())
    assert parts.counts == whole.counts


PERIODIC = ["v22_periodic.msh", "v22_periodic_binary.msh", "v40_periodic.msh"]
PERIODIC += ["v41_periodic.msh", "v41_periodic_binary.msh"]


@pytest.mark.parametrize("name", PERIODIC)
def test_entities_that_gmsh_pairs_are_partners_under_their_names(tmp_path, name):
    SPECIMENS[name](tmp_path / name)
    mesh = read_mesh(tmp_path / name)
    [pair] = pairs_of(mesh)
    assert pair.names == ("left", "right")
    assert set(pair.first) == set(mesh.marker_nodes("left"))
    assert set(pair.second) == set(mesh.marker_nodes("right"))
    assert np.abs(mesh.points[pair.second] - mesh.points[pair.first] - [1, 0, 0]).max() < 1e-12
    bent = mesh.points + [0, 0.1, 0] * (mesh.points[:, :1] > 0.99)
    assert broken(mesh, mesh.points + [0.5, 0.25, 0]) == []
    assert "left and right no longer match" in " ".join(broken(mesh, bent))


def test_a_damaged_section_of_pairs_is_refused(tmp_path):
    SPECIMENS["v22_periodic.msh"](tmp_path / "a.msh")
    text = (tmp_path / "a.msh").read_text()
    for old, new in (("2 2 1\n", "2 2 x\n"), ("2 2 1\n", "2 2\n"), ("Affine", "99999999")):
        (tmp_path / "a.msh").write_text(text.replace(old, new, 1))
        with pytest.raises(InputError):
            read_mesh(tmp_path / "a.msh")


def test_gmsh_reads_as_many_nodes_and_cells_of_version_4_0(tmp_path):
    counts = []
    for name in ("v41.msh", "v40.msh", "v40_binary.msh"):
        SPECIMENS[name](tmp_path / name)
        mesh = read_mesh(tmp_path / name)
        counts.append((len(mesh.points), mesh.counts, mesh.marker_counts))
        reader = with_meshio if "binary" in name else with_gmsh
        assert len(reader(tmp_path / name)) == len(mesh.points)
    assert counts[0] == counts[1] == counts[2]
