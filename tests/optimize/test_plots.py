"""Plots show what they are about: nothing hides anything."""

import numpy as np
import pytest

from ffdstudio.optimize import plots
from ffdstudio.optimize.runs.record import Record, RunHistory
from tests.optimize.cases import columns, section

POINTS = section(161)


def lines(fig):
    return {line.get_label(): line for line in fig.axes[0].lines}


def test_the_target_of_pressures_is_seen_through():
    cp = np.sin(7 * POINTS[:, 0])
    curves = {
        "start": (POINTS[:, 0], 0 * cp),
        "target": (POINTS[:, 0], cp),
        "end": (POINTS[:, 0], cp),
    }
    found = lines(plots.pressures(curves, "target"))
    assert found["target"].get_linestyle() == "None"
    assert found["target"].get_markerfacecolor() == "none"
    assert found["end"].get_linestyle() == "-"
    x, y = found["target"].get_data()
    assert len(x) == plots.DOTS
    assert set(zip(x, y, strict=True)) <= set(zip(POINTS[:, 0], cp, strict=True))


@pytest.mark.parametrize("target", [None, "target"])
def test_no_legend_covers_a_section(target):
    curves = {"start": POINTS, "target": POINTS, "end": POINTS}
    fig = plots.outlines(curves, columns(9).control_points, target)
    fig.canvas.draw()
    (legend,) = fig.legends
    assert fig.axes[0].get_legend() is None
    assert not legend.get_window_extent().overlaps(fig.axes[0].get_window_extent())


def test_a_control_point_that_ran_away_does_not_make_the_sections_small():
    net = columns(9).control_points.copy()
    near = plots.outlines({"start": POINTS}, net).axes[0]
    net[0, :, 1] *= 50
    far = plots.outlines({"start": POINTS}, net).axes[0]
    assert far.get_ylim() == near.get_ylim()
    assert far.get_title() == "2 control points lie outside the picture"
    assert near.get_title() == ""


def test_axes_say_what_is_measured():
    history = RunHistory(
        [Record("iterate", k, k, 0, 4, 1.0, measures={"rms": 0.1}) for k in (1, 2)]
    )
    assert plots.convergence({"a": history}, "rms").axes[0].get_ylabel() == "RMS error"
    assert plots.convergence({"a": history}).axes[0].get_ylabel() == "cost"
