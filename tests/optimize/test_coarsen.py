import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints import Area, Constraint
from ffdstudio.optimize.geometry.sections import sampled
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.runs.study import Budget, Refinement, Study
from ffdstudio.optimize.variables.space import Insertion
from tests.optimize.cases import bumped, columns, section, task

POINTS = section(161)
NEEDED = [0.3, 0.6]
WITHOUT_USE = [0.15, 0.45, 0.8]


def inner(lattice):
    return lattice.knots[0][4:-4]


@pytest.mark.parametrize("line", [None, 1])
@pytest.mark.parametrize("metric", ["l2", "none"])
def test_knots_that_the_target_does_not_need_go_and_the_others_stay(line, metric):
    coarse = columns(4)
    target = bumped(coarse.insert_knots(0, NEEDED), POINTS)
    job = task(PointDistance(target), coarse, POINTS, metric)
    job.knots = [Insertion(0, knot) for knot in NEEDED]
    job.knots += [Insertion(0, knot, line) for knot in WITHOUT_USE]
    settings = Refinement(variables=8, coarsen=0.0)
    history = Study(job, "gauss-newton", settings, Budget(tolerance=1e-22)).run()
    np.testing.assert_array_equal(inner(history.lattice(-1)), NEEDED)
    assert history.iterates[-1].variables == 12
    assert history.iterates[-1].cost <= 1e-22


def test_the_cost_stays_within_the_tolerance_that_was_asked_for():
    def history(coarsen):
        job = task(PointDistance(bumped(columns(20), POINTS)), columns(5), POINTS, "l2")
        return Study(job, "gauss-newton", Refinement(variables=24, coarsen=coarsen)).run()

    full, fewer = history(None), history(0.5)
    reached = full.iterates[-1].cost
    assert fewer.iterates[-1].variables < full.iterates[-1].variables
    assert reached <= fewer.iterates[-1].cost <= 1.5 * reached
    assert set(inner(fewer.lattice(-1))) < set(inner(full.lattice(-1)))
    assert fewer.records[-1].note == full.records[-1].note == "converged"
    lattice = fewer.lattice(-1)
    assert fewer.iterates[-1].variables == 2 * lattice.shape[0]


def test_constraints_still_hold_on_the_coarser_lattice():
    target = FlowTarget.like(sampled("naca2412", 161), [2.0])
    job = task(target, columns(5), POINTS)
    job.constraints = [Constraint(Area(), lower=0.09, name="area")]
    settings = Refinement(variables=14, coarsen=1.0)
    history = Study(job, "slsqp", settings, Budget(evaluations=300)).run()
    assert history.iterates[-1].variables < 14
    assert history.iterates[-1].measures["violation: area"] <= 1e-8


def test_a_budget_spent_while_coarsening_keeps_what_was_reached():
    def history(evaluations=None):
        job = task(PointDistance(bumped(columns(20), POINTS)), columns(5), POINTS, "l2")
        settings = Refinement(variables=16, coarsen=10.0)
        return Study(job, "gauss-newton", settings, Budget(evaluations=evaluations)).run()

    removals = [r for r in history().records if r.note.startswith("removed")]
    short = history(removals[0].evaluation)
    assert short.records[-1].note == "evaluations spent"
    assert short.iterates[-1].variables == 16
    assert short.iterates[-1].cost == min(r.cost for r in short.iterates)


def test_a_negative_tolerance_is_refused():
    with pytest.raises(InputError, match="coarsen"):
        Refinement(coarsen=-0.1)
