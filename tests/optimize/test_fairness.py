"""Fair sections: the variation of the curvature beside the distance."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.objectives.fairness import Curvature, FairContour
from tests.optimize.cases import built, section

POINTS = section(81)
RNG = np.random.default_rng(2)
MOVES = 1e-3 * RNG.uniform(-1, 1, POINTS.shape) * [1, 1, 0]


def difference(function, points, step=1e-6):
    return (function(points + step * MOVES) - function(points - step * MOVES)) / (2 * step)


CASE = {
    "shape": {"source": "naca0012", "points": 121},
    "lattice": {"shape": [8, 2]},
    "objective": {"kind": "contour", "target": "naca0010"},
    "method": {"name": "slsqp"},
}


def test_curvature_is_that_of_circles_and_has_exact_derivatives():
    angle = np.linspace(0.3, 2, 30)
    circle = 3 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert Curvature.of(circle).values == pytest.approx(np.full(28, 1 / 3))
    bend = Curvature.of(POINTS)
    rows = sum(
        np.einsum("ij,ij->i", bend.rows[:, k], MOVES[k : len(POINTS) - 2 + k, :2]) for k in range(3)
    )
    assert difference(lambda p: Curvature.of(p).values, POINTS) == pytest.approx(rows, rel=1e-4)


def test_the_gradient_of_a_fair_cost_is_exact():
    target = Contour(section(201) * [1, 1.2, 1])
    cost = FairContour(target, upper_side(POINTS), 1e-6, 0.05)
    slope = float(np.sum(cost.evaluate(POINTS).gradient * MOVES))
    assert difference(lambda p: cost.evaluate(p).value, POINTS) == pytest.approx(slope, rel=1e-5)


def test_a_wavy_target_is_met_more_fairly_with_a_weight(tmp_path):
    wavy = section(201)
    wavy[:, 1] += 4e-4 * np.sin(40 * wavy[:, 0]) * wavy[:, 0] * (1 - wavy[:, 0])
    lines = [" ".join(map(repr, row)) for row in wavy[:, :2].tolist()]
    (tmp_path / "wavy.dat").write_text("wavy\n" + "\n".join(lines) + "\n")
    rough = []
    for weight in (0.0, 1e-8):
        goal = {"kind": "fair-contour", "target": "wavy.dat", "weight": weight}
        values = CASE | {"objective": goal, "method": {"name": "gauss-newton"}}
        values["lattice"] = {"shape": [30, 2]}
        values["shape"] = {"source": "naca0012", "points": 201}
        case = built(values, tmp_path)
        last = case.study.run().iterates[-1]
        from ffdstudio import embed

        points = embed(case.rest, case.shape.points).deform(case.study.history.lattice(-1))
        fair = FairContour(Contour(wavy), upper_side(points), 1.0, 0.05)
        rough.append(float(np.linalg.norm(fair.variation(points)[0])))
        assert last.measures["rms"] < 1e-3
    assert rough[1] < 0.5 * rough[0]
