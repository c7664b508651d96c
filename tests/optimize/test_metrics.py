import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import PanelFlow
from ffdstudio.optimize.flow.response import SectionResponse, pressure_response
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.geometry.sections import sampled
from ffdstudio.optimize.metrics.flow import Flow
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


@pytest.mark.parametrize("length", [1.0, 2.5])
def test_the_response_of_a_section_in_a_mesh_is_that_of_its_points(length):
    """The trailing edge is one node, and stands at both ends of the contour."""
    section = sampled("naca2412", 61)
    chord = Chord(3.0, 1.0, length)
    mesh = np.vstack([[[9.0, 9, 0]], chord.world(section[:-1]), [[5.0, 5, 0]]])
    contour = np.append(np.arange(1, 61), 1)
    found = SectionResponse((2.0,), chord, contour)(mesh)
    rng = np.random.default_rng(1)
    moves = np.zeros((62, 3))
    moves[1:61, :2] = 1e-7 * rng.normal(size=(60, 2))
    flows = [
        PanelFlow(chord.local((mesh + side * moves)[contour]), [2.0]).pressure[0]
        for side in (1, -1)
    ]
    wanted = (flows[0] - flows[1]) / 2 / np.sqrt(60)
    np.testing.assert_allclose(found.matrix @ moves.ravel(), wanted, rtol=1e-4, atol=1e-9)
    assert abs(found.matrix[:, [0, 1, 183, 184]]).max() == 0


def test_the_flow_metric_adds_a_share_of_h1():
    points = sampled("naca0012", 41)
    response = pressure_response(points, [0.0, 3.0]).matrix
    surface = Surface.curve(points)._replace(response=response)
    factor = Flow().measure(surface, np.array([1])).toarray()
    pressures, smooth = factor[:80], factor[80:]
    np.testing.assert_array_equal(pressures, response[:, 1::3])
    assert np.linalg.norm(smooth, 2) == pytest.approx(1e-2 * np.linalg.norm(pressures, 2))
    with pytest.raises(InputError, match="do not move the section"):
        Flow().measure(surface, np.array([2]))
