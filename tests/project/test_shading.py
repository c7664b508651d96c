"""Normals, looks and what hides a control point: plain arrays, no window."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.project.commands import CreateBox
from ffdstudio.project.interaction.occlusion import Occluders
from ffdstudio.project.view.camera import Camera
from ffdstudio.project.view.looks import LOOKS, curvature, displacement, rounded_up
from ffdstudio.project.view.shading import face_vectors, shading_of
from tests.project.scenes import opened, write_cube


def sphere(n: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Points and (t, 3) triangles of a unit sphere, normals outwards."""
    from scipy.spatial import ConvexHull

    k = np.arange(n * n) + 0.5
    polar, turn = np.arccos(1 - 2 * k / (n * n)), np.pi * (1 + 5**0.5) * k
    points = np.column_stack(
        [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)]
    )
    triangles = ConvexHull(points).simplices.astype(np.int64)
    out = np.einsum(
        "ij,ij->i",
        np.cross(
            points[triangles[:, 1]] - points[triangles[:, 0]],
            points[triangles[:, 2]] - points[triangles[:, 0]],
        ),
        points[triangles].mean(axis=1),
    )
    triangles[out < 0] = triangles[out < 0][:, ::-1]
    return points, triangles


def shaded(points, triangles, degrees=30.0):
    return shading_of(points, triangles.ravel(), np.arange(0, triangles.size + 1, 3), degrees)


@pytest.mark.parametrize("centre", [0.0, 1e7])
def test_normals_of_a_sphere_point_away_from_its_centre_wherever_it_is(centre):
    points, triangles = sphere()
    shading = shaded(points + centre, triangles)
    assert len(shading.rows) == len(points)
    normals = shading.normals(points + centre)
    assert np.einsum("ij,ij->i", normals, points[shading.rows]).min() > 0.99


def test_normals_follow_where_the_points_go():
    points, triangles = sphere()
    shading = shaded(points, triangles)
    flat = points * [1, 1, 0.2]
    exact = flat / [1, 1, 0.2] ** np.array(2)  # gradient of the ellipsoid
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", shading.normals(flat), exact[shading.rows]).min() > 0.98


def test_a_cube_keeps_its_edges_and_a_fan_of_ten_degrees_does_not():
    quads = np.array(
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    )
    corner = np.array([[x, y, z] for z in (0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    cube = shading_of(corner, quads.ravel(), np.arange(0, 25, 4))
    assert len(cube.rows) == 24
    assert np.allclose(np.abs(cube.normals(corner)).max(axis=1), 1)
    angle = np.radians(np.arange(0, 90, 10))
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    points = np.concatenate([rim, rim + [0, 0, 1]])
    k, n = np.arange(len(angle) - 1), len(angle)
    strip = np.column_stack([k, k + 1, k + 1 + n, k + n])
    shading = shading_of(points, strip.ravel(), np.arange(0, strip.size + 1, 4))
    assert len(shading.rows) == len(points)


def test_polygons_and_faces_without_area_are_taken():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 0, 0.0]])
    connectivity, offsets = np.array([0, 1, 2, 3, 1, 4, 5]), np.array([0, 4, 7])
    assert np.allclose(face_vectors(points, connectivity, offsets), [[0, 0, 2], [0, 0, 0]])
    assert np.isfinite(shading_of(points, connectivity, offsets).normals(points)).all()


@pytest.mark.parametrize("radius", [0.5, 2.0])
def test_the_mean_curvature_of_a_sphere_is_one_over_its_radius(radius):
    points, triangles = sphere()
    shading = shaded(points, triangles)
    found = curvature(points, radius * points, shading)
    assert np.median(found) == pytest.approx(1 / radius, rel=0.05)


def test_displacement_and_the_ends_of_scales():
    rest = np.zeros((3, 3))
    assert displacement(rest, rest + [0, 0, 2], None).tolist() == [2, 2, 2]
    assert [rounded_up(v) for v in (0.02, 0.021, 7, 1e-9, np.nan)] == [0.02, 0.05, 10, 1e-9, 0]
    assert LOOKS["displacement"].limit(np.array([0.0, 0.3])) == 0.5
    assert LOOKS["curvature"].limit(np.zeros(0)) == 0


# ---- what hides ---------------------------------------------------------------------------------


def looking_down(scale: float = 0.5) -> Camera:
    """From above along -z, (0.5, 0.5) in the middle of 200 x 200 pixels."""
    matrix = np.diag([scale, scale, -0.1, 1.0])
    matrix[:3, 3] = [-0.5 * scale, -0.5 * scale, 0]
    return Camera(matrix, 200, 200)


def test_points_behind_a_cube_are_hidden_and_those_before_or_beside_it_are_not(tmp_path):
    document = opened(write_cube(tmp_path / "cube.su2"))
    occluders = Occluders(document)
    points = np.array([[0.5, 0.5, 2], [0.5, 0.5, -1], [0.5, 0.5, 1.0], [1.5, 0.5, -1.0]])
    assert occluders.hidden(looking_down(), points).tolist() == [False, True, False, False]
    camera = Camera(np.asarray(looking_down().matrix) * [[1], [1], [-1], [1]], 200, 200)
    assert occluders.hidden(camera, points).tolist() == [True, False, True, False]


def test_of_two_points_over_one_another_the_one_that_is_seen_is_taken(tmp_path):
    from ffdstudio.project.interaction.events import PointerEvent
    from ffdstudio.project.interaction.tools import Tools

    box = CreateBox("Box", (-0.5, -0.5, -0.5), (1.5, 1.5, 1.5), (3, 3, 3), (2, 2, 2))
    document = opened(write_cube(tmp_path / "cube.su2"), box)
    tools = Tools(document)
    camera = looking_down()
    x, y = camera.project([[0.5, 0.5, 1.5]])[0]
    assert tools.hit(PointerEvent("move", camera, x, y)) == (1, 1, 2)
    edit = document.edit([(1, 1, 2)])
    edit.translate([0.08, 0, -2.5])  # now nearer to nothing: behind the cube
    edit.commit()
    x, y = camera.project([[0.54, 0.5, 0]])[0]
    hit = tools.hit(PointerEvent("move", camera, x, y))
    assert hit is not None  # points that are hidden can still be had where none is seen
