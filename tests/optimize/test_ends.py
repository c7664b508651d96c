"""How methods end by themselves: what they say must be true."""

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.objectives.function import PythonFunction
from ffdstudio.optimize.runs.study import Budget, Refinement, Study
from tests.optimize.cases import bumped, columns, section, task

POINTS = section(81)


class Misleading(Objective):
    """A distance whose derivatives point the wrong way: no step makes it less."""

    abilities = Abilities(residuals=True)

    def __init__(self, target):
        self.right = PointDistance(target)

    def answer(self, request):
        found = self.right.answer(request)
        return Evaluation(found.value, -found.gradient, found.residuals, -found.sensitivity)


@pytest.mark.parametrize("method", ["gauss-newton", "minimax", "lbfgs", "cg"])
def test_a_step_that_no_fraction_makes_better_is_told_as_stalled(method):
    objective = Misleading(bumped(columns(5), POINTS))
    history = Study(task(objective, columns(5), POINTS, "l2"), method).run()
    assert history.records[-1].note == "stalled"
    assert history.iterates[-1].cost == history.iterates[0].cost


@pytest.mark.parametrize("method", ["gauss-newton", "minimax", "lbfgs", "cg"])
def test_a_shape_that_meets_its_target_is_told_as_converged(method):
    for target in (POINTS, bumped(columns(5), POINTS)):
        job = task(PointDistance(target), columns(5), POINTS, "l2")
        history = Study(job, method).run()
        assert history.records[-1].note == "converged"
        assert np.sqrt(2 * history.iterates[-1].cost) <= 1e-5


def quadratic(points):
    gap = points[:, 1] - POINTS[:, 1] - 0.02 * POINTS[:, 0]
    return float(gap @ gap), np.column_stack([0 * gap, 2 * gap, 0 * gap])


def callable_of(change, gradient=True):
    """The quadratic with a change, and how often it was called."""
    calls = []

    def cost(points):
        calls.append(1)
        value, rows = change(len(calls), *quadratic(points))
        return (value, rows) if gradient else value

    return task(PythonFunction(cost, gradient), columns(5), POINTS)


GRADIENT_METHODS = ["cg", "lbfgs", "slsqp"]


@pytest.mark.parametrize("method", GRADIENT_METHODS)
def test_a_gradient_that_is_not_finite_is_refused(method):
    job = callable_of(lambda k, value, rows: (value, rows * np.nan))
    with pytest.raises(InputError, match="a gradient that is not finite"):
        Study(job, method, budget=Budget(evaluations=50)).run()
    job = callable_of(lambda k, value, rows: (value, rows * np.nan if k > 3 else rows))
    note = Study(job, method, budget=Budget(evaluations=50)).run().records[-1].note
    assert note in ("converged", "failed: the objective returned a gradient that is not finite")


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("method", [*GRADIENT_METHODS, "powell"])
def test_a_value_that_is_not_finite_shortens_the_step(method, bad):
    job = callable_of(lambda k, value, rows: (bad if k == 2 else value, rows))
    history = Study(job, method, budget=Budget(evaluations=300)).run()
    assert not history.records[-1].note.startswith("failed")
    assert history.iterates[-1].cost <= 1e-6 * history.iterates[0].cost


@pytest.mark.parametrize("gradient", [True, False])
@pytest.mark.parametrize("method", [*GRADIENT_METHODS, "powell"])
def test_a_cost_that_nothing_changes_has_converged(method, gradient):
    job = callable_of(lambda k, value, rows: (3.0, 0 * rows), gradient)
    history = Study(job, method, budget=Budget(evaluations=200)).run()
    assert history.records[-1].note == "converged"
    assert history.iterates[-1].cost == 3.0


@pytest.mark.parametrize("offset", [-1.0, -0.01, 1e6])
@pytest.mark.parametrize("method", [*GRADIENT_METHODS, "powell"])
def test_a_constant_beside_the_cost_changes_nothing(method, offset):
    job = callable_of(lambda k, value, rows: (value + offset, rows))
    history = Study(job, method, budget=Budget(evaluations=600)).run()
    gone = history.iterates[0].cost - history.iterates[-1].cost
    whole = quadratic(POINTS)[0]
    assert gone == pytest.approx(whole, rel=1e-5)


@pytest.mark.parametrize("offset", [0.0, -1.0, 1e3])
def test_a_slope_asks_for_a_refinement_whatever_the_sign_of_the_cost(offset):
    def cost(points):
        gap = points[:, 1] - POINTS[:, 1] - 0.02 * np.sin(9 * POINTS[:, 0])
        return float(gap @ gap) + offset, np.column_stack([0 * gap, 2 * gap, 0 * gap])

    job = task(PythonFunction(cost, True), columns(5), POINTS)
    history = Study(job, "lbfgs", Refinement(variables=20, slope=0.8)).run()
    first = next(k for k, r in enumerate(history.records) if r.kind == "refinement")
    assert sum(r.kind == "iterate" for r in history.records[:first]) <= 12
    assert history.iterates[-1].variables == 20
