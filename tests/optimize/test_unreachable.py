"""Constraints that cannot be met: the study must say so."""

import pytest

from ffdstudio.optimize.constraints import Area, Constraint, MaxThickness
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.runs.study import Budget, Refinement, Study
from tests.optimize.cases import columns, section, task

POINTS = section(81)


@pytest.fixture
def contradictory():
    job = task(FlowTarget([2.0], lift=[0.4]), columns(5), POINTS)
    job.constraints = [
        Constraint(MaxThickness(), lower=0.2, name="thick"),
        Constraint(MaxThickness(), upper=0.1, name="thin"),
    ]
    return job


@pytest.mark.parametrize("refinement", [None, Refinement(variables=14, iterations=4)])
def test_constraints_that_contradict_each_other_are_told_as_not_met(contradictory, refinement):
    history = Study(contradictory, "slsqp", refinement, Budget(evaluations=400)).run()
    assert "constraints not met" in history.records[-1].note
    assert not history.records[-1].note.startswith("converged")


def test_an_end_on_the_box_that_keeps_programs_sane_is_told():
    job = task(FlowTarget([2.0], lift=[0.4]), columns(5), POINTS)
    job.constraints = [Constraint(Area(), lower=0.35, name="area")]  # four times the section's
    history = Study(job, "slsqp", budget=Budget(evaluations=400)).run()
    assert history.records[-1].note.startswith("stalled: the shape has moved as far")
