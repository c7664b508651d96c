"""The live guard against the safe amplitude, and its limits against full reports."""

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, inverted, quality, safe_amplitude
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.safety import PRESETS, Guard, Limits
from ffdstudio.meshes.safety.halfspaces import Region
from tests.meshes.shapes import UNIT, block, crowd, in_plane


def bump(points, centre, radius):
    """Smooth influence around a place, as a control point has it."""
    r = np.linalg.norm((points - centre) / radius, axis=1)
    return np.where(r < 1, (1 - np.minimum(r, 1) ** 2) ** 3, 0.0)


def agree(mesh, influence, count, start=None):
    rows = np.flatnonzero(influence)
    points = mesh.points if start is None else start
    guard = Guard(mesh, points, influence[rows], rows)
    for direction in in_plane(mesh, np.random.default_rng(0).normal(size=(count, 3))):
        expected = safe_amplitude(mesh, influence[:, None] * direction, points)
        assert guard.limit(direction) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("kind", UNIT)
def test_it_agrees_with_the_safe_amplitude_for_every_cell_type(kind):
    mesh = crowd(kind, count=200, distortion=0.2)
    agree(mesh, np.random.default_rng(1).uniform(0, 1, len(mesh.points)), 30)


@pytest.mark.parametrize("kind", ["triangle", "quad"])
def test_it_agrees_on_surfaces_in_space(kind):
    mesh = crowd(kind, count=100, surface=True)
    agree(mesh, np.random.default_rng(1).uniform(0, 1, len(mesh.points)), 30)


def test_it_agrees_along_a_thousand_directions():
    points, cells = block(4, 4, 4)
    rng = np.random.default_rng(0)
    tets = cells[:, [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6]]]
    mesh = Mesh(points + 0.03 * rng.normal(size=points.shape), {"tetra": tets.reshape(-1, 4)})
    agree(mesh, bump(mesh.points, [0.4, 0.5, 0.6], 0.7), 1000)


def test_it_agrees_from_a_deformed_start_and_for_polyhedra():
    points, cells = block(4, 3, 3)
    listed = Mesh(points, {"hexahedron": cells})
    faced = Mesh(points, faces=topology_of(listed).faces)
    start = points + 0.05 * np.sin(5 * points[:, [1, 2, 0]])
    for mesh in (listed, faced):
        agree(mesh, bump(points, [0.5, 0.5, 0.5], 0.6), 20, start)


def test_it_agrees_on_real_meshes(shared):
    for name, centre in (
        ("su2/mesh_NACA0012_inv", (0.5, 0.06, 0)),
        ("wing/oneram6_tets", (0.5,) * 3),
    ):
        mesh = ffd.read_mesh(shared / f"meshes/{name}.su2")
        agree(mesh, bump(mesh.points, centre, 0.5), 20)


def test_a_drag_of_the_engine_is_guarded_by_its_influence():
    points, cells = block(6, 5, 4)
    mesh = Mesh(points, {"hexahedron": cells})
    lattice = ffd.Lattice.around(points, shape=(5, 4, 4))
    drag = ffd.embed(lattice, points).drag(lattice, [np.ravel_multi_index((2, 1, 2), (5, 4, 4))])
    guard = Guard(mesh, points, drag.influence, drag.rows)
    for direction in np.eye(3):
        limit = guard.limit(direction)
        for factor, bad in ((0.999, False), (1.001, True)):
            moved = points.copy()
            drag.move(factor * limit * direction, moved)
            assert (inverted(mesh, moved).count > 0) == bad


def test_an_allowed_drag_is_left_alone_and_a_longer_one_shortened():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    guard = Guard(mesh, mesh.points, [0.5], [2])
    assert guard.allowed([0, -3, 0]).tolist() == [0, -3, 0]
    assert guard.allowed([0, -8, 0]) == pytest.approx([0, -4, 0], rel=2e-3)
    stop = guard.stop([0, -1, 0])
    assert (stop.reason, stop.cell) == ("inversion", 0)
    assert guard.stop([0, 1, 0]).amplitude == np.inf


def test_nothing_that_counts_is_dropped_from_a_region():
    rng = np.random.default_rng(0)
    for spread in ([1, 1, 1], [1, 1, 0], [1, 0, 0], [1, 1e-3, 1e-6]):
        vectors = rng.normal(size=(60_000, 3)) * spread + [0.5, 0, 0]
        region = Region()
        for part in np.array_split(vectors, 7):
            region.add(part, np.arange(len(part)))
        region.thin()
        for direction in rng.normal(size=(50, 3)):
            expected = max(float((vectors @ direction).max()), 0.0)
            assert region.steepest(direction)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("limits", "name"),
    [
        (Limits(non_orthogonality=40.0), "non_orthogonality"),
        (Limits(face_skewness=0.5), "face_skewness"),
        (Limits(first_layer=0.05), "first_layer"),
    ],
)
def test_limits_of_the_solver_are_where_a_full_report_finds_them(limits, name):
    points, cells = block(6, 5, 4)
    low = points[cells[:, :4]][..., 2].max(axis=1) == 0
    wall = {"wall": {"quad": cells[low][:, :4]}}
    mesh = Mesh(points, {"hexahedron": cells}, wall)
    influence = bump(points, [0.5, 0.5, 0.0], 0.8)
    rows = np.flatnonzero(influence)
    guard = Guard(mesh, points, influence[rows], rows, limits)
    direction = np.array([0.3, 0.2, 1.0])
    stop = guard.stop(direction)
    assert stop.reason == name
    assert 0 < stop.amplitude < Guard(mesh, points, influence[rows], rows).limit(direction)
    for factor, bad in ((0.99, False), (1.01, True)):
        report = quality(mesh, points + factor * stop.amplitude * influence[:, None] * direction)
        measures = report.measures
        beyond = {
            "non_orthogonality": measures["non_orthogonality"] > 40,
            "face_skewness": measures["face_skewness"] > 0.5,
            "first_layer": np.abs(measures["first_layer_ratio"] - 1) > 0.05,
        }
        assert beyond[name].any() == bad


def test_what_is_beyond_a_limit_already_does_not_forbid_every_move():
    points, cells = block(4, 4, 4)
    points[:, 0] += 3 * points[:, 2]  # 71.6 degrees
    mesh = Mesh(points, {"hexahedron": cells})
    influence = bump(points, points.mean(axis=0), [3, 0.6, 0.6])
    rows = np.flatnonzero(influence)
    guard = Guard(mesh, points, influence[rows], rows, PRESETS["OpenFOAM"])
    assert guard.limit([0, 0, 1]) > 0


def test_arrays_that_do_not_fit_are_refused():
    mesh = crowd("tetra", count=2)
    for influence, rows in (([1.0], [0, 1]), ([1.0], [99]), ([np.nan], [0])):
        with pytest.raises(InputError):
            Guard(mesh, mesh.points, influence, rows)
