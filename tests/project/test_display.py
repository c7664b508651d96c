"""What is drawn of a mesh, and the coarse proxy of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.meshes import Faces, Mesh, read_mesh
from ffdstudio.project.view.surface import NO_MARKER, DisplaySurface, surface_of
from tests.project.scenes import write_cube, write_square


def area(points: np.ndarray, surface: DisplaySurface) -> np.ndarray:
    """(3,) sum of the vector areas by sign: of each polygon's |area|, for planar polygons."""
    total = np.zeros(3)
    for begin, end in zip(surface.offsets[:-1], surface.offsets[1:], strict=True):
        corners = points[surface.nodes[surface.connectivity[begin:end]]]
        total += np.abs(
            sum(
                np.cross(corners[k] - corners[0], corners[k + 1] - corners[0]) / 2
                for k in range(1, len(corners) - 1)
            )
        )
    return total


def test_the_skin_of_a_volume_is_drawn_with_its_markers(tmp_path: Path) -> None:
    mesh = read_mesh(write_cube(tmp_path / "cube.su2"))
    surface = surface_of(mesh)
    assert surface.has_volume
    assert len(surface.nodes) == 64 - 8
    assert len(surface.offsets) - 1 == 6 * 9
    np.testing.assert_allclose(area(mesh.points, surface), [2, 2, 2])
    assert sorted(surface.markers) == ["high", "low"]
    for name, place in (("low", 0), ("high", 1)):
        number = surface.markers.index(name)
        assert (surface.polygon_marker == number).sum() == 9
        nodes = surface.nodes[surface.marker_points(name)]
        assert np.array_equal(nodes, np.flatnonzero(mesh.points[:, 0] == place))
    assert (surface.polygon_marker == NO_MARKER).sum() == 4 * 9


def test_a_plane_mesh_is_drawn_whole_with_its_boundary_lines(tmp_path: Path) -> None:
    mesh = read_mesh(write_square(tmp_path / "square.su2"))
    surface = surface_of(mesh)
    assert not surface.has_volume
    assert len(surface.nodes) == 25
    assert surface.line_marker.tolist() == [0] * 4
    assert (mesh.points[surface.nodes[surface.lines], 0] == 0).all()


def test_polygons_of_a_face_based_mesh_are_drawn() -> None:
    points = np.random.default_rng(0).random((9, 3))
    faces = Faces(
        np.array([0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 8]),
        np.array([0, 5, 8, 11]),
        np.array([0, 0, 1]),
        np.array([-1, 1, -1]),
    )
    surface = surface_of(Mesh(points, faces=faces))
    assert sorted(np.diff(surface.offsets).tolist()) == [3, 5]
    assert surface.has_volume
    assert surface.nodes.tolist() == [0, 1, 2, 3, 4, 8]


def test_second_order_cells_show_their_corners() -> None:
    mesh = Mesh(np.random.default_rng(0).random((10, 3)), {"tetra10": [list(range(10))]})
    assert surface_of(mesh).nodes.tolist() == [0, 1, 2, 3]


def test_points_without_cells_are_all_drawn() -> None:
    surface = surface_of(Mesh(np.random.default_rng(0).random((5, 3))))
    assert len(surface.nodes) == 5
    assert len(surface.offsets) == 1


def test_a_marker_in_another_order_of_corners_is_recognised() -> None:
    mesh = Mesh(
        np.eye(4)[:, :3],
        {"tetra": [[0, 1, 2, 3]]},
        {"a": {"triangle": [[2, 1, 0]]}, "inner": {"triangle": [[1, 2, 3], [3, 0, 1]]}},
    )
    surface = surface_of(mesh)
    assert np.bincount(surface.polygon_marker + 1).tolist() == [1, 1, 2]


def sphere(n: int) -> Mesh:
    """Triangulated sphere of radius 1 about (5, 0, 0)."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 2 * n), np.linspace(0.01, np.pi - 0.01, n))
    points = np.stack([5 + np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], -1)
    number = np.arange(2 * n * n).reshape(n, 2 * n)
    a, b, c, d = (
        number[i : n - 1 + i, j : 2 * n - 1 + j].ravel()
        for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))
    )
    cells = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    return Mesh(points.reshape(-1, 3), {"triangle": cells})


def test_a_large_surface_gets_a_proxy_of_its_own_points() -> None:
    mesh = sphere(320)
    surface = surface_of(mesh, proxy_above=100_000)
    proxy = surface.proxy
    assert proxy is not None
    assert 15_000 < len(proxy.rows) < 80_000
    points = mesh.points[surface.nodes][proxy.rows]
    corners = points[proxy.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.linalg.norm(normals, axis=1).sum() / 2
    assert abs(total / (4 * np.pi) - 1) < 0.05
    ordered = np.sort(proxy.triangles, axis=1)
    assert len(np.unique(ordered, axis=0)) == len(ordered)
    assert (ordered[:, 1:] != ordered[:, :-1]).all()


def test_small_surfaces_need_no_proxy() -> None:
    assert surface_of(sphere(10)).proxy is None
