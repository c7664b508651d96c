"""Fits of surfaces in 3D through the public function: targets that no lattice at hand reaches."""

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError


@pytest.fixture(scope="module")
def skin(root):
    return ffd.read_mesh(root / "sample_meshes" / "wing_skin.vtu")


@pytest.fixture(scope="module")
def bump(skin):
    """The wing with a bump that is local in span, as the issue has it."""
    move = np.zeros((len(skin.points), 3))
    move[:, 2] = 0.05 * np.exp(-(((skin.points[:, 1] - 1.9) / 0.25) ** 2))
    return with_points(skin, skin.points + move)


def with_points(mesh, points):
    return ffd.Mesh(points, mesh.cells)


def moved(skin, size, directions):
    lattice = ffd.Lattice.around(skin.points, shape=(4, 4, 2), margin=0.02)
    control = lattice.control_points.copy()
    rng = np.random.default_rng(0)
    control[..., directions] += size * rng.uniform(-1, 1, (*lattice.shape, len(directions)))
    return with_points(skin, ffd.embed(lattice, skin.points).deform(lattice.moved(control)))


def normals(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def check_is_sane(skin, result, farthest):
    """Control points stay near, and no triangle turns over or vanishes."""
    step = result.lattice.control_points - result.rest.control_points
    assert np.abs(step).max() <= farthest
    reached = ffd.embed(result.rest, skin.points).deform(result.lattice)
    before, after = (normals(p, skin.cells["triangle"]) for p in (skin.points, reached))
    assert (np.sum(before * after, axis=1) > 0.5 * np.sum(before**2, axis=1)).all()


def test_a_bump_is_approached_regularly(skin, bump):
    result = ffd.fit(skin, bump, adaptive=None, columns=6, rows=6)
    assert result.history[0]["rms"] > 1.3e-2
    assert result.rms < 6e-3  # vertical displacements alone reach 5.8e-3 in this space
    assert result.ended == "converged"
    check_is_sane(skin, result, 1.0)


def test_a_bump_is_fitted_adaptively_with_fewer_variables_than_regularly(skin, bump):
    regular = ffd.fit(skin, bump, adaptive=None, columns=4, rows=11, directions="z")
    adaptive = ffd.fit(skin, bump, columns=5, start=4, rows=4, variables=72, directions="z")
    assert adaptive.variables < regular.variables
    assert adaptive.rms < regular.rms
    check_is_sane(skin, adaptive, 1.0)


@pytest.mark.parametrize("adaptive", [None, "gain"])
def test_a_target_that_moved_in_all_directions_is_met_without_far_control_points(skin, adaptive):
    target = moved(skin, 0.02, [0, 1, 2])
    result = ffd.fit(skin, target, columns=5, rows=5, adaptive=adaptive)
    assert result.rms <= 1e-5
    check_is_sane(skin, result, 0.3)


def test_directions_that_make_no_sense_are_refused(skin):
    for wrong in ("", "u", "zz"):
        with pytest.raises(InputError, match="letters out of xyz"):
            ffd.fit(skin, skin, directions=wrong)
    with pytest.raises(InputError, match="for surfaces"):
        ffd.fit("naca0012", "naca2412", directions="y")
