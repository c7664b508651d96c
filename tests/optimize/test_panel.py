import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import PanelFlow
from ffdstudio.optimize.geometry.sections import sampled
from tests.optimize.cases import section


def karman_trefftz(count: int, edge: float = 15.0) -> tuple[np.ndarray, float]:
    """Section with a trailing edge of so many degrees, and its CL times the chord at 5 degrees."""
    centre, power = -0.08 + 0.06j, 2 - edge / 180
    radius, start = abs(1 - centre), np.angle(1 - centre)
    zeta = centre + radius * np.exp(1j * (start + np.linspace(0, 2 * np.pi, count)))
    a, b = (1 + 1 / zeta) ** power, (1 - 1 / zeta) ** power
    z = power * (a + b) / (a - b)
    z[[0, -1]] = power
    lift = 8 * np.pi * radius * np.sin(np.radians(5.0) - start)
    return np.column_stack([z.real, z.imag]), lift


def test_a_circle_has_the_pressures_of_the_closed_form():
    errors = []
    for count in (101, 201):
        angle = np.linspace(0, 2 * np.pi, count)
        flow = PanelFlow(np.column_stack([np.cos(angle), np.sin(angle)]), [0.0])
        exact = 1 - 4 * np.sin(np.angle(flow.middles)) ** 2
        errors.append(np.abs(flow.pressure[0] - exact).max())
    assert errors[1] < 0.03
    assert errors[1] < 0.52 * errors[0]  # first order


def test_lift_of_a_karman_trefftz_section_is_that_of_the_closed_form():
    for count, accuracy in ((101, 1e-2), (201, 5e-3), (401, 2.5e-3)):
        points, lift = karman_trefftz(count)
        assert PanelFlow(points, [5.0]).lift()[0] == pytest.approx(lift, rel=accuracy)


def test_a_symmetric_section_has_no_lift_or_moment_at_zero_incidence():
    flow = PanelFlow(section(), [0.0])
    assert abs(flow.lift()[0]) < 1e-11
    assert abs(flow.moment()[0]) < 1e-11


@pytest.mark.parametrize("part", ["pressure", "lift", "moment"])
def test_the_adjoint_agrees_with_central_differences(part):
    points, angles = sampled("naca2412", 61), [0.0, 3.0]
    rng = np.random.default_rng(2)
    shape = (2, 60) if part == "pressure" else (2,)
    weight = rng.normal(size=shape)

    def functional(nodes: np.ndarray) -> float:
        flow = PanelFlow(nodes, angles)
        value = flow.pressure if part == "pressure" else getattr(flow, part)()
        return float((weight * value).sum())

    gradient = PanelFlow(points, angles).gradient(**{part: weight})
    bump = np.sin(np.linspace(0, np.pi, 61))[:, None] * rng.normal(size=(61, 2))
    step = np.column_stack([1e-3 * bump, np.zeros(61)])
    h = 1e-2
    d1, d2 = (functional(points + k * step) - functional(points - k * step) for k in (h, 2 * h))
    assert (gradient * step[:, :2]).sum() == pytest.approx((8 * d1 - d2) / (12 * h), rel=1e-6)


def test_all_angles_at_once_are_the_same_as_one_by_one():
    both = PanelFlow(section(), [1.0, 4.0])
    for k, angle in enumerate((1.0, 4.0)):
        np.testing.assert_allclose(PanelFlow(section(), [angle]).speed[0], both.speed[k])


def test_neighbours_that_coincide_are_refused():
    points = section()
    points[3] = points[4]
    with pytest.raises(InputError, match="neighbours"):
        PanelFlow(points, [0.0])
