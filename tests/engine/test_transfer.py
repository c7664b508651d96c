import numpy as np
import pytest
from scipy.interpolate import BSpline, insert

from ffdstudio.engine import transfer
from tests.engine.test_basis import KNOTS


@pytest.mark.parametrize("degree", KNOTS)
def test_insertion_equals_scipys(degree):
    knots = np.array(KNOTS[degree], dtype=float)
    points = np.random.default_rng(1).normal(size=len(knots) - degree - 1)
    tck = (knots, np.concatenate([points, np.zeros(degree + 1)]), degree)
    expected = insert(0.33, tck)
    finer, matrix = transfer.insertion(knots, degree, 0.33)
    np.testing.assert_array_equal(finer, expected[0])
    np.testing.assert_allclose(matrix @ points, expected[1][: len(matrix)], atol=1e-14)


@pytest.mark.parametrize("degree", KNOTS)
def test_insertion_is_a_mean_with_weights_that_are_not_negative(degree):
    knots = np.array(KNOTS[degree], dtype=float)
    _, matrix = transfer.insertion(knots, degree, [0.01, 0.33, 0.95])
    assert (matrix >= 0).all()
    np.testing.assert_allclose(matrix.sum(axis=1), 1, atol=1e-15)


@pytest.mark.parametrize("degree", KNOTS)
def test_elevation_keeps_the_curve(degree):
    knots = np.array(KNOTS[degree], dtype=float)
    points = np.random.default_rng(2).normal(size=len(knots) - degree - 1)
    higher, matrix = transfer.elevation(knots, degree)
    u = np.linspace(0, 1, 201)
    np.testing.assert_allclose(
        BSpline(higher, matrix @ points, degree + 1)(u),
        BSpline(knots, points, degree)(u),
        atol=1e-13,
    )


@pytest.mark.parametrize("degree", KNOTS)
def test_removal_undoes_insertion(degree):
    knots = np.array(KNOTS[degree], dtype=float)
    finer, there = transfer.insertion(knots, degree, [0.33, 0.77])
    coarser, back, again = transfer.removal(finer, degree, [0.33, 0.77])
    np.testing.assert_array_equal(coarser, knots)
    np.testing.assert_allclose(back @ there, np.eye(len(there.T)), atol=1e-12)
    np.testing.assert_allclose(again, there)
