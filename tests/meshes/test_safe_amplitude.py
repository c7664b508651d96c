"""The safe amplitude against bisection with the count of inverted cells."""

from fractions import Fraction

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, inverted, safe_amplitude
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.safety.roots import smallest
from tests.meshes.shapes import CUBE, UNIT, block, crowd, in_plane


def bisected(mesh, move, high, steps=50):
    """First amplitude with an inverted cell, if `high` has one and all below it have too."""
    low = 0.0
    for _ in range(steps):
        middle = (low + high) / 2
        if inverted(mesh, mesh.points + middle * move).count:
            high = middle
        else:
            low = middle
    return high


def check(mesh, move):
    limit = safe_amplitude(mesh, move)
    assert np.isfinite(limit)
    assert limit == pytest.approx(bisected(mesh, move, 1.01 * limit), rel=1e-6)
    assert inverted(mesh, mesh.points + 0.999 * limit * move).count == 0
    assert inverted(mesh, mesh.points + 1.001 * limit * move).count >= 1
    for fraction in (0.25, 0.5, 0.9):
        assert inverted(mesh, mesh.points + fraction * limit * move).count == 0


@pytest.mark.parametrize("surface", [False, True])
@pytest.mark.parametrize("kind", UNIT)
def test_it_equals_bisection_for_every_cell_type(kind, surface):
    if surface and kind not in ("triangle", "quad"):
        pytest.skip("only plane cells form surfaces")
    for seed in range(3):
        mesh = crowd(kind, count=100, seed=seed, surface=surface)
        move = np.random.default_rng(seed).normal(size=mesh.points.shape)
        check(mesh, in_plane(mesh, move))


def test_it_equals_bisection_for_polyhedra(root):
    data = np.load(root / "tests/meshes/data/checkmesh_hexahedra.npz")
    points, cells = block(3, 3, 2)
    faced = Mesh(points, faces=topology_of(Mesh(points, {"hexahedron": cells})).faces)
    check(faced, np.random.default_rng(0).normal(size=points.shape))
    data = np.load(root / "tests/meshes/data/checkmesh_polyhedra.npz")
    faces = ffd.meshes.Faces(*(data[k].astype(int) for k in NAMES))
    mesh = Mesh(data["points"], faces=faces)
    check(mesh, 0.01 * np.random.default_rng(1).normal(size=mesh.points.shape))


NAMES = ("nodes", "offsets", "owner", "neighbour")


def test_a_hexahedron_that_folds_inside_first_ends_the_amplitude_there():
    inside = 0
    for seed in range(120):
        rng = np.random.default_rng(seed)
        kind = "hexahedron" if seed % 3 else "wedge"
        points = UNIT[kind] + rng.uniform(-0.3, 0.3, UNIT[kind].shape)
        mesh = Mesh(points, {kind: [np.arange(len(points))]})
        move = rng.normal(size=points.shape)
        limit = safe_amplitude(mesh, move)
        if np.isfinite(limit) and limit > 0:
            after = inverted(mesh, points + 1.001 * limit * move)
            assert after.count == 1
            assert inverted(mesh, points + 0.999 * limit * move).count == 0
            inside += after.corners == 0
    assert inside > 2


@pytest.mark.parametrize(
    "name",
    [
        "su2/mesh_NACA0012_inv.su2",
        "su2/mesh_RAE2822_turb_ffd.su2",
        "su2/mesh_brick_prism_ffd.su2",
        "wing/oneram6_tets.su2",
    ],
)
def test_it_equals_bisection_on_real_meshes(shared, name):
    mesh = ffd.read_mesh(shared / "meshes" / name)
    move = 0.1 * np.sin(3 * mesh.points[:, [1, 2, 0]]) + 0.1 * np.cos(2 * mesh.points)
    move = in_plane(mesh, move)
    limit = safe_amplitude(mesh, move)
    assert limit == pytest.approx(bisected(mesh, move, 1.01 * limit, 30), rel=1e-6)


def test_moves_that_cannot_invert_have_no_limit():
    mesh = crowd("hexahedron", count=10)
    assert safe_amplitude(mesh, np.zeros(mesh.points.shape)) == np.inf
    assert safe_amplitude(mesh, np.ones(mesh.points.shape)) == np.inf
    assert safe_amplitude(mesh, mesh.points - mesh.points.mean(axis=0)) == np.inf


def test_what_is_inverted_at_the_start_is_not_counted_again():
    mesh = Mesh(CUBE[[0, 1, 3, 4]], {"tetra": [[0, 1, 2, 3]]})
    start = mesh.points * [1, 1, -1]
    assert safe_amplitude(mesh, -mesh.points, start) == np.inf


def test_cells_that_start_negative_are_followed_by_their_own_sign():
    mesh = crowd("wedge", count=30)
    mirrored = mesh.with_points(mesh.points * [1, 1, -1])
    move = np.random.default_rng(0).normal(size=mesh.points.shape)
    expected = safe_amplitude(mesh, move)
    assert safe_amplitude(mirrored, move * [1, 1, -1]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("tiny", [0.0, 1e-300, 1e-30, 1e-16, -1e-16, 1e-9, -1e-9])
def test_roots_survive_a_vanishing_leading_coefficient(tiny):
    one = np.ones(1)
    assert smallest(one, -one, 0 * one, tiny * one) == pytest.approx(1, rel=1e-8)
    assert smallest(one, -3 * one, 2 * one, tiny * one) == pytest.approx(0.5, rel=1e-8)


def test_the_smallest_root_is_that_of_a_companion_matrix():
    rng = np.random.default_rng(0)
    for _ in range(300):
        c = rng.normal(size=4) * 10.0 ** rng.uniform(-4, 4, 4)
        c[0] = abs(c[0])
        roots = np.roots(c[::-1])
        real = roots[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0)].real
        expected = real.min() if len(real) else np.inf
        assert smallest(*c[:, None]) == pytest.approx(expected, rel=1e-6)


def test_a_displacement_that_is_no_number_is_refused():
    mesh = crowd("tetra", count=2)
    with pytest.raises(InputError, match="finite"):
        safe_amplitude(mesh, np.full(mesh.points.shape, np.nan))


def test_a_node_that_moves_away_has_no_limit_from_rounding():
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    ends = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        points = corner + 0.12 * rng.standard_normal((4, 3))
        move = np.zeros((4, 3))
        move[0] = rng.standard_normal(3)
        a, b, c, d = (np.array([Fraction(x) for x in row]) for row in (*points[1:], points[0]))
        normal = np.cross(b - a, c - a)  # exact, as all that follows
        height, speed = normal @ (d - a), normal @ np.array([Fraction(x) for x in move[0]])
        found = safe_amplitude(Mesh(points, {"tetra": [[0, 1, 2, 3]]}), move)
        if height * speed < 0:
            assert found == pytest.approx(float(-height / speed), rel=1e-9)
        else:
            assert found == np.inf
            ends += 1
    assert 50 < ends < 150


def test_flat_cells_keep_the_roots_they_have():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1e-9, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    assert safe_amplitude(mesh, [[0, 0, 0], [0, 0, 0], [0, -1e-9, 0]]) == pytest.approx(1)
    assert safe_amplitude(mesh, [[0, 0, 0], [0, 0, 0], [1, -1e-9, 0]]) == pytest.approx(1)
    assert safe_amplitude(mesh, [[0, 0, 0], [0, 0, 0], [1, -1e-12, 0]]) == pytest.approx(1e3)
