"""A plane through a volume: what it cuts lies on it and has the area it should have."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6")

from ffdstudio.gui.actors.section import cut
from ffdstudio.gui.first_view import first_bounds
from ffdstudio.meshes import Faces, Mesh
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.project.view.surface import surface_of

NORMALS = [np.eye(3)[0], np.eye(3)[2], np.array([1.0, 2, 3]) / np.sqrt(14)]


def block(n):
    """Points and hexahedra of a unit cube."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1)] * 3, indexing="ij"), -1)
    number = np.arange((n + 1) ** 3).reshape((n + 1,) * 3)
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = [
        [number[i + a, j + b, k + c] for c in (0, 1) for a, b in square]
        for i, j, k in np.ndindex(n, n, n)
    ]
    return grid.reshape(-1, 3), np.array(cells)


def area(found):
    total = np.zeros(3)
    for a, b in zip(found.offsets[:-1], found.offsets[1:], strict=True):
        p = found.points[found.connectivity[a:b]]
        total += abs(np.cross(p[1:-1] - p[0], p[2:] - p[0]).sum(axis=0) / 2)
    return np.linalg.norm(total)


@pytest.mark.parametrize("normal", NORMALS)
def test_the_cut_of_a_block_lies_in_the_plane_and_has_its_area(normal):
    points, cells = block(3)
    origin = np.array([0.52, 0.47, 0.51])
    found = cut(Mesh(points, {"hexahedron": cells}), points, origin, normal)
    assert np.abs((found.points - origin) @ normal).max() < 1e-6
    axis = normal.max() == 1
    if axis:
        assert area(found) == pytest.approx(1.0, rel=1e-5)
    else:
        assert area(found) > 1.0


def test_a_face_based_mesh_is_cut_into_the_outlines_of_its_cells():
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    points = np.array(list(np.ndindex(2, 2, 2)), dtype=float)
    nodes = np.array(quads).ravel()
    offsets = np.arange(0, 25, 4)
    faces = Faces(nodes, offsets, np.zeros(6, dtype=int), np.full(6, -1))
    mesh = Mesh(points, faces=faces)
    found = cut(mesh, points, np.array([0.25, 0.5, 0.5]), np.eye(3)[0])
    ends = found.points[found.lines]
    assert len(ends) == 4  # a square
    assert (found.points[:, 0] == 0.25).all()
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(4.0)


def test_a_plane_beside_the_mesh_cuts_nothing():
    points, cells = block(1)
    found = cut(Mesh(points, {"hexahedron": cells}), points, np.array([9.0, 0, 0]), np.eye(3)[0])
    assert len(found.points) == 0


def test_walls_are_the_markers_that_are_small_beside_the_mesh(root):
    from ffdstudio.meshes import read_mesh

    mesh = read_mesh(root / "sample_meshes" / "naca0012.su2")
    surface = surface_of(mesh)
    points = mesh.points[surface.nodes]
    assert wall_markers(mesh) == ("airfoil",)
    low, high = first_bounds(surface, points, mesh)
    assert low[0] < 0 < 1 < high[0] < 2
    assert wall_markers(Mesh(*_marked_cube())) == ()


def _marked_cube():
    points, cells = block(2)
    return points, {"hexahedron": cells}
