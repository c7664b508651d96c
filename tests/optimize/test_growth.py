"""Fits that ask for many variables: enough points for them, and a word where growth ends."""

from itertools import pairwise

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.objectives.distance import ContourDistance, PointDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.refine.candidates import Guards
from ffdstudio.optimize.runs.study import Budget, Refinement, Study
from ffdstudio.optimize.variables import metrics
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import DesignSpace, Insertion
from tests.optimize.cases import bumped, columns, section, task


def test_a_regular_fit_gets_four_points_a_variable(root):
    rae = str(root / "sample_meshes" / "rae2822.dat")
    result = ffd.fit("naca0012", rae, columns=100, adaptive=None)
    assert len(result.built.shape.points) >= 4 * result.variables == 800
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
        (Guards(), "2 points a variable are needed, and there are 61"),
        (
            Guards(points_per_variable=0.1),
            "a knot needs 2 points and 0.25% of the surface on both sides within its span",
        ),
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


def test_static_lattices_are_held_to_the_points_that_adaptive_ones_get():
    points = section(41)
    job = task(PointDistance(points), columns(21), points, "l2")
    with pytest.raises(InputError, match="42 variables need 2 points each, and the surface has 41"):
        Study(job, "gauss-newton").run()


def test_knots_do_not_pile_up_where_the_surface_has_no_room():
    """A cost that is all in the last thousandth of the chord."""
    points = section(401)
    kink = points + [0, 1e-3, 0] * (points[:, :1] > 0.999)
    settings = Refinement(variables=30)
    history = Study(
        task(PointDistance(kink), columns(5), points, "l2"), "gauss-newton", settings
    ).run()
    knots = np.unique(history.lattice(-1).knots[0])
    share = Surface.curve(points).mass
    between = [share[(points[:, 0] >= a) & (points[:, 0] <= b)].sum() for a, b in pairwise(knots)]
    assert min(between) >= 0.5 * settings.guards.least_share
    assert len(knots) > 5


def test_rows_whose_knots_differ_by_rounding_share_a_column():
    points = section(161)
    space = DesignSpace.of(columns(5), Rules())
    first = space.refined(Insertion(0, 0.84, 0))[0]
    both = first.refined(Insertion(0, np.nextafter(0.84, 1), 1))[0]
    assert both.size == first.size + 1
    assert both.rest.shape == first.rest.shape
    job = task(PointDistance(bumped(columns(20), points)), columns(5), points, "l2")
    settings = Refinement(variables=30, row_wise=True, insertions=30, relocate=True)
    history = Study(job, "gauss-newton", settings).run()
    gaps = np.diff(np.unique(history.lattice(-1).knots[0]))
    assert gaps.min() >= 0.9 * settings.guards.least_span
    assert history.iterates[-1].variables == 30


def test_a_fresh_metric_may_hold_fewer_directions_than_the_last(monkeypatch):
    """The rank guard drops some when knots are moved: what was reached is not lost."""
    points = section(121)

    class Fading(FlowTarget):
        asked = 0

        def response(self, points):
            self.asked += 1
            if self.asked == 2:
                monkeypatch.setattr(metrics, "RANK_TOLERANCE", 2e-2)
            return super().response(points)

    flow = Fading([2.0], FlowTarget.like(bumped(columns(20), points), [2.0]).pressure)
    job = task(flow, columns(5), points, "flow")
    history = Study(job, "lbfgs", Refinement.for_flows(24), Budget(evaluations=30)).run()
    assert flow.asked == 3
    costs = [record.cost for record in history.iterates]
    assert costs[-1] == min(costs) < 0.2 * costs[0]
