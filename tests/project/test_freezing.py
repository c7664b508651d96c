"""Where mesh lies on both sides of a lattice's faces, and the ring where smoothness ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ffdstudio.engine import Lattice
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.project.checks.freezing import crossed_faces, face_names, is_box, suggested
from ffdstudio.project.view.rings import ring
from ffdstudio.project.view.surface import surface_of
from tests.project.scenes import write_cube, write_square


@pytest.fixture
def cube(tmp_path: Path) -> Mesh:
    return read_mesh(write_cube(tmp_path / "cube.su2", 6))


def box(low: object, high: object, shape: tuple[int, ...] = (4, 4, 4)) -> Lattice:
    return Lattice.box(low, high, shape, (2,) * len(shape))


def test_a_lattice_around_everything_crosses_nothing(cube: Mesh) -> None:
    around = box([-0.1] * 3, [1.1] * 3)
    assert crossed_faces(around, cube) == []
    assert suggested(around, [(cube, cube.points)]) == (0, [])


def test_faces_on_the_boundary_of_the_mesh_are_not_crossed(cube: Mesh) -> None:
    half = box([0, 0, 0], [1, 1, 0.5])
    assert crossed_faces(half, cube) == [(2, 1)]
    nearly = box([-1e-12, 0, 0], [1, 1 + 1e-12, 0.5])
    assert crossed_faces(nearly, cube) == [(2, 1)]


def test_a_lattice_in_the_middle_crosses_on_all_sides(cube: Mesh) -> None:
    layers, faces = suggested(box([0.2] * 3, [0.8] * 3), [(cube, cube.points)])
    assert layers == 1
    assert len(faces) == 6


def test_nets_of_two_points_have_nothing_to_freeze(cube: Mesh) -> None:
    small = Lattice.box([0.2] * 3, [0.8] * 3, (2, 2, 2), (1, 1, 1))
    assert suggested(small, [(cube, cube.points)])[0] == 0


def test_a_plane_lattice_has_four_faces(tmp_path: Path) -> None:
    square = read_mesh(write_square(tmp_path / "s.su2"))
    corner = box([-0.1, -0.1], [0.6, 0.6], (4, 4))
    assert crossed_faces(corner, square) == [(0, 1), (1, 1)]
    assert face_names([(0, 1), (1, 1)]) == "i max and j max"


def test_a_body_beside_the_lattice_is_no_reason(cube: Mesh) -> None:
    assert crossed_faces(box([2, 0, 0], [3, 1, 1]), cube) == []


def test_a_turned_lattice_is_judged_in_its_own_frame(cube: Mesh) -> None:
    axes = np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]])
    turned = Lattice.box([-0.1, -0.1, -0.1], [0.5, 1.1, 1.1], (4, 4, 4), (2, 2, 2), axes)
    assert crossed_faces(turned, cube) == [(0, 1)]


def test_a_net_that_is_no_box_is_told() -> None:
    straight = box([0] * 3, [1] * 3)
    assert is_box(straight)
    net = np.array(straight.control_points)
    net[0, 0, 0] -= 0.5
    assert not is_box(straight.moved(net))


def test_the_ring_lies_on_the_faces_of_the_lattice(cube: Mesh) -> None:
    lattice, surface = box([-0.1, -0.1, -0.1], [1.1, 1.1, 0.45]), surface_of(cube)
    rest = cube.points[surface.nodes]
    segments = ring(lattice, surface, rest, rest)
    np.testing.assert_allclose(segments[..., 2], 0.45)
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum()
    assert length == pytest.approx(4)  # once around the cube


def test_there_is_no_ring_where_everything_lies_inside(cube: Mesh) -> None:
    surface = surface_of(cube)
    rest = cube.points[surface.nodes]
    assert len(ring(box([-1] * 3, [2] * 3), surface, rest, rest)) == 0


def test_the_ring_goes_where_the_surface_goes(cube: Mesh) -> None:
    lattice, surface = box([-0.1, -0.1, -0.1], [1.1, 1.1, 0.45]), surface_of(cube)
    rest = cube.points[surface.nodes]
    there = ring(lattice, surface, rest, rest + [5, 0, 0])
    np.testing.assert_allclose(there, ring(lattice, surface, rest, rest) + [5, 0, 0])
