import numpy as np
import pytest
from scipy.interpolate import BSpline

from ffdstudio.engine.basis import basis

KNOTS = {
    1: [0, 0, 0.3, 0.7, 1, 1],
    2: [0, 0, 0, 0.25, 0.6, 1, 1, 1],
    3: [0, 0, 0, 0, 0.2, 0.5, 0.5, 0.9, 1, 1, 1, 1],
    5: [0] * 6 + [0.1, 0.4, 0.4, 0.8] + [1] * 6,
    10: [0] * 11 + [0.5] + [1] * 11,
}


@pytest.mark.parametrize("degree", KNOTS)
@pytest.mark.parametrize("derivative", [0, 1, 2])
def test_functions_and_derivatives_equal_those_of_scipy(degree, derivative):
    knots = np.array(KNOTS[degree], dtype=float)
    u = np.sort(np.random.default_rng(degree).uniform(size=50))
    count = len(knots) - degree - 1
    expected = np.zeros((50, count))
    for i in range(count):
        spline = BSpline(knots, np.eye(count)[i], degree)
        if derivative <= degree:
            expected[:, i] = spline.derivative(derivative)(u) if derivative else spline(u)
    first, values = basis(knots, degree, u, derivative)
    full = np.zeros_like(expected)
    np.put_along_axis(full, first[:, None] + np.arange(degree + 1), values, axis=1)
    np.testing.assert_allclose(full, expected, atol=1e-13 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize("degree", KNOTS)
def test_functions_are_positive_and_sum_to_one_also_on_the_ends(degree):
    _, values = basis(np.array(KNOTS[degree], dtype=float), degree, np.linspace(0, 1, 101))
    assert (values >= 0).all()
    np.testing.assert_allclose(values.sum(axis=1), 1, atol=1e-15 * (degree + 2))
