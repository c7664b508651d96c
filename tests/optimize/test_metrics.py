import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.metrics.h1 import H1
from ffdstudio.optimize.metrics.l2 import L2
from ffdstudio.optimize.variables.metrics import Surface, Whitening


def grid(n: int = 30) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.linspace(0, 2, n), np.linspace(0, 2, n), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = (v.ravel() for v in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def test_on_a_curve_the_metrics_are_the_integrals():
    x = np.linspace(0, 2, 4001)
    surface = Surface.curve(np.column_stack([x, 0 * x, 0 * x]))
    f = np.sin(3 * x)
    mean = np.trapezoid(f**2, x) / 2
    slope = 2**2 * np.trapezoid((3 * np.cos(3 * x)) ** 2, x) / 2
    assert np.sum((L2().factor(surface) @ f) ** 2) == pytest.approx(mean, rel=1e-6)
    assert np.sum((H1().factor(surface) @ f) ** 2) == pytest.approx(mean + slope, rel=1e-5)


def test_on_triangles_a_linear_function_has_its_exact_slope():
    points, triangles = grid()
    surface = Surface.triangles(points, triangles)
    f = 3 * points[:, 0] - 2 * points[:, 1]
    assert surface.mass.sum() == pytest.approx(1)
    assert np.sum((surface.slopes @ f) ** 2) == pytest.approx(2**2 * (9 + 4))


@pytest.mark.parametrize("plain", [False, True])
def test_whitened_variables_are_orthonormal_and_go_back(plain):
    rng = np.random.default_rng(0)
    basis = rng.normal(size=(40, 6)) @ np.diag([1, 10, 100, 1, 1, 1])
    white = Whitening.of(basis, plain)
    np.testing.assert_allclose(white.frame.T @ white.frame, np.eye(6), atol=1e-12)
    np.testing.assert_allclose(white.inverse @ white.matrix, np.eye(6), atol=1e-10)


def test_directions_that_the_surface_does_not_feel_are_dropped():
    basis = np.random.default_rng(1).normal(size=(40, 3))
    assert Whitening.of(np.hstack([basis, basis[:, :1], 0 * basis[:, :1]])).matrix.shape == (5, 3)
    with pytest.raises(InputError, match="no point"):
        Whitening.of(np.zeros((5, 2)))
