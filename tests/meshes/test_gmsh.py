"""Gmsh: elements in several groups, meshes that are partitioned."""

from __future__ import annotations

import pytest

from ffdstudio import read_mesh
from tests.meshes.gmsh_specimens import gmsh_box


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
