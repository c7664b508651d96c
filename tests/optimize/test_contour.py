import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.contour import OVERLAP, Contour, cosine_abscissae
from ffdstudio.optimize.geometry.sections import sampled


def test_nearest_points_agree_with_a_dense_search():
    contour = Contour(sampled("naca2412", 201))
    rng = np.random.default_rng(0)
    upper = rng.random(50) < 0.5
    s = np.where(upper, 0.9 * contour.nose * rng.random(50), 0)
    s = np.where(upper, s, contour.nose + (contour.length - contour.nose) * rng.random(50))
    points = contour.spline(s) + rng.normal(scale=5e-3, size=(50, 2))
    fine = np.linspace(0, contour.length, 400_001)
    curve = contour.spline(fine)
    distance = contour.nearest(points, upper).distance
    for point, side, found in zip(points, upper, distance, strict=True):
        over = OVERLAP * contour.length  # the sides overlap around the nose
        part = fine <= contour.nose + over if side else fine >= contour.nose - over
        assert abs(found) == pytest.approx(
            np.linalg.norm(curve[part] - point, axis=1).min(), abs=2e-8
        )


def test_the_derivative_of_the_distance_agrees_with_differences():
    contour = Contour(sampled("naca2412", 201))
    points = sampled("naca0012", 41)[:, :2] + [0.003, 0.001]
    upper = cosine_abscissae(41)[1]
    foot = contour.nearest(points, upper)
    for k in range(2):
        step = np.eye(2)[k] * 1e-6
        ahead, behind = (contour.nearest(points + d, upper).distance for d in (step, -step))
        np.testing.assert_allclose(foot.direction[:, k], (ahead - behind) / 2e-6, atol=1e-5)


def test_a_point_on_one_surface_never_jumps_to_the_other():
    contour = Contour(sampled("naca0006", 201))
    below = np.array([[0.99, -0.002]])
    as_upper = contour.nearest(below, np.array([True])).distance[0]
    as_lower = contour.nearest(below, np.array([False])).distance[0]
    assert abs(as_upper) > 2 * abs(as_lower)


def test_normalised_contours_have_their_least_x_at_zero():
    contour = Contour(2.5 * sampled("naca4412", 101)[:, :2] + [3.0, 1.0])
    fine = contour.spline(np.linspace(0, contour.length, 20_001))
    assert -1e-12 < fine[:, 0].min() < 1e-8
    assert max(contour.spline([0.0, contour.length])[:, 0]) == pytest.approx(1)


@pytest.mark.parametrize("points", [np.zeros((3, 2)), np.eye(5)[:, :2], np.full((9, 2), np.nan)])
def test_points_that_are_no_contour_are_refused(points):
    with pytest.raises(InputError):
        Contour(points)


@pytest.mark.parametrize("far", [-1e308, 1e200, 1e40])
def test_a_section_with_a_point_out_of_this_world_is_one_sentence(far):
    points = sampled("naca0012", 41)
    points[7, 0] = far
    with pytest.raises(InputError):
        Contour(points)
