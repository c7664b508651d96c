import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import NdBSpline

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from tests.engine.nets import CURVED, quarter_cylinder, random_lattice

SHAPES = [((6, 5, 4), (3, 2, 3)), ((6, 5), (4, 1)), ((7,), (3,)), ((2, 2, 2), (1, 1, 1))]


def parameters(lattice, n, rng):
    low, high = lattice.domain.T
    return rng.uniform(low, high, (n, lattice.dimension))


@pytest.mark.parametrize(("shape", "degrees"), SHAPES)
def test_evaluation_equals_scipys_tensor_spline(shape, degrees):
    rng = np.random.default_rng(0)
    lattice = random_lattice(rng, shape, degrees, weighted=False)
    u = parameters(lattice, 300, rng)
    expected = NdBSpline(lattice.knots, lattice.control_points, degrees)(u)
    assert np.abs(lattice.evaluate(u) - expected).max() <= 1e-13 * lattice.diagonal


@pytest.mark.parametrize(("shape", "degrees"), SHAPES)
def test_rational_evaluation_is_the_quotient_of_two_splines(shape, degrees):
    rng = np.random.default_rng(1)
    lattice = random_lattice(rng, shape, degrees)
    u = parameters(lattice, 300, rng)
    both = NdBSpline(lattice.knots, lattice.homogeneous, degrees)(u)
    expected = both[:, :3] / both[:, 3:]
    assert np.abs(lattice.evaluate(u) - expected).max() <= 1e-13 * lattice.diagonal


def test_weights_make_an_exact_cylinder():
    lattice = quarter_cylinder(1.0, 2.0, 3.0)
    u = np.random.default_rng(2).uniform(size=(500, 3))
    x = lattice.evaluate(u)
    np.testing.assert_allclose(np.hypot(x[:, 0], x[:, 1]), 1 + u[:, 1], atol=1e-14)
    np.testing.assert_allclose(x[:, 2], 3 * u[:, 2], atol=1e-14)


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("order", [(1, 0, 0), (0, 0, 1), (2, 0, 0), (1, 1, 0), (0, 1, 1)])
def test_derivatives_equal_those_of_the_interpolating_polynomial(weighted, order):
    """Chebyshev interpolation inside one knot span: a second way to differentiate."""
    rng = np.random.default_rng(3)
    lattice = random_lattice(rng, weighted=weighted)
    middle, half = np.array([1.4, 0.9, 0.4]), 0.05
    nodes = np.cos(np.pi * (np.arange(9) + 0.5) / 9)
    grid = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), -1).reshape(-1, 3)
    table = lattice.evaluate(middle + half * grid).reshape(9, 9, 9, 3)
    to_coefficients = np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, 8))
    for axis in range(3):
        table = np.moveaxis(np.tensordot(to_coefficients, table, axes=(1, axis)), 0, axis)
        table = np.polynomial.chebyshev.chebder(table, order[axis], axis=axis)
    at = rng.uniform(-1, 1, (20, 3))
    expected = np.polynomial.chebyshev.chebval3d(*at.T, table) / half ** sum(order)
    found = lattice.evaluate(middle + half * at, order)
    np.testing.assert_allclose(found, expected.T, rtol=0, atol=1e-8 * np.abs(expected).max() + 1e-9)


@given(st.integers(0, 10_000))
def test_a_box_at_rest_is_the_identity(seed):
    rng = np.random.default_rng(seed)
    d = int(rng.integers(1, 4))
    degrees = rng.integers(1, 5, d)
    shape = degrees + rng.integers(1, 5, d)
    low = rng.normal(size=3)
    box = Lattice.box(low, low + rng.uniform(0.1, 10, 3), [int(n) for n in shape], degrees)
    u = parameters(box, 20, rng)
    assert (
        np.abs(box.evaluate(u)[:, :d] - u).max() <= 1e-14 * box.diagonal + 1e-15 * np.abs(low).max()
    )


def test_a_turned_frame_turns_the_box():
    axes = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])
    box = Lattice.box([0, 0, 0], [2, 1, 1], (4, 3, 2), axes=axes)
    np.testing.assert_allclose(box.evaluate([[2.0, 0, 0]]), [[1.2, 1.6, 0]], atol=1e-15)


def test_equal_spacing_puts_the_points_where_the_paper_does():
    box = Lattice.box([0, 0, 0], [1, 1, 1], (5, 3, 2), spacing="uniform")
    np.testing.assert_allclose(box.control_points[:, 0, 0, 0], [0, 0.25, 0.5, 0.75, 1])


def test_around_leaves_the_margin_and_gives_a_flat_mesh_thickness():
    points = np.array([[0.0, 0, 5], [2, 1, 5]])
    box = Lattice.around(points, (3, 3, 3), margin=0.1)
    np.testing.assert_allclose(box.domain, [[-0.2, 2.2], [-0.1, 1.1], [4.8, 5.2]])


REFINEMENTS = {
    "insertion": lambda x, k: x.insert_knots(k, [*x.domain[k] @ [[0.6, 0.3], [0.4, 0.7]]]),
    "elevation": lambda x, k: x.elevate_degree(k, 2),
}


@pytest.mark.parametrize("refine", REFINEMENTS)
@pytest.mark.parametrize(("shape", "degrees"), SHAPES)
def test_refinement_moves_no_point_of_a_deformed_weighted_lattice(refine, shape, degrees):
    rng = np.random.default_rng(4)
    lattice = random_lattice(rng, shape, degrees)
    u = parameters(lattice, 300, rng)
    before = lattice.evaluate(u)
    for axis in range(lattice.dimension):
        finer = REFINEMENTS[refine](lattice, axis)
        assert finer.shape[axis] > lattice.shape[axis]
        assert np.abs(finer.evaluate(u) - before).max() <= 1e-13 * lattice.diagonal


@pytest.mark.parametrize(("shape", "degrees"), SHAPES)
def test_removal_takes_back_an_insertion(shape, degrees):
    rng = np.random.default_rng(5)
    lattice = random_lattice(rng, shape, degrees)
    for axis in range(lattice.dimension):
        knots = np.array([0.37, 0.81]) * lattice.domain[axis, 1]
        back = lattice.insert_knots(axis, knots).remove_knots(axis, knots)
        assert back.same_space(lattice)
        gap = np.abs(back.control_points - lattice.control_points).max()
        assert gap <= 1e-13 * lattice.diagonal
        np.testing.assert_allclose(back.weights, lattice.weights, rtol=1e-13)


@pytest.mark.parametrize("weighted", [False, True])
def test_removal_within_a_tolerance_moves_no_point_farther(weighted):
    rng = np.random.default_rng(6)
    lattice = random_lattice(rng, (7, 4, 4), (3, 2, 2), weighted=weighted, spread=1e-3)
    if weighted:
        lattice = lattice.moved(weights=1 + 1e-3 * rng.normal(size=lattice.shape))
    knot = lattice.knots[0][5]
    with pytest.raises(InputError, match="more than the tolerance"):
        lattice.remove_knots(0, knot, tolerance=1e-6)
    coarse = lattice.remove_knots(0, knot, tolerance=0.05)
    u = parameters(lattice, 2000, rng)
    moved = np.linalg.norm(coarse.evaluate(u) - lattice.evaluate(u), axis=1).max()
    assert 1e-6 < moved <= 0.05


def test_a_part_that_two_lattices_share_stays_bit_equal_through_refinement():
    rest = CURVED["wavy"]()
    moved = rest.control_points.copy()
    moved[7, 5, 3] += 0.1
    current = rest.moved(moved)
    finer_rest, finer = rest.insert_knots(0, [0.5]), current.insert_knots(0, [0.5])
    changed = (finer.control_points != finer_rest.control_points).any(axis=-1)
    assert changed.sum() == 1  # the corner, interpolated, and nothing else


def test_a_lattice_is_a_value():
    a = Lattice.box([0, 0, 0], [1, 1, 1], (3, 3, 3))
    with pytest.raises(AttributeError):
        a.weights = np.ones((3, 3, 3))
    with pytest.raises(ValueError, match="read-only"):
        a.control_points[0, 0, 0] = 1
    source = np.array(a.control_points)
    b = a.moved(source)
    source += 1
    assert a == b == copy.deepcopy(a) == pickle.loads(pickle.dumps(a))
    assert a != a.moved(source)


NET = np.zeros((2, 2, 3))
LINE = [0, 0, 1, 1]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Lattice((1,), (LINE,), NET), "as many degrees"),
        (lambda: Lattice((1, 2), (LINE, LINE), NET), "degree 2 in direction j needs"),
        (lambda: Lattice((1, 1), (LINE, [0, 0, 1]), NET), "knots, got 3"),
        (lambda: Lattice((1, 1), (LINE, LINE), np.zeros((2, 2))), "control points"),
        (lambda: Lattice((1, 1), (LINE, LINE), NET + np.inf), "finite"),
        (lambda: Lattice((1, 1), (LINE, LINE), NET, [[1, 1], [1, 0]]), "positive"),
        (lambda: Lattice((1, 1), (LINE, LINE), NET, [[1, 1], [1, np.nan]]), "positive"),
        (lambda: Lattice((1, 1), (LINE, LINE), NET, [1, 1]), "shape"),
        (lambda: Lattice((1, 1), (LINE, LINE), NET, axes=[[1, 0, 0], [1, 0, 0]]), "right angles"),
        (lambda: Lattice.box([0, 0, 0], [1, 0, 1]), "no extent in direction j"),
        (lambda: Lattice.box([0, 0, 0], [1, -1, 1]), "no extent"),
        (lambda: Lattice.box([0, 0, 0], [1, 1, np.nan]), "finite"),
        (lambda: Lattice.box([0, 0], [1, 1]), "3 coordinates"),
        (lambda: Lattice.box([0, 0, 0], [1, 1, 1], (4, 4, 1)), "at least 2"),
        (lambda: Lattice.box([0, 0, 0], [1, 1, 1], (4, 4, 2, 2)), "1, 2 or 3"),
        (lambda: Lattice.box([0, 0, 0], [1, 1, 1], (4, 4), (3,)), "as many degrees"),
        (lambda: Lattice.box([0, 0, 0], [1, 1, 1], spacing="cosine"), "spacing"),
        (lambda: Lattice.around(np.zeros((0, 3))), "n >= 1"),
        (lambda: Lattice.around(np.zeros((1, 3))), "no extent"),
        (lambda: Lattice.around([[0, 0, np.nan]]), "finite"),
        (lambda: Lattice.around([[0, 0, 0], [1, 1, 1]], margin=-1), "margin"),
    ],
)
def test_what_does_not_fit_together_is_refused_in_words(make, words):
    with pytest.raises(InputError, match=words):
        make()


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda x: x.moved(np.zeros((3, 3, 3))), "have shape"),
        (lambda x: x.moved(weights=np.zeros(x.shape)), "positive"),
        (lambda x: x.insert_knots(3, [0.5]), "directions 0 to 2"),
        (lambda x: x.insert_knots(0, [1.0]), "must lie inside"),
        (lambda x: x.insert_knots(0, [np.nan]), "must lie inside"),
        (lambda x: x.insert_knots(2, [0.5, 0.5]), "more than 1 times"),
        (lambda x: x.elevate_degree(0, -1), "not -1"),
        (lambda x: x.remove_knots(0, [0.123]), "no inner knot"),
        (lambda x: x.evaluate([[0.5, 0.5, 1.5]]), "must lie in"),
        (lambda x: x.evaluate([[0.5, 0.5, np.nan]]), "must lie in"),
        (lambda x: x.evaluate([[0.5, 0.5]]), "must be an array"),
        (lambda x: x.evaluate([[0.5, 0.5, 0.5]], (1, 1, 1)), "derivative"),
    ],
)
def test_an_edit_that_cannot_be_is_refused_in_words(edit, words):
    box = Lattice.box([0, 0, 0], [1, 1, 1], (5, 3, 2), (3, 2, 1))
    with pytest.raises(InputError, match=words):
        edit(box)


# ---- what is no lattice ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Lattice.box([0] * 3, [1] * 3, shape=(np.nan, 2, 2)), "at least 2"),
        (lambda: Lattice.box([0] * 3, [1] * 3, shape=8), "shape"),
        (lambda: Lattice.box([0] * 3, [1] * 3, shape=(4, 4, 4), degrees=3), "degrees"),
        (lambda: Lattice.box([0] * 3, [1] * 3, (4, 4, 4), degrees=(np.nan, 1, 1)), "degree"),
        (lambda: Lattice.box("abc", [1] * 3, (2, 2)), "corners"),
        (lambda: Lattice([1], [None], [[0, 0, 0], [1, 0, 0]]), "knots"),
        (lambda: Lattice([1], [[0, 0, 1, 1]], [[0, 0, 0], [1, 0]]), "control points"),
        (lambda: BOX.moved("abc"), "control points"),
        (lambda: BOX.elevate_degree(0, np.nan), "times"),
        (lambda: BOX.insert_knots(0, "x"), "knots"),
        (lambda: BOX.insert_knots(0, [0.3, 0.1 + 0.2]), "nearly coincide"),
        (lambda: BOX.insert_knots(0, [np.nextafter(0.5, 1)]), "nearly coincide"),
        (lambda: BOX.insert_knots(0, [5e-324]), "nearly coincide"),
    ],
)
def test_what_makes_no_lattice_is_refused_in_words(make, words):
    with pytest.raises(InputError, match=words):
        make()


BOX = Lattice.box([0, 0, 0], [1, 1, 1], (5, 4, 3))


@pytest.mark.parametrize(("offset", "size"), [(1e6, 1.0), (1.0, 1e-6), (1e6, 1e3)])
def test_a_knot_can_be_removed_again_wherever_the_lattice_lies(offset, size):
    rng = np.random.default_rng(0)
    box = Lattice.box([offset] * 3, [offset + size] * 3, (5, 4, 3))
    moved = box.moved(box.control_points + 0.05 * size * rng.random((5, 4, 3, 3)))
    knot = [offset + 0.3 * size]
    back = moved.insert_knots(0, knot).remove_knots(0, knot)
    np.testing.assert_allclose(back.control_points, moved.control_points, atol=4e-15 * offset)
