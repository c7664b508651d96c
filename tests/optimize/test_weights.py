import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.cli.main import main
from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints import Area, Constraint
from ffdstudio.optimize.methods.descent import Lbfgs
from ffdstudio.optimize.methods.slsqp import Slsqp
from ffdstudio.optimize.metrics.plain import Plain
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.runs.solver import Counts, LevelProblem
from ffdstudio.optimize.runs.study import Budget, Refinement, Study, Task
from ffdstudio.optimize.variables.level import EmbeddedBody
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.weights import Bounded, first_level
from tests.optimize.cases import columns, section

ALL = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
BOUNDS = (0.2, 6.0)
RULES = [
    Rules(weights=BOUNDS),
    Rules(directions=ALL, frozen=(1, 0, 0), weights=BOUNDS),
    Rules(directions=ALL, linked=(2,), weights=BOUNDS),
    Rules(directions=ALL, mirror=(1, (0.0, 1.0, 0.0)), weights=BOUNDS),
    Rules(directions=ALL, fixed=((2, 1, 1), (0, 0, 0)), weights=BOUNDS),
]
STEP = 1e-6


def central(function, z):
    steps = STEP * np.eye(z.size)
    return np.stack([(function(z + e) - function(z - e)) / (2 * STEP) for e in steps], axis=-1)


@pytest.mark.parametrize("rules", RULES)
def test_points_by_displacements_and_weights_agree_with_central_differences(rules):
    rng = np.random.default_rng(0)
    box = ffd.Lattice.box([0, 0, 0], [2, 1, 1], shape=(4, 3, 3), degrees=(3, 2, 1))
    box = box.moved(weights=rng.uniform(0.5, 2, box.shape))
    points = rng.uniform([0, 0, 0], [2.2, 1, 1], size=(40, 3))  # some are outside
    body = EmbeddedBody(ffd.embed(box, points), Surface.cloud(40), Plain())
    level = first_level(body, rules, None, ())
    np.testing.assert_allclose(level.at(np.zeros(level.size)), points, atol=1e-14)
    z = 0.03 * rng.normal(size=level.size)
    expected = central(level.at, z)
    shapes = level.shapes_at(z).reshape(40, 3, -1)
    np.testing.assert_allclose(shapes, expected, atol=1e-7 * abs(expected).max())
    gradient = rng.normal(size=(40, 3))
    pulled = np.einsum("nk,nkz->z", gradient, expected)
    np.testing.assert_allclose(level.pull(gradient, z), pulled, atol=1e-6 * abs(pulled).max())


def test_cost_penalty_and_constraints_agree_with_central_differences():
    points = section(81)
    lattice = columns(5)
    flow = FlowTarget.like(section(81) * [1, 1.1, 1], [2.0])
    task = Task(flow, ffd.embed(lattice, points), Surface.curve(points), Rules(weights=BOUNDS))
    task.constraints = [Constraint(Area(), lower=0.1)]
    level = first_level(EmbeddedBody(task.embedding, task.surface), task.rules, None, ())
    z = 0.01 * np.random.default_rng(3).normal(size=level.size)
    penalised = LevelProblem(level, task, Counts(), Lbfgs())
    expected = central(lambda z: penalised.value(z).value, z)
    np.testing.assert_allclose(
        penalised.gradient(z).slope, expected, atol=1e-5 * abs(expected).max()
    )
    strict = LevelProblem(level, task, Counts(), Slsqp())
    slopes = strict.constraints(z, "ineq")[1]
    expected = central(lambda z: strict.constraints(z, "ineq")[0], z)
    np.testing.assert_allclose(slopes, expected, atol=1e-6 * abs(expected).max())


@pytest.mark.parametrize("method", ["gauss-newton", "lbfgs"])
def test_a_shape_made_by_weights_is_found_by_weights_alone(method):
    points, lattice = section(161), columns(6)
    rng = np.random.default_rng(4)
    moved = lattice.control_points + [0, 0.03, 0] * rng.uniform(-1, 1, (*lattice.shape, 1))
    made = lattice.moved(moved, rng.uniform(0.7, 1.5, lattice.shape))
    target = PointDistance(ffd.embed(lattice, points).deform(made))

    def history(rules):
        job = Task(target, ffd.embed(lattice, points), Surface.curve(points), rules, metric="l2")
        return Study(job, method, budget=Budget(evaluations=400)).run()

    found, plain = history(Rules(weights=BOUNDS)), history(Rules())
    assert found.iterates[-1].variables == 24
    assert found.iterates[-1].cost < 1e-4 * plain.iterates[-1].cost
    for number in range(len(found.iterates)):
        weights = found.lattice(number).weights
        assert ((weights >= BOUNDS[0]) & (weights <= BOUNDS[1])).all()
    last = ffd.embed(lattice, points).deform(found.lattice(-1))
    cost = target.evaluate(last, False).value
    assert cost == pytest.approx(found.iterates[-1].cost, abs=1e-20)


def test_weights_stay_within_their_bounds_whatever_the_variables():
    start = np.array([0.3, 1.0, 5.0])
    chart = Bounded.around(start, *BOUNDS)
    assert (chart.at(np.zeros(3)) == start).all()
    np.testing.assert_allclose(chart.slope(np.zeros(3)), 1, rtol=1e-12)
    for y in (-1e9, -1.0, 2.0, 1e9):
        values = chart.at(np.full(3, y))
        assert ((values >= BOUNDS[0] * (1 - 1e-12)) & (values <= BOUNDS[1] * (1 + 1e-12))).all()


def test_what_weights_cannot_do_is_refused():
    points, lattice = section(81), columns(5)
    for bounds in ((0.0, 1.0), (2.0, 1.0), (1.0, np.inf)):
        with pytest.raises(InputError, match="0 < lower < upper"):
            Rules(weights=bounds)
    job = Task(
        PointDistance(points),
        ffd.embed(lattice, points),
        Surface.curve(points),
        Rules(weights=(2.0, 3.0)),
    )
    with pytest.raises(InputError, match="a weight is 1"):
        Study(job).run()
    with pytest.raises(InputError, match="without a refinement"):
        Study(job, refinement=Refinement())


CASE = """
[shape]
source = "naca0012"
points = 81
[lattice]
shape = [5, 2]
[variables]
weights = [0.5, 2.0]
[objective]
kind = "contour"
target = "naca2412"
[method]
name = "gauss-newton"
"""


def test_a_case_asks_for_weights(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(CASE)
    assert main(["optimize", str(case), "-o", str(tmp_path / "out"), "--json"]) == 0
    rest, current = ffd.read_lattice(tmp_path / "out" / "case.lattice.json")
    assert (rest.weights == 1).all()
    assert (current.weights != 1).any()
    assert ((current.weights >= 0.5) & (current.weights <= 2)).all()
    case.write_text(CASE.replace("[0.5, 2.0]", "[0.5]"))
    assert main(["optimize", str(case)]) == 2
