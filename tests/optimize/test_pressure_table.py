"""Pressures of a file are a target: by panel, by side, by angle, with weights."""

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.panel import PanelFlow
from ffdstudio.optimize.flow.pressure_table import panels, read_pressures
from ffdstudio.optimize.geometry.sections import sampled
from ffdstudio.optimize.objectives.flow import FlowTarget
from tests.optimize.cases import built, section

POINTS = section(161)


def table(path, points, angle, sides=True):
    flow = PanelFlow(points, [angle])
    x, upper = panels(points)
    lines = ["x,cp,side" if sides else "# x cp"]
    for one, cp, above in zip(x.tolist(), flow.pressure[0].tolist(), upper, strict=True):
        lines.append(f"{one},{cp},{'upper' if above else 'lower'}" if sides else f"{one} {cp}")
    path.write_text("\n".join(lines))
    return str(path)


@pytest.mark.parametrize("sides", [True, False])
def test_a_table_gives_back_what_is_in_it(tmp_path, sides):
    found = read_pressures(table(tmp_path / "cp.csv", POINTS, 2.0, sides))
    known = PanelFlow(POINTS, [2.0]).pressure[0]
    assert found.at(*panels(POINTS)) == pytest.approx(known, abs=1e-12)


def test_a_finer_table_agrees_with_the_flow_between_its_rows(tmp_path):
    found = read_pressures(table(tmp_path / "cp.csv", section(321), 2.0))
    gap = found.at(*panels(POINTS)) - PanelFlow(POINTS, [2.0]).pressure[0]
    assert np.sqrt(np.mean(gap**2)) < 0.02


def test_tables_at_several_angles_lead_to_the_section_that_they_are_of(tmp_path):
    target = sampled("naca2412", 161)
    files = [table(tmp_path / f"{angle}.csv", target, angle) for angle in (0.0, 4.0)]
    values = {
        "shape": {"source": "naca0012"},
        "lattice": {"shape": [8, 2]},
        "objective": {"kind": "flow", "angles": [0.0, 4.0], "pressures": files},
        "budget": {"evaluations": 80},
    }
    history = built(values, tmp_path).study.run()
    assert history.iterates[-1].cost < 1e-3 * history.iterates[0].cost
    values["objective"]["pressures"] = files[:1]
    with pytest.raises(InputError, match="2 angles need as many targets of pressure"):
        built(values, tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,cp\n1,0.2,up\n", r"line 2 of .*cp\.csv is no x"),
        ("1 0.2\n0.5 nan\n", r"line 2 of .*cp\.csv is no x"),
        ("7 0.2\n", r"line 1 of .*cp\.csv is no x"),
        ("", "upper side must have pressures"),
        ("1 0\n0.5 -1\n0 1\n", "lower side must have pressures"),
        ("1 0\n0.5 -1\n0 1\n0.5 0\n0.8 0\n", "lower side must have pressures from x = 0.05"),
        ("1,0,upper\n0,1\n", "name the side in each line or in none"),
        ("1 0\n1 0.1\n0 1\n0.5 0\n1 0\n", "two pressures at one x"),
    ],
)
def test_what_is_no_table_is_refused_with_its_line(tmp_path, text, message):
    path = tmp_path / "cp.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_pressures(path)


def test_weights_scale_the_terms_of_each_angle_and_the_gradient_follows():
    lift, moment, angles = [0.1, 0.5], [0.0, -0.1], [0.0, 3.0]
    pressure = PanelFlow(sampled("naca2412", 161), angles).pressure
    weights = {"pressure": [2.0, 0.0], "lift": [0.0, 3.0], "moment": [1.0, 0.5]}
    whole = FlowTarget(angles, pressure, lift, moment, weights)
    flow = PanelFlow(POINTS, angles)
    gaps = [flow.pressure - pressure, flow.lift() - lift, flow.moment() - moment]
    terms = [np.mean(gaps[0][0] ** 2), 3 * gaps[1][1] ** 2, gaps[2] ** 2 @ [1.0, 0.5]]
    expected = 0.5 * sum(terms)  # the mean is over both angles, so the weight 2 counts once
    found = whole.evaluate(POINTS)
    assert found.value == pytest.approx(expected)
    step = np.zeros_like(POINTS)
    step[:, 1] = 1e-5 * np.sin(np.pi * POINTS[:, 0])
    ahead, behind = (whole.evaluate(POINTS + d, False).value for d in (step, -step))
    assert (found.gradient * step).sum() == pytest.approx((ahead - behind) / 2, rel=1e-5)
