"""How methods end by themselves: what they say must be true."""

import numpy as np
import pytest

from ffdstudio.optimize.objectives.base import Evaluation
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.study import Study
from tests.optimize.cases import bumped, columns, section, task

POINTS = section(81)


class Misleading:
    """A distance whose derivatives point the wrong way: no step makes it less."""

    differentiable = True

    def __init__(self, target):
        self.right = PointDistance(target)

    def evaluate(self, points, gradient=True):
        found = self.right.evaluate(points)
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
