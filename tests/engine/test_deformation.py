import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import NdBSpline

from ffdstudio import threads as pool
from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.deformation import Deformer
from ffdstudio.errors import InputError
from tests.engine.nets import quarter_cylinder

# one triple for most tests: each one more costs a compilation
CUBIC = Lattice.box([0, 0, 0], [1, 1, 1], (8, 6, 4), (3, 3, 3))
seeds = st.integers(0, 2**32 - 1)


def bits(array):
    return np.ascontiguousarray(array).view(np.int64)


def twin(rest, current, points, u, inside):
    """The displacement form with plain NumPy evaluation."""
    out = points.copy()
    out[inside] += current.evaluate(u[inside]) - rest.evaluate(u[inside])
    return out


def scattered(lattice, count, rng):
    """Points with parameters of their own, some outside and some on knots, faces and corners."""
    low, high = lattice.domain.T
    u = rng.uniform(low, high, (count, lattice.dimension))
    for k, knots in enumerate(lattice.knots):
        on_knot = rng.random(count) < 0.1
        u[on_knot, k] = rng.choice(knots, on_knot.sum())
    inside = rng.random(count) < 0.9
    points = rng.normal(size=(count, 3))
    points[rng.random((count, 3)) < 0.1] = -0.0
    return points, np.where(inside[:, None], u, np.nan), inside


def disturbed(lattice, rng, weights=True):
    net = lattice.control_points + 0.1 * rng.random(lattice.control_points.shape)
    return lattice.moved(net, rng.uniform(0.5, 2, lattice.shape) if weights else None)


@pytest.mark.parametrize(
    ("degrees", "shape"),
    [
        ((3, 3, 3), (8, 6, 4)),
        ((2, 3, 1), (5, 4, 3)),
        ((10, 2, 1), (13, 4, 2)),
        ((1, 10, 2), (2, 11, 3)),
        ((10, 10, 10), (11, 11, 11)),
        ((4, 2), (7, 3)),
        ((5,), (9,)),
    ],
)
def test_points_follow_as_the_plain_evaluation_says(degrees, shape):
    rng = np.random.default_rng(len(degrees))
    box = Lattice.box([0, 0, 0], [2, 1, 1], shape, degrees)
    weighted = box.moved(weights=rng.uniform(0.7, 1.4, box.shape))
    for rest in (box, weighted):
        points, u, inside = scattered(rest, 3000, rng)
        deformer = Deformer(rest, points, u, inside)
        for weights in (None, 3 * rest.weights, rng.uniform(0.7, 1.4, rest.shape)):
            current = disturbed(rest, rng, weights=False).moved(weights=weights)
            expected = twin(rest, current, points, u, inside)
            assert np.abs(deformer.deform(current) - expected).max() < 1e-13 * rest.diagonal


def test_points_follow_as_scipy_says():
    rng = np.random.default_rng(0)
    points = rng.random((2000, 3))
    current = disturbed(CUBIC, rng, weights=False)
    spline = NdBSpline(CUBIC.knots, current.control_points, 3)
    moved = embed(CUBIC, points).deform(current)
    # the box is the identity, so the deformed point is the spline itself
    assert np.abs(moved - spline(points)).max() < 1e-13


def test_weights_turn_a_bent_block_into_a_cylinder():
    cylinder = quarter_cylinder(inner=1, outer=2)
    block = cylinder.moved(weights=np.ones(cylinder.shape))
    u = np.random.default_rng(0).random((1000, 3))
    points = block.evaluate(u)
    moved = Deformer(block, points, u, np.ones(1000, bool)).deform(cylinder)
    assert np.abs(np.hypot(moved[:, 0], moved[:, 1]) - (1 + u[:, 1])).max() < 1e-14


def test_far_from_the_origin_the_displacement_keeps_its_digits():
    rng = np.random.default_rng(0)
    u = rng.random((500, 3))
    near = CUBIC.moved(weights=rng.uniform(0.5, 2, CUBIC.shape))
    far = near.moved(near.control_points + 1e6)
    motion = np.round(rng.random(near.control_points.shape), 3)
    weights = rng.uniform(0.5, 2, near.shape)
    zero = np.zeros((500, 3))
    moved = [
        Deformer(rest, zero, u, np.ones(500, bool)).deform(
            rest.moved(rest.control_points + motion, weights)
        )
        for rest in (near, far)
    ]
    assert np.abs(moved[0] - moved[1]).max() < 1e-9  # the net itself has 1e-10


@settings(max_examples=20, deadline=None)
@given(seed=seeds, weighted=st.booleans())
def test_a_lattice_at_rest_changes_no_bit(seed, weighted):
    rng = np.random.default_rng(seed)
    rest = disturbed(CUBIC, rng, weighted)
    points, u, inside = scattered(rest, 300, rng)
    moved = Deformer(rest, points, u, inside).deform(rest.moved())
    assert (bits(moved) == bits(points)).all()


@settings(max_examples=20, deadline=None)
@given(seed=seeds, weighted=st.booleans())
def test_points_that_a_control_point_does_not_reach_keep_their_bits(seed, weighted):
    rng = np.random.default_rng(seed)
    rest = disturbed(CUBIC, rng, weighted)
    points, u, inside = scattered(rest, 400, rng)
    one = int(rng.integers(rest.weights.size))
    net, weights = rest.control_points.copy(), rest.weights.copy()
    net.reshape(-1, 3)[one] += rng.normal(size=3)
    weights.reshape(-1)[one] *= 1.5
    deformer = Deformer(rest, points, u, inside)
    reached = np.zeros(len(points), bool)
    reached[inside] = _basis_of(rest, one, u[inside]) != 0
    assert (reached == (np.diff(deformer_rows(deformer, rest, one).indptr) > 0)).all()
    for current in (rest.moved(net), rest.moved(net, weights)):
        moved = deformer.deform(current)
        assert (bits(moved)[~reached] == bits(points)[~reached]).all()


def deformer_rows(deformer, lattice, one):
    from ffdstudio.engine.jacobians import jacobian

    inside = ~np.isnan(deformer.parameters()[:, 0])
    column = jacobian(lattice, deformer.parameters(), inside)[:, [one]].tocsr()
    column.eliminate_zeros()
    return column


def _basis_of(lattice, one, u):
    """Values of one basis function by SciPy, exactly zero outside its support and on its rim."""
    value = np.ones(len(u))
    for k, i in enumerate(np.unravel_index(one, lattice.shape)):
        p, knots = lattice.degrees[k], lattice.knots[k]
        at_first = (u[:, k] == knots[0]) & (i == 0)
        at_last = (u[:, k] == knots[-1]) & (i == lattice.shape[k] - 1)
        inner = (u[:, k] > knots[i]) & (u[:, k] < knots[i + p + 1])
        value *= inner | at_first | at_last
    return value


@settings(max_examples=15, deadline=None)
@given(seed=seeds)
def test_a_point_moves_alike_wherever_it_stands(seed):
    """Permuted, split, and with other bodies beside: coincident nodes stay coincident."""
    rng = np.random.default_rng(seed)
    rest = disturbed(CUBIC, rng, weights=False)
    weights = np.ones(rest.shape)
    weights[: rng.integers(8)] = 1.3  # some cells plain, some rational
    current = disturbed(rest, rng).moved(weights=weights)
    points, u, inside = scattered(rest, 700, rng)
    whole = Deformer(rest, points, u, inside).deform(current)
    shuffle = rng.permutation(700)[: rng.integers(1, 700)]
    part = Deformer(rest, points[shuffle], u[shuffle], inside[shuffle]).deform(current)
    assert (bits(part) == bits(whole[shuffle])).all()


def test_chunks_and_threads_change_no_bit(monkeypatch):
    rng = np.random.default_rng(0)
    points, u, inside = scattered(CUBIC, 70_000, rng)
    current = disturbed(CUBIC, rng)
    many = Deformer(CUBIC, points, u, inside).deform(current)
    monkeypatch.setattr(pool, "count", lambda: 1)
    few = Deformer(CUBIC, points[40_001:], u[40_001:], inside[40_001:]).deform(current)
    assert (bits(many[40_001:]) == bits(few)).all()
    assert np.abs(many - twin(CUBIC, current, points, u, inside)).max() < 1e-13


def test_more_cells_than_a_table_holds():
    rng = np.random.default_rng(0)
    fine = Lattice.box([0, 0, 0], [1, 1, 1], (24, 24, 24), (3, 3, 3))
    points, u, inside = scattered(fine, 70_000, rng)
    current = disturbed(fine, rng)
    moved = Deformer(fine, points, u, inside).deform(current)
    assert np.abs(moved - twin(fine, current, points, u, inside)).max() < 1e-13
    assert (bits(moved[::7]) == bits(_deformed(fine, current, points, u, inside, 7))).all()


def _deformed(rest, current, points, u, inside, step):
    return Deformer(rest, points[::step].copy(), u[::step], inside[::step]).deform(current)


def test_points_on_a_held_face_keep_their_bits():
    rng = np.random.default_rng(0)
    u = rng.random((500, 3))
    u[:, 1] = rng.integers(0, 2, 500)
    points = u.copy()
    points[u[:, 1] == 0, 1] = -0.0
    net = CUBIC.control_points.copy()
    net[:, 1:-1] += rng.random((8, 4, 4, 3))
    weights = np.ones(CUBIC.shape)
    weights[:, 1:-1] = rng.uniform(0.5, 2, (8, 4, 4))
    moved = Deformer(CUBIC, points, u, np.ones(500, bool)).deform(CUBIC.moved(net, weights))
    assert (bits(moved) == bits(points)).all()


def test_coordinates_in_which_nothing_moves_keep_their_bits():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.random((300, 2)), np.full(300, -0.0)])
    plane = Lattice.box([0, 0], [1, 1], (5, 4), (3, 2))
    net = plane.control_points.copy()
    net[..., 1] += rng.random((5, 4))
    embedding = embed(plane, points)
    moved = embedding.deform(plane.moved(net))
    assert (bits(moved[:, [0, 2]]) == bits(points[:, [0, 2]])).all()
    turned = embedding.deform(plane.moved(net, rng.uniform(0.5, 2, (5, 4))))
    assert (bits(turned[:, 2]) == bits(points[:, 2])).all()


def test_a_common_factor_of_all_weights_moves_nothing():
    points = np.random.default_rng(0).random((200, 3))
    moved = embed(CUBIC, points).deform(CUBIC.moved(weights=np.full(CUBIC.shape, 2.5)))
    assert (bits(moved) == bits(points)).all()


def test_several_threads_deform_at_once():
    rng = np.random.default_rng(0)
    points = rng.random((60_000, 3))
    embedding = embed(CUBIC, points)
    states = [disturbed(CUBIC, rng) for _ in range(4)]
    alone = [embedding.deform(state) for state in states]
    together = [np.empty_like(points) for _ in states]
    workers = [
        threading.Thread(target=embedding.deform, args=pair)
        for pair in zip(states, together, strict=True)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert all((bits(a) == bits(b)).all() for a, b in zip(alone, together, strict=True))


@pytest.mark.parametrize("count", [0, 1, 40_000])
def test_no_point_inside_is_a_copy(count):
    points = np.full((count, 3), 7.0)
    embedding = embed(CUBIC, points)
    current = disturbed(CUBIC, np.random.default_rng(0))
    assert (bits(embedding.deform(current)) == bits(points)).all()
    assert embedding.parameters.shape == (count, 3)
    assert embedding.jacobian(current).shape == (count, 192)
    assert not embedding.jacobian_pullback(current, points).any()


def test_the_output_array_is_used_or_refused():
    points = np.random.default_rng(0).random((10, 3))
    embedding, current = embed(CUBIC, points), disturbed(CUBIC, np.random.default_rng(1))
    out = np.empty((10, 3))
    assert embedding.deform(current, out) is out
    fixed = np.empty((10, 3))
    fixed.flags.writeable = False
    strided = np.empty((10, 6))[:, ::2]
    for wrong in (np.empty((9, 3)), np.empty((10, 3), np.float32), strided, fixed):
        with pytest.raises(InputError, match="output"):
            embedding.deform(current, wrong)
    with pytest.raises(InputError, match="of their own"):
        embedding.deform(current, points)


def test_another_space_is_refused():
    embedding = embed(CUBIC, np.zeros((1, 3)))
    with pytest.raises(InputError, match="other degrees or knots"):
        embedding.deform(CUBIC.insert_knots(0, [0.5]))


def test_a_second_process_finds_the_kernel_in_the_disk_cache(tmp_path):
    script = (
        "import numpy as np\n"
        "from ffdstudio.engine import Lattice, embed\n"
        "from ffdstudio.engine.kernels import displace\n"
        "box = Lattice.box([0, 0, 0], [1, 1, 1], (3, 2, 2), (2, 1, 1))\n"
        "embed(box, np.ones((1, 3))).deform(box.moved(box.control_points + 1))\n"
        "stats = displace(2, 1, 1).stats\n"
        "print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    answers = [
        subprocess.run(
            [sys.executable, "-c", script], env=environment, check=True, capture_output=True
        ).stdout.split()
        for _ in range(2)
    ]
    assert answers == [[b"0", b"1"], [b"1", b"0"]]
