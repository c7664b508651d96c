"""Fits that ask for many variables: enough points for them, and a word where growth ends."""

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.objectives.distance import ContourDistance, PointDistance
from ffdstudio.optimize.refine.candidates import Guards
from ffdstudio.optimize.runs.study import Refinement, Study
from tests.optimize.cases import bumped, columns, section, task


def test_a_regular_fit_gets_four_points_a_variable(root):
    rae = str(root / "sample_meshes" / "rae2822.dat")
    result = ffd.fit("naca0012", rae, columns=100, adaptive=None)
    assert len(result.task.section.points) >= 4 * result.variables == 800
    assert result.max_error < 1e-5


def test_more_variables_than_can_be_judged_are_refused(root):
    with pytest.raises(InputError, match="at most 500 variables, not 800"):
        ffd.fit("naca0012", "naca2412", columns=400, adaptive=None)
    skin = root / "sample_meshes" / "wing_skin.vtu"
    with pytest.raises(InputError, match="1120 points of the source suffice for 280"):
        ffd.fit(skin, skin, columns=10, rows=10, adaptive=None)


def test_three_rows_leave_the_control_points_near(root):
    points = section(301)
    camber = points + [0, 0.12, 0] * (points[:, :1] * (1 - points[:, :1])) ** 0.7
    objective = ContourDistance(Contour.through(camber), upper_side(points))
    job = task(objective, columns(35, rows=3), points, "l2")
    history = Study(job, "gauss-newton").run()
    assert np.sqrt(2 * history.iterates[-1].cost) < 3e-5
    step = history.lattice(-1).control_points - columns(35, rows=3).control_points
    assert np.abs(step).max() < 1.5


@pytest.mark.parametrize(
    ("guards", "reason"),
    [
        (Guards(), "4 points a variable are needed, and there are 61"),
        (Guards(points_per_variable=0.1), "a knot needs 2 points on both sides within its span"),
    ],
)
def test_a_guard_that_ends_growth_is_named(guards, reason):
    points = section(61)
    job = task(PointDistance(bumped(columns(30), points)), columns(5), points, "l2")
    history = Study(job, "gauss-newton", Refinement(variables=100, guards=guards)).run()
    last = history.iterates[-1]
    assert last.variables < 100
    assert history.records[-1].note.endswith(
        f"growth ended at {last.variables} of 100 variables: {reason}"
    )
