import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import SHARP, PanelFlow
from ffdstudio.optimize.geometry.sections import opened, sampled
from tests.optimize.cases import section
from tests.optimize.closed_forms import Transformed

COUNTS = 1e-4  # of drag


def test_a_circle_has_the_pressures_of_the_closed_form():
    errors = []
    for count in (101, 201):
        angle = np.linspace(0, 2 * np.pi, count)
        flow = PanelFlow(np.column_stack([np.cos(angle), np.sin(angle)]), [0.0])
        exact = 1 - 4 * np.sin(np.angle(flow.middles)) ** 2
        errors.append(np.abs(flow.pressure[0] - exact).max())
    assert errors[1] < 1.5e-3
    assert errors[1] < 0.27 * errors[0]  # second order


@pytest.mark.parametrize("edge", [15.0, 5.0, 0.0])
@pytest.mark.parametrize("angle", [0.0, 5.0])
def test_the_flow_about_transformed_circles_is_that_of_the_closed_form(edge, angle):
    shape = Transformed(edge, angle)
    flow = PanelFlow(shape.nodes(161), [angle])
    assert flow.lift()[0] == pytest.approx(shape.lift, rel=4e-4)
    assert abs(flow.drag()[0]) < COUNTS
    theta = shape.theta(161)
    exact = 1 - shape.speed(0.5 * (theta[1:] + theta[:-1])) ** 2
    assert np.sqrt(np.mean((flow.pressure[0] - exact) ** 2)) < 2.5e-3


def test_lift_is_of_second_order():
    shape = Transformed(10.0, 0.0)
    errors = [PanelFlow(shape.nodes(n), [0.0]).lift()[0] / shape.lift - 1 for n in (81, 161, 321)]
    assert abs(errors[1]) < 0.27 * abs(errors[0])
    assert abs(errors[2]) < 0.27 * abs(errors[1])


def test_the_air_inside_is_at_rest():
    """By plain sums of point vortices and sources along the panels: another way to the same."""
    for points in (sampled("naca2412", 161), opened(sampled("naca2412", 161), 0.004)):
        flow, z = PanelFlow(points, [3.0]), points[:, 0] + 1j * points[:, 1]
        t = (np.arange(400) + 0.5) / 400
        places = z[:-1, None] + np.diff(z)[:, None] * t
        strengths = flow.vorticity[0, :-1, None] * (1 - t) + flow.vorticity[0, 1:, None] * t
        strengths = strengths * np.abs(np.diff(z))[:, None] / 400
        inside = np.array([0.2 + 0.01j, 0.4 + 0.03j, 0.6 + 0.02j])
        away = inside[:, None, None] - places
        velocity = np.exp(-1j * flow.angles) + (-0.5j / np.pi * strengths / away).sum(axis=(1, 2))
        base, speed = z[0] - z[-1], flow.vorticity[0, -1]
        source = speed * base.imag / (2 * np.pi)  # the bisector is nearly the x axis
        velocity = velocity + (source / (inside[:, None] - z[-1] - base * t) / 400).sum(axis=1)
        assert np.abs(velocity).max() < 2e-3


def test_an_edge_that_is_hardly_open_has_the_lift_of_a_sharp_one():
    sharp, open_ = (
        PanelFlow(opened(sampled("naca2412", 161), gap), [3.0]).lift()[0]
        for gap in (0.5 * SHARP, 2 * SHARP)
    )
    assert open_ == pytest.approx(sharp, rel=1e-3)


def test_an_open_trailing_edge_converges_with_the_panels():
    """NACA 0012 as published; without its base it would lose a percent at any number."""
    lifts = [PanelFlow(sampled_open(n), [4.0]).lift()[0] for n in (81, 161, 321)]
    assert abs(lifts[1] - lifts[2]) < 5e-4 * lifts[2]
    assert abs(lifts[1] - lifts[2]) < 0.4 * abs(lifts[0] - lifts[1])


def sampled_open(count: int) -> np.ndarray:
    return opened(section(count), 0.0025)


def test_the_bits_do_not_depend_on_threads():
    found = []
    for threads in (1, 2, 4):
        with threadpool_limits(threads):
            flow = PanelFlow(section(), [2.0])
            found.append((flow.pressure.tobytes(), flow.gradient(lift=np.ones(1)).tobytes()))
    assert found[0] == found[1] == found[2]


def test_a_symmetric_section_has_no_lift_or_moment_at_zero_incidence():
    flow = PanelFlow(section(), [0.0])
    assert abs(flow.lift()[0]) < 1e-11
    assert abs(flow.moment()[0]) < 1e-11


SHAPES = {
    "sharp": sampled("naca2412", 61),
    "open": opened(sampled("naca2412", 61), 0.004),
    "slanted": opened(sampled("naca2412", 61), 0.004, (1.0, 0.995)),
}


@pytest.mark.parametrize("shape", list(SHAPES))
@pytest.mark.parametrize("part", ["pressure", "lift", "moment"])
def test_the_adjoint_agrees_with_central_differences(part, shape):
    points, angles = SHAPES[shape], [0.0, 3.0]
    rng = np.random.default_rng(2)
    weight = rng.normal(size=(2, 60) if part == "pressure" else (2,))

    def functional(nodes: np.ndarray) -> float:
        flow = PanelFlow(nodes, angles)
        value = flow.pressure if part == "pressure" else getattr(flow, part)()
        return float((weight * value).sum())

    gradient = PanelFlow(points, angles).gradient(**{part: weight})
    # each node by a share of its distance to the next, so that the panels stay panels
    away = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1).min() + 0.02 * points[:, :1]
    step = np.column_stack([1e-3 * away * rng.normal(size=(61, 2)), np.zeros(61)])
    if shape == "sharp":
        step[-1] = step[0]
    h = 3e-2
    d1, d2 = (functional(points + k * step) - functional(points - k * step) for k in (h, 2 * h))
    assert (gradient * step[:, :2]).sum() == pytest.approx((8 * d1 - d2) / (12 * h), rel=1e-6)


@pytest.mark.parametrize("shape", list(SHAPES))
def test_the_jacobian_of_the_pressures_is_what_the_adjoint_sums(shape):
    flow = PanelFlow(SHAPES[shape], [0.0, 3.0])
    weight = np.random.default_rng(3).normal(size=(2, 60))
    summed = np.einsum("ak,akni->ni", weight, flow.pressure_jacobian())
    np.testing.assert_allclose(summed, flow.gradient(weight), atol=1e-11 * np.abs(summed).max())


def test_all_angles_at_once_are_the_same_as_one_by_one():
    both = PanelFlow(section(), [1.0, 4.0])
    for k, angle in enumerate((1.0, 4.0)):
        np.testing.assert_allclose(PanelFlow(section(), [angle]).speed[0], both.speed[k])


def test_neighbours_that_coincide_are_refused():
    points = section()
    points[3] = points[4]
    with pytest.raises(InputError, match="neighbours"):
        PanelFlow(points, [0.0])
