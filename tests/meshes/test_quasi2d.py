"""Meshes one cell deep stand for plane ones, in whatever format they come."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.meshes import Mesh, MeshWarning, read_mesh, write_mesh
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.meshes.quasi2d import is_plane, outlines, plane_axes, slab_of
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.optimize.geometry.profiles import profiles
from ffdstudio.project.placing.placement import Site, placed

LEVELS = 7


def ring(points: int = 21) -> np.ndarray:
    """(LEVELS, n, 2) O-grid around NACA 0012: from the wall to a circle."""
    wall = naca4("0012", points)[:-1]
    angle = np.arctan2(wall[:, 1], wall[:, 0] - 0.5)
    far = 20 * np.column_stack([np.cos(angle), np.sin(angle)]) + [0.5, 0]
    t = np.linspace(0, 1, LEVELS)[:, None, None] ** 2
    return wall + t * (far - wall)


def slab(deep: float = 0.1, kinds: dict[str, str] | None = None, turn=((0, 1, 2), 1), side="sides"):
    """One-cell-deep hexahedra around an airfoil; `turn` gives the axes of section and depth."""
    grid = ring()
    n = grid.shape[1]
    flat = grid.reshape(-1, 2)
    local = np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in (0.0, deep)])
    points = np.zeros_like(local)
    points[:, list(turn[0])] = local
    at = np.arange(LEVELS * n).reshape(LEVELS, n)
    a, b = at[:-1], np.roll(at, -1, axis=1)[:-1]
    c, d = np.roll(at, -1, axis=1)[1:], at[1:]
    low = np.stack([x.ravel() for x in (a, b, c, d)], axis=1)
    cells = np.hstack([low, low + LEVELS * n])
    quads = np.stack([x.ravel() for x in (a, b, c, d)], axis=1)
    wall = np.stack([at[0], np.roll(at[0], -1)], axis=1)
    far = np.stack([at[-1], np.roll(at[-1], -1)], axis=1)
    up = lambda edge: np.hstack([edge, edge[:, ::-1] + LEVELS * n])  # noqa: E731
    markers = {
        side: {"quad": np.vstack([quads, quads + LEVELS * n])},
        "airfoil": {"quad": up(wall)},
        "farfield": {"quad": up(far)},
    }
    return Mesh(points, {"hexahedron": cells}, markers, kinds=kinds or {})


@pytest.mark.parametrize(
    ("turn", "axes"),
    [
        (((0, 1, 2), 1), [[1, 0, 0], [0, 1, 0]]),
        (((0, 2, 1), 1), [[1, 0, 0], [0, 0, 1]]),
        (((1, 2, 0), 1), [[0, 1, 0], [0, 0, 1]]),
    ],
)
@pytest.mark.parametrize("told", [True, False], ids=["kind", "name"])
def test_a_section_with_empty_sides_is_plane_whatever_axis_it_is_deep_along(turn, axes, told):
    side = "patch0" if told else "frontAndBack"
    mesh = slab(kinds={side: "empty"} if told else None, turn=turn, side=side)
    found = slab_of(mesh)
    assert is_plane(mesh)
    assert np.array_equal(plane_axes(mesh), axes)
    assert len(found.front) == len(mesh.points) // 2
    assert wall_markers(mesh) == ("airfoil",)
    assert {name: len(lines) for name, lines in outlines(mesh).items()} == {
        "airfoil": 40,
        "farfield": 40,
    }
    [profile] = profiles(mesh)
    assert profile.marker == "airfoil"
    contour = profile.local(mesh.points[profile.nodes])[:, :2]
    assert np.allclose(np.sort(contour[:, 0]), np.sort(naca4("0012", 21)[:, 0]), atol=1e-12)


def test_its_lattice_has_two_directions_and_moves_both_sides_alike():
    mesh = slab(turn=((0, 2, 1), 1), side="symmetry")
    site = Site.of_mesh(mesh, ["airfoil"])
    found = placed(site, (6, 4))
    assert np.array_equal(found.lattice.axes, [[1, 0, 0], [0, 0, 1]])
    from ffdstudio.engine import embed

    net = found.lattice.control_points.copy()
    net[2, 2] += [0.01, 0, 0.05]
    moved = embed(found.lattice, mesh.points).deform(found.lattice.moved(net))
    assert np.array_equal(moved[:, 1], mesh.points[:, 1])
    half = len(mesh.points) // 2
    assert np.array_equal(moved[:half, [0, 2]], moved[half:, [0, 2]])
    assert np.abs(moved - mesh.points).max() > 0.01
    assert found.reach(site) > 0.02


def test_two_cells_deep_a_wide_block_and_a_surface_are_not_plane():
    mesh = slab(side="symmetry")
    deeper = np.array(mesh.points)
    deeper[0, 2] = 0.05  # a node between the sides
    assert slab_of(mesh.with_points(deeper)) is None
    assert slab_of(slab(deep=60.0, side="symmetry")) is None
    assert slab_of(slab(side="skin")) is None  # nothing says that its sides have to stay plane
    corners = mesh.points[:4]
    assert slab_of(Mesh(corners, {"quad": [[0, 1, 2, 3]]})) is None
    assert not is_plane(read_mesh_of_wing())


def read_mesh_of_wing():
    from ffdstudio.samples import sample

    return read_mesh(sample("wing_air.su2"))


def test_the_names_of_boundaries_carry_the_plane_through_a_file(tmp_path):
    with pytest.warns(MeshWarning):
        write_mesh(slab(side="symmetry"), tmp_path / "slab.su2")
    again = read_mesh(tmp_path / "slab.su2")
    assert is_plane(again)
    assert [profile.marker for profile in profiles(again)] == ["airfoil"]


def test_a_wedge_counts_as_plane():
    mesh = slab(deep=1.0, side="wedge")
    points = np.array(mesh.points)
    points[:, 1] += 30  # away from the axis
    points[:, 2] = np.where(points[:, 2] > 0.5, 1, -1) * points[:, 1] * np.tan(np.radians(2.5))
    wedge = Mesh(points, mesh.cells, mesh.markers, kinds={"wedge": "wedge"})
    found = slab_of(wedge)
    assert found is not None
    assert found.wedge
    assert np.allclose(found.normal, [0, 0, 1])
