"""Faults that once survived: a comparison, signs of Gauss-Newton's model."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.optimize.methods.gauss_newton import Extra, QuadraticModel, _model
from ffdstudio.optimize.methods.problem import Trial
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.runs.study import Budget, Study
from tests.optimize.cases import bumped, columns, section, task

POINTS = section(81)
RNG = np.random.default_rng(7)


@pytest.mark.parametrize("method", ["lbfgs", "cg", "powell"])
@pytest.mark.parametrize("limit", [2, 3, 5, 8])
def test_what_is_kept_at_the_end_is_the_best_that_was_evaluated(method, limit):
    job = task(FlowTarget([2.0], lift=[0.9]), columns(6), POINTS)
    history = Study(job, method, budget=Budget(evaluations=limit)).run()
    costs = [record.cost for record in history.records if record.kind == "evaluation"]
    assert history.iterates[-1].cost == min(costs)
    assert len(costs) == limit


def test_a_worse_trial_is_never_better():
    from ffdstudio.optimize.budget import Counts
    from ffdstudio.optimize.catalog.metrics import metric_named
    from ffdstudio.optimize.methods.descent import Lbfgs
    from ffdstudio.optimize.runs.solver import LevelProblem
    from ffdstudio.optimize.variables.level import EmbeddedBody, Level
    from ffdstudio.optimize.variables.rules import Rules
    from ffdstudio.optimize.variables.space import DesignSpace

    job = task(PointDistance(bumped(columns(5), POINTS)), columns(5), POINTS, "l2")
    body = EmbeddedBody(job.embedding, job.surface, metric_named("l2"))
    level = Level.first(body, DesignSpace.of(columns(5), Rules()))
    problem = LevelProblem(level, job, Counts(), Lbfgs())
    low, high = Trial(np.zeros(level.size), 1.0), Trial(np.zeros(level.size), 2.0)
    assert problem.better(low, high)
    assert not problem.better(high, low)
    assert not problem.better(low, low)


class Stub:
    """A problem of a given extent, without meshes that follow."""

    extent = 2.0

    def control_cost(self, here):
        return None


def _trial(count=12, size=5):
    z = RNG.uniform(-1, 1, size)
    return Trial(
        z, 0.0, residuals=RNG.uniform(-1, 1, count), jacobian=RNG.uniform(-1, 1, (count, size))
    )


def test_a_step_of_the_model_is_that_of_least_squares():
    here = _trial()
    extra = Extra.of(Stub(), here, None)
    model = _model(here, extra)
    known = np.linalg.lstsq(here.jacobian, -here.residuals, rcond=None)[0]
    assert len(extra.rows) == 0
    assert model.step(0.0) == pytest.approx(known)
    damped = np.linalg.solve(
        here.jacobian.T @ here.jacobian + 0.3 * np.eye(5), -here.jacobian.T @ here.residuals
    )
    assert model.step(0.3) == pytest.approx(damped)


def test_a_displacement_that_costs_is_counted_from_where_it_is():
    here, cost = _trial(), RNG.uniform(-1, 1, (7, 5))
    extra = Extra.of(Stub(), here, cost)
    model = _model(here, extra)
    factor = float(np.sum(extra.rows**2) / np.sum(cost**2))

    def whole(step):
        after = here.residuals + here.jacobian @ step
        return 0.5 * after @ after + 0.5 * factor * np.sum((cost @ (here.z + step)) ** 2)

    step = model.step(0.0)
    matrix = here.jacobian.T @ here.jacobian + factor * cost.T @ cost
    right = -here.jacobian.T @ here.residuals - factor * cost.T @ cost @ here.z
    assert factor > 0
    assert step == pytest.approx(np.linalg.solve(matrix, right))
    assert model.decrease(step) == pytest.approx(whole(np.zeros(5)) - whole(step))
    half = 0.5 * step
    assert model.decrease(half) == pytest.approx(whole(np.zeros(5)) - whole(half))
    here.value = 0.5 * float(here.residuals @ here.residuals)
    assert extra.merit(here) == pytest.approx(whole(np.zeros(5)))


def test_a_model_keeps_its_step_within_the_radius():
    model = QuadraticModel.of(RNG.uniform(-1, 1, (9, 4)), RNG.uniform(-1, 1, 9))
    whole = np.linalg.norm(model.step(0.0))
    for share in (0.1, 0.5, 0.99):
        step = model.within(share * whole)
        assert share * whole * (1 - 1e-6) <= np.linalg.norm(step) <= share * whole
    assert np.array_equal(model.within(2 * whole), model.step(0.0))
