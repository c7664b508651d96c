import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints import (
    Area,
    Constraint,
    Displacement,
    Lift,
    MaxThickness,
    Moment,
    NoseRadius,
    Thickness,
    Volume,
)  # fmt: skip
from ffdstudio.optimize.geometry.sections import sampled
from tests.optimize.cases import section

TETRA = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize(
    ("quantity", "points"),
    [
        (Area(), section(61)),
        (Thickness([0.2, 0.55]), sampled("naca2412", 61)),
        (MaxThickness(), section(61)),
        (NoseRadius(), section(61)),
        (Lift(2.0), section(61)),
        (Moment(2.0), section(61)),
        (Volume(TETRA), CORNERS),
        (Displacement(section(61), np.array([0.0, 1, 0])), section(61)),
    ],
)
def test_derivatives_agree_with_central_differences(quantity, points):
    rng = np.random.default_rng(3)
    bump = np.zeros_like(points)
    bump[:, 1] = rng.normal(size=len(points))
    if len(points) > 4:
        bump[:, 1] *= points[:, 0] * (1 - points[:, 0])
    values, rows = quantity(points)
    h = 1e-5
    differences = (quantity(points + h * bump).values - quantity(points - h * bump).values) / (
        2 * h
    )
    dense = rows.toarray() if hasattr(rows, "toarray") else np.asarray(rows)
    np.testing.assert_allclose(dense @ bump.ravel(), differences, rtol=1e-5, atol=1e-7)
    assert np.isfinite(values).all()


def test_values_agree_with_closed_forms():
    assert Volume(TETRA)(CORNERS).values[0] == pytest.approx(1 / 6)
    assert MaxThickness()(section(601)).values[0] == pytest.approx(0.12, abs=1e-4)
    assert NoseRadius()(section(2001)).values[0] == pytest.approx(1.1019 * 0.12**2, rel=0.02)


def test_limits_give_slacks_and_violations():
    points = section(61)
    area = Area()(points).values[0]
    assert Constraint(Area(), lower=area + 0.01).violation(points) == pytest.approx(0.01)
    assert Constraint(Area(), upper=area + 0.01).violation(points) == 0
    assert Constraint(Area(), area, area).kind == "eq"
    with pytest.raises(InputError, match="no limit"):
        Constraint(Area())
    with pytest.raises(InputError, match="exceeds"):
        Constraint(Area(), 2.0, 1.0)
