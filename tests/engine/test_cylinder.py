"""Lattices in a cylindrical frame, and rings of any net that close on themselves."""

import pickle

import numpy as np
import pytest

from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.folds import folds
from ffdstudio.engine.frames import Cylinder
from ffdstudio.engine.inversion.tangle import refuse_tangled
from ffdstudio.errors import InputError

TILTED = {"origin": [3, 1, -2], "axis": [1, 2, 0.3]}


def ring(**more):
    return Lattice.cylinder((0.5, 1.5), heights=(0, 2), shape=(3, 8, 3), **more)


def weighted_ring():
    """Weights at rest, which leave the frame as it is."""
    plain = ring(**TILTED)
    weights = np.random.default_rng(7).uniform(0.5, 2, plain.shape)
    return Lattice.of_parts(
        {
            **plain.parts(),
            "weights": weights,
            "reference": {"control_points": plain.control_points, "weights": weights},
        }
    )


def solid_sector():
    return Lattice.cylinder((0, 1.5), (0.3, 1.9), (0, 2), shape=(4, 6, 3), **TILTED)


def round_net():
    """A full turn of quadratic arcs: the circle itself, by weights, without a frame."""
    corner = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]])
    net = np.zeros((2, 8, 2, 3))
    net[..., :2] = np.array([0.5, 1.5])[:, None, None, None] * corner[None, :, None]
    net[:, :, 1, 2] = 2.0
    weights = np.ones((2, 8, 2))
    weights[:, 1::2] = np.sqrt(0.5)
    turn = np.repeat([0.25, 0.5, 0.75, 1.0], 2)
    around = np.concatenate([[-0.25, 0, 0], turn, [1.25, 1.25]])
    line = [0, 0, 1, 1]
    return Lattice((1, 2, 1), (line, around, line), net, weights, periodic=[False, True, False])


MAKERS = [ring, weighted_ring, solid_sector, round_net]


@pytest.mark.parametrize("make", MAKERS)
def test_no_point_is_lost_and_the_way_back_is_exact(make):
    lattice = make()
    u = np.random.default_rng(0).uniform(*lattice.domain.T, (100_000, 3))
    x = lattice.evaluate(u)
    found = embed(lattice, x)
    assert found.inside.all()
    assert found.residual.max() <= 1e-12 * lattice.diagonal
    assert np.abs(lattice.evaluate(found.parameters) - x).max() <= 1.1e-12 * lattice.diagonal
    assert np.abs(found.parameters - u).max() < 1e-9
    still = found.deform(lattice.moved())
    assert (still.view(np.int64) == x.view(np.int64)).all()


def test_the_weighted_net_is_the_circle():
    lattice = round_net()
    u = np.random.default_rng(1).random((1000, 3))
    x = lattice.evaluate(u)
    assert np.abs(np.hypot(x[:, 0], x[:, 1]) - (0.5 + u[:, 0])).max() < 1e-15


@pytest.mark.parametrize("make", MAKERS)
def test_points_outside_are_told_and_never_touched(make):
    lattice = make()
    frame = lattice.frame or Cylinder.of()
    rng = np.random.default_rng(2)
    low, high = lattice.domain.T if lattice.frame else (np.array([0.5, 0, 0]), [1.5, 7, 2])
    u = rng.uniform([0, 0, -1], [2.5, 2 * np.pi, 3], (20_000, 3))
    around = (u[:, 1] >= low[1]) & (u[:, 1] <= high[1])
    within = around & ((u >= low) & (u <= high))[:, [0, 2]].all(axis=1)
    x = frame.world(u, (0, 0, 0))
    found = embed(lattice, x)
    near = (np.abs(u[:, None] - np.stack([low, high])).min(axis=1) < 1e-6).any(axis=1)
    assert (found.inside == within)[~near].all()
    current = lattice.moved(lattice.control_points + 0.1)
    moved = found.deform(current)
    assert (moved[~found.inside].view(np.int64) == x[~found.inside].view(np.int64)).all()
    assert np.abs(moved[found.inside] - x[found.inside] - 0.1).max() < 1e-14


@pytest.mark.parametrize("make", [ring, weighted_ring])
@pytest.mark.parametrize("column", range(8))
def test_first_and_second_differences_go_on_across_the_seam(make, column):
    """Cubic: what one moved column does at the seam is as smooth as between the knots."""
    lattice = make()
    net = lattice.control_points.copy()
    net[:, column] += [0.05, -0.1, 0.2]
    current = lattice.moved(net)
    h = 1e-3
    steps = h * np.arange(-6, 7)
    for place in (0.0, 0.4):  # the seam, and the middle of a knot span
        u = np.stack([np.full(13, 1.1), np.mod(place + steps, 2 * np.pi), np.full(13, 0.7)], axis=1)
        x = lattice.evaluate(u)
        step = embed(lattice, x).deform(current) - x
        first, second = np.diff(step, axis=0) / h, np.diff(step, 2, axis=0) / h**2
        # a jump of the slope would show as 1/h in the second, one of the curvature as 1
        assert np.abs(np.diff(first, axis=0)).max() < 5 * h
        assert np.abs(np.diff(second, axis=0)).max() < 10 * h
    u = np.array([[1.1, 0.0, 0.7], [1.1, 2 * np.pi, 0.7]])
    for order in ([0, 0, 0], [0, 1, 0], [0, 2, 0]):
        before, behind = current.evaluate(u, order)
        assert np.abs(before - behind).max() < 1e-13


def test_a_clamped_ring_moved_at_its_seam_does_step():
    """The fault that a periodic direction is for."""
    lattice = ring().clamped()
    net = lattice.control_points.copy()
    net[:, 0] += 0.1
    ends = np.array([[1.0, 0.0, 1.0], [1.0, 2 * np.pi, 1.0]])
    before, behind = lattice.moved(net).evaluate(ends)
    assert np.linalg.norm(before - behind) > 0.1


@pytest.mark.parametrize("make", MAKERS)
def test_refinement_of_a_deformed_lattice_is_exact_and_carries_the_embedding(make):
    rest = make()
    rng = np.random.default_rng(4)
    current = rest.moved(
        rest.control_points + 0.02 * rng.normal(size=rest.control_points.shape),
        rest.weights * rng.uniform(0.8, 1.25, rest.shape),
    )
    x = rest.evaluate(rng.uniform(*rest.domain.T, (3000, 3)))
    found = embed(rest, x)
    inner = rest.domain[1].mean() + 0.01

    def finer(lattice):
        return lattice.insert_knots(1, [inner, inner + 0.1]).elevate_degree(1).elevate_degree(0)

    after = found.refined(finer(rest)).deform(finer(current))
    assert np.abs(after - found.deform(current)).max() <= 1e-13 * rest.diagonal
    still = found.refined(finer(rest)).deform(finer(rest))
    assert (still == x).all()


@pytest.mark.parametrize("make", MAKERS)
def test_jacobians_products_and_pullbacks_fit_together(make):
    rest = make()
    rng = np.random.default_rng(5)
    current = rest.moved(
        rest.control_points + 0.02 * rng.normal(size=rest.control_points.shape),
        rng.uniform(0.8, 1.25, rest.shape),
    )
    x = rest.evaluate(rng.uniform(*rest.domain.T, (400, 3)))
    found = embed(rest, x)
    d_points, d_weights = rng.normal(size=(*rest.shape, 3)), rng.normal(size=rest.shape)
    h = 1e-6

    def difference(by_points, by_weights):
        ends = [
            found.deform(
                current.moved(
                    current.control_points + s * h * by_points, current.weights + s * h * by_weights
                )
            )
            for s in (1, -1)
        ]
        return (ends[0] - ends[1]) / (2 * h)

    forth = found.jacobian_product(current, d_points)
    turned = found.weight_product(current, d_weights)
    assert np.abs(forth - difference(d_points, 0 * d_weights)).max() < 1e-8
    assert np.abs(turned - difference(0 * d_points, d_weights)).max() < 1e-8
    assert np.abs(found.jacobian(current) @ d_points.reshape(-1, 3) - forth).max() < 1e-13
    s = rng.normal(size=x.shape)
    back, gradient = found.jacobian_pullback(current, s), found.weight_pullback(current, s)
    assert np.vdot(back, d_points) == pytest.approx(np.vdot(s, forth), abs=1e-11)
    assert np.vdot(gradient, d_weights) == pytest.approx(np.vdot(s, turned), abs=1e-11)
    twin = current.evaluate(found.parameters) - rest.evaluate(found.parameters)
    assert np.abs(found.deform(current) - x - twin).max() < 1e-13


def test_derivatives_of_the_map_are_differences_of_it():
    rest = solid_sector()
    current = rest.moved(rest.control_points**2)
    rng = np.random.default_rng(6)
    low, high = rest.domain.T
    u = rng.uniform(low + 0.01 * (high - low), high - 0.01 * (high - low), (200, 3))
    h = 1e-5
    for k in range(3):
        for j in range(3):
            order = [int(i == k) + int(i == j) for i in range(3)]
            step, one = h * np.eye(3)[k], [int(i == j) for i in range(3)]
            ends = [current.evaluate(u + s * step, one) for s in (1, -1)]
            exact = current.evaluate(u, order)
            assert np.abs((ends[0] - ends[1]) / (2 * h) - exact).max() < 1e-4


def test_a_deformed_lattice_may_be_the_one_at_rest():
    rest = ring()
    net = rest.control_points.copy()
    net[:, 2] *= 1.1
    bent = rest.moved(net)
    u = np.random.default_rng(8).uniform(*rest.domain.T, (3000, 3))
    found = embed(bent, bent.evaluate(u))
    assert found.inside.all()
    assert found.residual.max() <= 1e-12 * rest.diagonal
    turn = np.abs(found.parameters - u)
    assert np.minimum(turn, np.abs(turn - [0, 2 * np.pi, 0])).max() < 1e-9


def test_folds_are_looked_for_along_the_frame():
    rest = ring()
    assert folds(rest).locally_invertible
    refuse_tangled(rest)
    refuse_tangled(solid_sector())
    refuse_tangled(round_net())
    net = rest.control_points.copy()
    net[0] *= [5, 5, 1]
    assert folds(rest.moved(net), rest).folded.any()


def test_a_plane_ring_leaves_the_axial_coordinate_alone():
    rest = Lattice.cylinder((1, 2), shape=(3, 9))
    x = rest.evaluate(np.random.default_rng(9).uniform(*rest.domain.T, (500, 2)))
    x[:, 2] = np.linspace(-5, 5, 500)
    found = embed(rest, x)
    assert found.inside.all()
    net = rest.control_points.copy()
    net[:, 0, 2] += 1
    moved = found.deform(rest.moved(net))
    assert (moved[:, :2] == x[:, :2]).all()


def test_points_on_the_axis_and_on_the_faces_are_inside():
    solid = Lattice.cylinder((0, 1), heights=(-1, 1), shape=(3, 8, 3))
    x = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, -1, -1], [np.cos(1), np.sin(1), 0.5]]
    assert embed(solid, x).inside.all()
    assert not embed(solid, [[1 + 1e-6, 0, 0], [0, 0, 1 + 1e-6]]).inside.any()


def test_parts_and_pickles_say_everything():
    for make in MAKERS:
        lattice = make()
        moved = lattice.moved(lattice.control_points + 0.1)
        for one in (lattice, moved):
            for again in (Lattice.of_parts(one.parts()), pickle.loads(pickle.dumps(one))):
                assert again == one
                assert again.same_space(one)
    assert ring() != ring().clamped()
    assert not ring().same_space(ring(axis=[1, 0, 0]))


@pytest.mark.parametrize(
    ("words", "arguments"),
    [
        ("radii", {"radii": (2, 1)}),
        ("radii", {"radii": (1, np.inf)}),
        ("negative", {"radii": (-1, 1)}),
        ("angles", {"radii": (1, 2), "angles": (1, 1)}),
        ("one turn", {"radii": (1, 2), "angles": (0, 7)}),
        ("heights", {"radii": (1, 2), "heights": (1, 0), "shape": (3, 8, 3)}),
        ("radius and angle", {"radii": (1, 2), "heights": (0, 1)}),
        ("needs at least 4 control points", {"radii": (1, 2), "shape": (3, 3), "degrees": (2, 3)}),
        ("must not be zero", {"radii": (1, 2), "axis": (0, 0, 0)}),
        ("along the axis", {"radii": (1, 2), "start": (0, 0, 2)}),
        ("3 finite numbers", {"radii": (1, 2), "origin": (0, 0)}),
    ],
)
def test_a_cylinder_that_is_none_is_refused(words, arguments):
    with pytest.raises(InputError, match=words):
        Lattice.cylinder(**{"shape": (3, 8), **arguments})
