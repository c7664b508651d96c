import json
import threading

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints import Constraint, Lift, MaxThickness
from ffdstudio.optimize.flow.response import pressure_response
from ffdstudio.optimize.geometry.sections import target_contour
from ffdstudio.optimize.metrics.l2 import L2
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.refine.candidates import Guards, candidates
from ffdstudio.optimize.refine.indicators import GAIN
from ffdstudio.optimize.refine.sensitivity import Residuals
from ffdstudio.optimize.runs.record import read_log
from ffdstudio.optimize.runs.study import Budget, Refinement, Study
from ffdstudio.optimize.variables.level import EmbeddedBody, Level
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import DesignSpace, Insertion
from tests.optimize.cases import bumped, columns, section, task

POINTS = section(161)


@pytest.fixture(scope="module")
def flow(root):
    target = target_contour(str(root / "sample_meshes" / "rae2822.dat")).sample(161)
    return FlowTarget.like(target, [2.0])


def fitting(metric: str = "l2"):
    return task(PointDistance(bumped(columns(14), POINTS)), columns(5), POINTS, metric)


def test_gain_is_the_decrease_that_a_second_fit_finds():
    job = fitting()
    level = Level.first(
        EmbeddedBody(job.embedding, job.surface, L2()), DesignSpace.of(columns(5), Rules())
    )
    found = job.objective.evaluate(level.points)
    derivatives = level.columns(found.sensitivity)
    sensitivity = Residuals(level, found.residuals, derivatives)
    ranked = candidates(level, (0,), 2, False, Guards())
    gains = GAIN.scores(level, sensitivity, ranked)
    for candidate, gain in list(zip(ranked, gains, strict=True))[::2]:
        finer, _ = level.refined([candidate.insertion], np.zeros(level.size))
        left = [
            np.linalg.lstsq(derivatives @ lv.fields, found.residuals, rcond=None)[1][0]
            for lv in (level, finer)
        ]
        assert gain == pytest.approx(left[0] - left[1], rel=1e-6)


def test_a_refinement_changes_no_point_and_carries_steps_and_gradients_exactly(flow):
    level = Level.first(
        EmbeddedBody(ffd.embed(columns(6), POINTS), Surface.curve(POINTS)),
        DesignSpace.of(columns(6), Rules()),
    )
    z = 0.01 * np.random.default_rng(0).normal(size=level.size)
    finer, carried = level.refined([Insertion(0, 0.31), Insertion(0, 0.77)], z)
    np.testing.assert_array_equal(finer.points, level.at(z))
    step = np.random.default_rng(1).normal(size=level.size)
    np.testing.assert_allclose(finer.shapes @ (carried @ step), level.shapes @ step, atol=1e-9)
    surface = flow.evaluate(level.at(z)).gradient
    np.testing.assert_allclose(
        finer.pull(surface) @ carried, level.pull(surface), rtol=1e-7, atol=1e-12
    )


@pytest.mark.parametrize("method", ["lbfgs", "cg", "powell", "gauss-newton", "minimax", "slsqp"])
def test_every_method_finds_the_shape(method):
    job = task(PointDistance(bumped(columns(6), POINTS)), columns(6), POINTS, "l2")
    history = Study(job, method, budget=Budget(evaluations=3000)).run()
    assert history.iterates[-1].cost <= 1e-9 * history.iterates[0].cost


@pytest.mark.parametrize("indicator", ["gain", "interval", "gradient"])
@pytest.mark.parametrize("metric", ["l2", "h1", "none"])
def test_every_indicator_refines_without_a_rise(indicator, metric):
    settings = Refinement(indicator, variables=18, insertions=2)
    history = Study(fitting(metric), "gauss-newton", settings).run()
    cost = history.column("cost")
    assert history.iterates[-1].variables == 18
    assert (np.diff(cost) <= 1e-12 * cost[:-1]).all()


def test_two_runs_are_the_same_whatever_was_solved_before(flow):
    flow.evaluate(POINTS)  # with as many threads as BLAS likes
    runs = [
        Study(task(flow, columns(5), POINTS), "lbfgs", Refinement(variables=14, slope=0.8)).run()
        for _ in range(2)
    ]
    assert all(a.same(b) for a, b in zip(runs[0].records, runs[1].records, strict=True))


def test_a_stopped_study_resumes_to_the_same_end(flow, tmp_path):
    def study(folder, resume=False):
        settings = Refinement(variables=14, slope=0.8)
        job = task(flow, columns(5), POINTS)
        return Study(job, "lbfgs", settings, folder=folder, resume=resume)

    whole = study(tmp_path / "whole").run()
    part = study(tmp_path / "part")
    part.run(lambda record: part.stop() if record.evaluation == 12 else None)
    stopped = read_log(tmp_path / "part")
    assert stopped.records[-1].note == "stopped"
    with (tmp_path / "part" / "log.jsonl").open("ab") as log:
        log.write(b'{"kind":"evalu')  # what a killed process leaves behind
    study(tmp_path / "part", resume=True).run()
    resumed = read_log(tmp_path / "part")
    assert all(a.same(b) for a, b in zip(whole.records, resumed.records, strict=True))
    last = json.loads((tmp_path / "part" / "log.jsonl").read_bytes().splitlines()[-1])
    assert last["kind"] == "end"


def test_iterates_can_be_restored_from_the_log(flow, tmp_path):
    study = Study(task(flow, columns(5), POINTS), budget=Budget(iterations=4), folder=tmp_path)
    history = study.run()
    stored = read_log(tmp_path)
    assert stored.lattice(2) == history.lattice(2)
    points = ffd.embed(columns(5), POINTS).deform(stored.lattice(2))
    assert flow.evaluate(points, False).value == pytest.approx(stored.iterates[2].cost, rel=1e-8)


def test_a_study_pauses_and_steps_in_a_thread():
    study, seen, paused = (
        Study(fitting(), "gauss-newton", Refinement(variables=20)),
        [],
        threading.Event(),
    )

    def hear(record):
        if record.kind == "iterate":
            seen.append(record)
            if len(seen) == 2:
                study.pause()
                paused.set()

    thread = threading.Thread(target=study.run, args=(hear,))
    thread.start()
    assert paused.wait(20)
    count = len(seen)
    study.step()
    study.stop()
    thread.join(20)
    assert not thread.is_alive()
    assert count <= len(seen) <= count + 2


def test_a_stop_that_comes_before_anything_is_evaluated_leaves_the_start():
    study = Study(fitting())
    study.pause()
    study.stop()
    study.pause()  # as a window does that prepares a study for single steps
    history = study.run()
    assert [record.kind for record in history.records] == ["evaluation", "iterate", "end"]
    assert history.records[-1].note == "stopped"
    study.proceed()
    assert len(study.run().iterates) > 2  # the next run goes


def test_with_pressures_as_the_cost_adaptivity_beats_static_columns(flow):
    """Everybody in the flow's own metric, whose solves count."""

    def last(kind):
        return Study(task(flow, columns(20, kind), POINTS, "flow")).run()

    static = [last("greville"), last("cosine")]
    settings = Refinement.for_flows(40)
    adaptive = Study(task(flow, columns(5), POINTS, "flow"), "lbfgs", settings).run()
    assert adaptive.iterates[-1].variables <= 40
    best = min(history.iterates[-1].cost for history in static)
    assert best >= 8 * adaptive.iterates[-1].cost
    start = adaptive.iterates[0].cost
    spent = [
        record.flow + record.adjoint
        for history in (*static, adaptive)
        if (record := history.first_below(1e-4 * start)) is not None
    ]
    assert spent[-1] <= 1.1 * min(spent[:-1])


def test_the_flow_metric_makes_the_hessian_of_pressures_the_identity(flow):
    """Near a reachable target a step along the gradient is Newton's."""
    lattice = columns(10)
    reachable = FlowTarget.like(bumped(lattice, POINTS, 1e-4), [2.0])
    for metric, most in (("flow", 12), ("h1", 100)):
        history = Study(task(reachable, lattice, POINTS, metric)).run()
        found = history.first_below(1e-8 * history.iterates[0].cost)
        assert found is not None
        spent = found.flow + found.adjoint
        assert spent <= most
        if metric == "h1":
            assert spent > 24


def test_the_flow_metric_needs_a_flow_or_the_response_of_one():
    job = task(PointDistance(bumped(columns(8), POINTS)), columns(6), POINTS, "flow")
    with pytest.raises(InputError, match="metric flow needs"):
        Study(job).run()
    job.response = lambda points: pressure_response(points, [0.0])
    history = Study(job).run()
    assert history.iterates[0].flow == 4  # the flow, and three for its response
    assert history.iterates[-1].cost < 0.1 * history.iterates[0].cost


@pytest.mark.parametrize("count", [6, 12, 20])
def test_reachable_pressures_take_few_evaluations_whatever_the_number_of_variables(
    flow, root, count
):
    from ffdstudio.optimize.geometry.contour import upper_side
    from ffdstudio.optimize.objectives.distance import ContourDistance

    contour = target_contour(str(root / "sample_meshes" / "rae2822.dat"))
    distance = ContourDistance(contour, upper_side(POINTS))
    near = Study(task(distance, columns(count), POINTS, "l2"), "gauss-newton").run().lattice(-1)
    target = FlowTarget.like(ffd.embed(columns(count), POINTS).deform(near), [2.0])
    goal = 1e-6 * target.evaluate(POINTS).value
    job = task(target, columns(count), POINTS)
    history = Study(job, budget=Budget(evaluations=60, tolerance=goal)).run()
    assert history.records[-1].note == "tolerance reached"
    assert history.iterates[-1].evaluation <= 20


def test_lift_and_thickness_are_met_adaptively(flow):
    job = task(flow, columns(5), POINTS)
    job.constraints = [
        Constraint(Lift(2.0), 0.5, 0.5, "lift"),
        Constraint(MaxThickness(), lower=0.125, name="thickness"),
    ]
    settings = Refinement(variables=20, iterations=8)
    history = Study(job, "slsqp", settings, Budget(evaluations=400)).run()
    last = history.iterates[-1]
    assert history.records[-1].note == "converged"
    assert last.variables == 20
    assert max(v for k, v in last.measures.items() if k.startswith("violation")) <= 1e-8
    fixed = task(flow, columns(5), POINTS)
    fixed.constraints = job.constraints
    coarse = Study(fixed, "slsqp", budget=Budget(evaluations=200)).run()
    assert last.cost < coarse.iterates[-1].cost


def test_a_penalty_takes_the_place_of_constraints_for_other_methods(flow):
    job = task(flow, columns(6), POINTS)
    job.constraints = [Constraint(Lift(2.0), 0.6, 0.6, "lift")]
    job.penalty = 1e4
    last = Study(job, "lbfgs", budget=Budget(evaluations=100)).run().iterates[-1]
    assert last.measures["violation: lift"] <= 1e-3


def test_a_method_for_residuals_refuses_a_cost_without(flow):
    with pytest.raises(InputError, match="residuals"):
        Study(task(flow, columns(5), POINTS), "gauss-newton").run()
