"""Constraints are measured once at a shape, derivatives only where they are wanted."""

import numpy as np
import pytest

from ffdstudio.optimize.budget import Counts
from ffdstudio.optimize.constraint_values import Slacks
from ffdstudio.optimize.constraints import Area, Constraint, Lift, MaxThickness, Moment
from ffdstudio.optimize.constraints.placed import InChords
from ffdstudio.optimize.flow import panel
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.runs.study import Budget, Study
from tests.optimize.cases import columns, section, task

POINTS = section(61)
LIMITS = (
    Constraint(Lift(2.0), 0.5, 0.5, "lift"),
    Constraint(Moment(2.0), lower=-0.1, name="moment"),
    Constraint(Area(), 0.01, 0.09, "area"),
)


@pytest.fixture
def solved(monkeypatch):
    """Factorisations and adjoint solves that are really made."""
    spent = {"flow": 0, "adjoint": 0}
    first, second = panel.PanelFlow.__init__, panel.PanelFlow.gradient

    def flow(self, *args):
        spent["flow"] += 1
        first(self, *args)

    def adjoint(self, *args, **options):
        spent["adjoint"] += 1
        return second(self, *args, **options)

    panel.forget_flows()
    monkeypatch.setattr(panel.PanelFlow, "__init__", flow)
    monkeypatch.setattr(panel.PanelFlow, "gradient", adjoint)
    return spent


def test_values_need_no_adjoint_and_one_flow(solved):
    slacks = Slacks(LIMITS, Counts())
    for _ in range(2):
        slacks.values(POINTS, "eq"), slacks.values(POINTS, "ineq"), slacks.violations(POINTS)
    assert solved == {"flow": 1, "adjoint": 0}
    assert (slacks.counts.flow, slacks.counts.adjoint) == (1, 0)
    for _ in range(2):
        slacks.rows(POINTS, "eq"), slacks.rows(POINTS, "ineq")
    assert solved == {"flow": 1, "adjoint": 2}
    assert (slacks.counts.flow, slacks.counts.adjoint) == (1, 2)


def test_slacks_are_those_of_the_constraints():
    slacks = Slacks(LIMITS, Counts())
    for kind in ("eq", "ineq"):
        parts = [c.slack(POINTS) for c in LIMITS if c.kind == kind]
        np.testing.assert_array_equal(
            slacks.values(POINTS, kind), np.concatenate([p.values for p in parts])
        )
        np.testing.assert_array_equal(
            slacks.rows(POINTS, kind), np.vstack([p.derivatives for p in parts])
        )
    assert slacks.violations(POINTS) == {c.name: c.violation(POINTS) for c in LIMITS}


def test_a_quantity_in_chords_gives_values_alone_too(solved):
    chord = Chord(1.0, 0.5, 2.0)
    far, near = InChords(Lift(3.0), chord), Lift(3.0)
    assert far.values(chord.world(POINTS)) == pytest.approx(near.values(POINTS))
    assert solved["adjoint"] == 0
    assert far.angles == (3.0,)
    assert InChords(Area(), chord).angles == ()


@pytest.mark.parametrize("method", ["slsqp", "lbfgs"])
@pytest.mark.parametrize("angle", [2.0, 4.0])
def test_the_record_counts_the_solves_that_were_made(solved, method, angle):
    job = task(FlowTarget([2.0], lift=[0.4], moment=[-0.05]), columns(5), POINTS)
    job.constraints = [
        Constraint(Lift(angle), lower=0.5, name="lift"),
        Constraint(MaxThickness(), lower=0.12, name="thickness"),
    ]
    last = Study(job, method, budget=Budget(evaluations=12)).run().records[-1]
    assert last.adjoint == solved["adjoint"]
    # another angle has the factors of the cost's flow, but its own solution
    made = solved["flow"] * (1 if angle == 2.0 else 2)
    # shapes are asked for again, the start with a gradient; the panel method remembers the latest
    assert 0 <= last.flow - made <= 2
