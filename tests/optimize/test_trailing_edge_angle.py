"""The angle at the trailing edge of a section, as a constraint."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.optimize.constraints.trailing_edge_angle import TrailingEdgeAngle
from tests.optimize.cases import built, section

POINTS = section(81)
RNG = np.random.default_rng(2)
MOVES = 1e-3 * RNG.uniform(-1, 1, POINTS.shape) * [1, 1, 0]


def difference(function, points, step=1e-6):
    return (function(points + step * MOVES) - function(points - step * MOVES)) / (2 * step)


def test_the_angle_is_that_of_the_section_near_its_trailing_edge():
    x = np.array([0.95, 1.0])
    half = 0.6 * (0.2969 * x**0.5 - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    known = 2 * np.degrees(np.arctan((half[0] - half[1]) / 0.05))
    assert TrailingEdgeAngle(0.05)(section(801)).values[0] == pytest.approx(known, rel=1e-3)


@pytest.mark.parametrize("reach", [0.03, 0.05, 0.2])
def test_the_derivatives_of_the_angle_are_exact(reach):
    angle = TrailingEdgeAngle(reach)
    slope = angle(POINTS).derivatives @ MOVES.ravel()
    assert difference(lambda p: angle(p).values, POINTS) == pytest.approx(slope, rel=1e-6)


CASE = {
    "shape": {"source": "naca0012", "points": 121},
    "lattice": {"shape": [8, 2]},
    "objective": {"kind": "contour", "target": "naca0010"},
    "method": {"name": "slsqp"},
}


def test_a_fit_keeps_the_angle_of_its_trailing_edge(tmp_path):
    limit = {"kind": "trailing-edge-angle", "lower": 15.0}
    values = CASE | {"constraints": [limit], "budget": {"iterations": 60}}
    case = built(values, tmp_path)
    history = case.study.run()
    from ffdstudio import embed

    shape = embed(case.rest, case.shape.points).deform(history.lattice(-1))
    assert TrailingEdgeAngle()(shape).values[0] == pytest.approx(15.0, abs=1e-4)
    assert TrailingEdgeAngle()(section(121)).values[0] > 15.5
    assert history.iterates[-1].cost < 0.2 * history.iterates[0].cost
