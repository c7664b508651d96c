"""Fluent: faces become cells with the right side out, and damage is named."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from tests.meshes.specimens import SPECIMENS


@pytest.fixture
def block(tmp_path):
    SPECIMENS["block_fluent.msh"](tmp_path / "block.msh")
    return tmp_path / "block.msh"


def test_normals_of_boundary_faces_point_out_of_the_block(block):
    mesh = read_mesh(block)
    assert mesh.counts == {"hexahedron": 12}
    assert mesh.kinds == {"outside": "wall"}
    quads = mesh.markers["outside"]["quad"]
    corners = mesh.points[quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    # the divergence theorem: the flux of x through the closed surface is three times the volume
    volume = (corners.mean(axis=1) * normal).sum() / 6
    assert volume == pytest.approx(3 * 2 / 3 * 2 / 7, rel=0.05)


def test_a_plane_mesh_has_anticlockwise_cells_of_the_whole_area(shared):
    mesh = read_mesh(shared / "meshes" / "fluent" / "elbow.msh")
    assert mesh.counts == {"triangle": 918}
    x, y, _ = mesh.points[mesh.cells["triangle"]].transpose(2, 0, 1)
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2
    assert (area > 0).all()
    lines = np.concatenate([cells["line"] for cells in mesh.markers.values()])
    (ax, ay), (bx, by) = mesh.points[lines[:, 0], :2].T, mesh.points[lines[:, 1], :2].T
    assert abs((ax * by - ay * bx).sum() / 2) == pytest.approx(area.sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("(2 3)", "(2 4)", "line 2: the dimension must be 2 or 3"),
        ("(10 (8 b", "(10 (8 c", "do not follow those before"),
        ("\n0.0 ", "\nnan ", "a number is not finite"),
        ("(45 (4 wall", "(2010 (4 wall", "binary Fluent meshes are not supported"),
        ("\n4 ", "\n5 ", "faces announced"),
        ("(45 (4 wall outside)())", "(45 (4 wall outside)()", "a section does not end"),
        (" 0 1\n", " 0 0\n", "a face without cells"),
        (" 0 1\n", " 0 fff\n", "cannot be there"),
        (" 0 1\n", " 0 g\n", "not a hexadecimal number"),
    ],
)
def test_damage_is_refused_with_place_and_cause(block, old, new, cause):
    text = block.read_text()
    assert old in text
    block.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=cause):
        read_mesh(block)
