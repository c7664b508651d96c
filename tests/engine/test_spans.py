import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffdstudio.engine import Lattice
from ffdstudio.engine.direction import Direction
from ffdstudio.engine.polynomials import Places, PolynomialCells
from ffdstudio.engine.spans import SpanOrder


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 300))
def test_every_inside_point_stands_in_its_cell(seed, count):
    rng = np.random.default_rng(seed)
    box = Lattice.box([0, 0], [1, 1], (6, 4), (3, 2))
    u = np.round(rng.random((count, 2)) * 12) / 12
    inside = rng.random(count) < 0.7
    order = SpanOrder(box, u, inside)
    assert np.array_equal(order.parameters()[inside], u[inside])
    assert np.isnan(order.parameters()[~inside]).all()
    ends = PolynomialCells.of(box, order.places).ends
    for cell in range(order.cells):
        part = order.u[:, order.starts[cell] : order.starts[cell + 1]]
        low, high = ends[:, 0, cell][:, None], ends[:, 1, cell][:, None]
        assert part.shape[1] > 0
        assert ((part == low) & (low == high) | (part > low) & (part < high)).all()


def test_parameters_come_back_from_many_chunks():
    rng = np.random.default_rng(0)
    u = rng.random((100_000, 3))
    few = Lattice.box([0, 0, 0], [1, 1, 1], (5, 4, 4))
    many = Lattice.box([0, 0, 0], [1, 1, 1], (20, 20, 20))
    for box, kind in ((few, np.uint16), (many, np.uint32)):
        order = SpanOrder(box, u, np.ones(len(u), bool))
        assert np.array_equal(order.parameters(), u)
        assert order.order.dtype == kind


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 7, 10])
def test_the_polynomials_of_a_span_are_its_basis_functions(degree):
    from scipy.interpolate import BSpline

    rng = np.random.default_rng(degree)
    inner = np.sort(np.append(rng.random(4), [0.5, 0.5][: min(degree, 2)]))
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    places = Places.of(Direction.checked(knots, degree, len(knots) - degree - 1))
    for control, matrix, (low, high) in zip(*places, strict=True):
        u = np.linspace(low, high, 50)[:-1] if high > low else np.array([low])
        t = ((u - low) - (high - u)) / (high - low) if high > low else np.zeros(1)
        ours = np.polynomial.polynomial.polyvander(t, degree) @ matrix
        expected = BSpline.design_matrix(u, knots, degree).toarray()
        expected = expected[:, control]
        assert np.abs(ours - expected).max() < 2e-14
