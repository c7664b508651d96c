"""A trust-region method of SciPy under constraints."""

from __future__ import annotations

import pytest

from tests.optimize.cases import built

CASE = {
    "shape": {"source": "naca0012", "points": 121},
    "lattice": {"shape": [8, 2]},
    "objective": {"kind": "contour", "target": "naca0010"},
    "method": {"name": "slsqp"},
}


def test_a_trust_region_reaches_what_slsqp_does(tmp_path):
    goal = {"kind": "flow", "angles": [2.0], "target": "naca2412"}
    ends = []
    for name in ("slsqp", "trust-region"):
        values = CASE | {
            "objective": goal, "method": {"name": name}, "lattice": {"shape": [5, 2]},
            "constraints": [{"kind": "lift", "angle": 2.0, "equal": 0.35}],
            "budget": {"iterations": 60},
        }  # fmt: skip
        last = built(values, tmp_path).study.run().iterates[-1]
        assert last.measures["violation: lift"] < 1e-6
        ends.append(last.cost)
    assert ends[1] == pytest.approx(ends[0], rel=0.05)
