"""The compiled pass over cells says what NumPy says, to the bit, whatever the cells and threads."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import threads
from ffdstudio.meshes import Mesh, inverted, safe_amplitude
from ffdstudio.meshes.measures import sweep
from tests.meshes.shapes import block, crowd, in_plane

KINDS = [
    ("triangle", False), ("triangle", True), ("quad", False), ("quad", True), ("tetra", False),
    ("pyramid", False), ("wedge", False), ("hexahedron", False),
]  # fmt: skip


@pytest.fixture
def both(monkeypatch):
    """Results of a function by NumPy and by the kernels."""

    def run(function):
        monkeypatch.setattr(sweep, "SMALL", 10**9)
        plain = function()
        monkeypatch.setattr(sweep, "SMALL", 0)
        return plain, function()

    return run


def motions(mesh, seed):
    """A small and a large one of all nodes, one of few nodes, and one that moves all alike."""
    rng = np.random.default_rng(seed)
    free = in_plane(mesh, rng.uniform(-1, 1, mesh.points.shape))
    few = np.where(rng.random(len(free)) < 0.02, 1.0, 0.0)[:, None] * free
    yield from (0.02 * free, 0.4 * free, 0.5 * few, 0 * free + in_plane(mesh, np.ones(3)))
    yield mesh.points * [-2.0, 0, 0]


@pytest.mark.parametrize(("kind", "surface"), KINDS)
@pytest.mark.parametrize("distortion", [0.02, 0.3])
def test_inverted_cells_and_safe_amplitudes_are_those_of_numpy(both, kind, surface, distortion):
    mesh = crowd(kind, 400, distortion, seed=3, surface=surface)
    for seed, step in enumerate(motions(mesh, 7)):
        here = mesh.points + step
        plain, quick = both(lambda here=here: inverted(mesh, here))
        assert (plain.mask == quick.mask).all()
        assert plain.corners == quick.corners
        plain, quick = both(lambda step=step: safe_amplitude(mesh, step))
        assert plain == quick, seed
        plain, quick = both(lambda here=here, step=step: safe_amplitude(mesh, step[::-1], here))
        assert plain == quick, seed


def test_some_of_these_cells_are_inverted_and_some_are_not():
    mesh = crowd("hexahedron", 400, 0.3, seed=3)
    counts = [inverted(mesh, mesh.points + step).count for step in motions(mesh, 7)]
    assert counts[0] < counts[1] < 400
    assert counts[-1] == 400


@pytest.mark.parametrize("cores", [1, 2, 5])
def test_threads_do_not_change_a_bit(monkeypatch, cores):
    points, cells = block(15, 15, 15)
    rng = np.random.default_rng(1)
    mesh = Mesh(points + rng.uniform(-0.01, 0.01, points.shape), {"hexahedron": cells})
    step = rng.uniform(-0.03, 0.03, points.shape)
    monkeypatch.setattr(sweep, "SMALL", 0)
    monkeypatch.setattr(sweep, "PIECE", 97)
    monkeypatch.setattr(sweep, "BATCH", 500)
    monkeypatch.setattr(threads, "count", lambda: cores)
    found = safe_amplitude(mesh, step), inverted(mesh, mesh.points + step).cells.tolist()
    monkeypatch.setattr(sweep, "SMALL", 10**9)
    assert found[0] == safe_amplitude(mesh, step)
    assert found[1] == inverted(mesh, mesh.points + step).cells.tolist()
    assert found[1]


def test_a_corner_without_volume_at_rest_is_not_judged(both):
    flat = Mesh(np.eye(4)[:, :3] * [1, 1, 0], {"tetra": [[0, 1, 2, 3]] * 3})
    plain, quick = both(lambda: inverted(flat, flat.points * [1, 1, -1]).count)
    assert plain == quick == 0


def test_a_fold_inside_is_found_where_all_corners_are_good(both):
    far = crowd("hexahedron", 5000, 0.0)
    step = np.random.default_rng(5).uniform(-0.55, 0.55, far.points.shape)
    plain, quick = both(lambda: inverted(far, far.points + step))
    assert plain.count > plain.corners  # some are negative inside alone
    assert (plain.mask == quick.mask).all()
