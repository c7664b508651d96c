"""Normals beside the points: kept as they are, which is said when the points move."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from ffdstudio import read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from tests.meshes.specimens import vtk_grid

PLY = """ply
format ascii 1.0
element vertex 3
property double x
property double y
property double z
property double nx
property double ny
property double nz
element face 1
property list int int vertex_indices
end_header
0 0 0 0 0 1
1 0 0 0 0 1
0 1 0 0 0 1
3 0 1 2
"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"


@pytest.fixture(params=["a.ply", "a.obj", "ascii.vtk", "binary.vtk", "a.vtp"])
def mesh(request, tmp_path):
    path = tmp_path / request.param
    if path.suffix in (".ply", ".obj"):
        path.write_text(PLY if path.suffix == ".ply" else OBJ)
    else:
        skin = vtk_grid().extract_surface(algorithm="dataset_surface")
        skin.compute_normals(split_vertices=False).save(path, binary="ascii" not in path.name)
    return read_mesh(path)


def test_moving_points_says_that_their_normals_stay(mesh, tmp_path):
    target = tmp_path / f"b{mesh.path.suffix}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_mesh(mesh, target)
    assert target.read_bytes() == mesh.path.read_bytes()
    with pytest.warns(MeshWarning, match="normals.* of the file are kept as they were"):
        write_mesh(mesh, target, mesh.points + 0.5)
    assert np.array_equal(read_mesh(target).points, mesh.points + 0.5)
