"""Finite differences: a few programs at a time, each kept, counted, recorded and stoppable."""

import json
import os
import sys
import threading
import time

import numpy as np
import pytest

from ffdstudio.optimize.control import Stopped
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request
from ffdstudio.optimize.objectives.failures import EvaluationError
from ffdstudio.optimize.objectives.program import ExternalProgram
from ffdstudio.optimize.objectives.remembered import Remembered
from ffdstudio.optimize.objectives.stream import streamed
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.runs.record import read_log
from ffdstudio.optimize.runs.study import Budget, Study
from tests.optimize.cases import columns, section, task

POINTS = section(41)
SQUARES = """
import json
rows = [[float(w) for w in r.split(",")] for r in open("points.csv")]
json.dump({"value": sum((r[1] - 0.1 * r[0]) ** 2 for r in rows)}, open("result.json", "w"))
"""
CHILD = """
import subprocess, sys
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
open("../child", "w").write(str(child.pid))
child.wait()
"""


def program(tmp_path, text=SQUARES, **options):
    script = tmp_path / "solver.py"
    script.write_text(text)
    return ExternalProgram([sys.executable, str(script)], tmp_path / "runs", **options)


def runs(tmp_path):
    return sorted((tmp_path / "runs").iterdir())


def gone(pid):
    """Whether a process has ended; a zombie that nobody has waited for counts."""
    for _ in range(100):
        try:
            os.kill(pid, 0)
            if os.path.exists(f"/proc/{pid}/stat"):  # noqa: PTH110
                with open(f"/proc/{pid}/stat") as stat:  # noqa: PTH123
                    if stat.read().rpartition(")")[2].split()[0] == "Z":
                        return True
        except OSError:
            return True
        time.sleep(0.05)
    return False


class Slow(Objective):
    """Counts which shapes were asked for, and how many were made before."""

    abilities = Abilities(gradient=False)

    def answer(self, request):
        return Evaluation(float(request.points[0, 0]))


def test_shapes_are_made_when_there_is_room_for_them():
    made = []

    def jobs():
        for k in range(6):
            made.append(k)
            yield Request(np.full((1, 3), float(k)), False)

    ahead = [len(made) - k for k, _ in enumerate(streamed(Slow(), jobs()))]
    assert max(ahead) <= 2


def test_a_budget_of_evaluations_starts_no_more_programs(tmp_path):
    job = task(program(tmp_path, processes=2), columns(4), POINTS)
    history = Study(job, budget=Budget(evaluations=5)).run()
    assert len(runs(tmp_path)) == 5
    assert history.records[-1].note == "evaluations spent"
    assert history.records[-1].evaluation == 5


def test_each_program_of_the_differences_gets_its_own_variables_and_is_recorded(tmp_path):
    job = task(program(tmp_path, processes=2), columns(4), POINTS)
    study = Study(job, budget=Budget(iterations=1), folder=tmp_path / "study")
    study.run()
    told = [json.loads((run / "variables.json").read_text())["variables"] for run in runs(tmp_path)]
    assert len({tuple(variables) for variables in told[:9]}) == 9
    records = [r for r in read_log(tmp_path / "study").records if r.kind == "evaluation"]
    assert len(records) == len(told)
    assert sorted(r.y for r in records) == sorted(told)
    assert [r.evaluation for r in records] == list(range(1, len(told) + 1))


def test_the_variables_that_a_program_gets_are_those_of_its_shape(tmp_path):
    job = task(program(tmp_path), columns(4), POINTS)
    study = Study(job, budget=Budget(evaluations=9))
    study.run()
    place = runs(tmp_path)[4]
    from ffdstudio.optimize.variables.level import EmbeddedBody, Level
    from ffdstudio.optimize.variables.rules import Rules
    from ffdstudio.optimize.variables.space import DesignSpace

    level = Level.first(
        EmbeddedBody(job.embedding, job.surface), DesignSpace.of(columns(4), Rules())
    )
    y = np.array(json.loads((place / "variables.json").read_text())["variables"])
    shape = np.loadtxt(place / "points.csv", delimiter=",")
    moved = POINTS.copy()
    moved[:, 1] += level.fields @ y
    np.testing.assert_allclose(shape, moved, atol=1e-9)
    assert np.abs(shape - POINTS).max() > 1e-6


def test_one_that_fails_loses_none_of_those_beside_it(tmp_path):
    text = SQUARES + "\nimport os\nif os.getcwd().endswith('000004'): raise SystemExit(3)\n"
    known = Remembered(program(tmp_path, text, processes=2), tmp_path / "known")
    with pytest.raises(EvaluationError, match="status 3"):
        list(streamed(known, [Request(k * POINTS, False, [k]) for k in range(1, 9)]))
    kept = len(list((tmp_path / "known").iterdir()))
    assert kept == len(runs(tmp_path)) - 1 >= 3
    again = program(tmp_path, SQUARES, processes=2)
    known = Remembered(again, tmp_path / "known")
    before = len(runs(tmp_path))
    assert len(list(streamed(known, [Request(k * POINTS, False, [k]) for k in range(1, 9)]))) == 8
    assert len(runs(tmp_path)) - before == 8 - kept
    assert known.recalled == kept


@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
def test_a_program_that_takes_too_long_leaves_no_child_running(tmp_path):
    with pytest.raises(EvaluationError, match="took more than 2 s"):
        program(tmp_path, CHILD, time_limit=2.0).evaluate(POINTS, False)
    assert gone(int((tmp_path / "runs" / "child").read_text()))


@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
@pytest.mark.parametrize("remembered", [False, True])
def test_a_stop_ends_a_program_that_runs(tmp_path, remembered):
    text = SQUARES + (
        "\nimport os, time\n"
        "if os.getcwd().endswith('000003'):\n"
        "    open('../here', 'w').write('x'); time.sleep(120)\n"
    )
    solver = program(tmp_path, text, processes=2)
    objective = Remembered(solver, tmp_path / "known") if remembered else solver
    study = Study(task(objective, columns(4), POINTS))

    def stop_when_it_hangs():
        while not (tmp_path / "runs" / "here").exists():
            time.sleep(0.05)
        study.stop()

    thread = threading.Thread(target=stop_when_it_hangs)
    thread.start()
    begin = time.monotonic()
    history = study.run()
    thread.join()
    assert history.records[-1].note == "stopped"
    assert time.monotonic() - begin < 60


def test_a_stop_before_the_start_is_evaluated_says_so(tmp_path):
    solver = program(tmp_path, "import time; time.sleep(60)")
    study = Study(task(solver, columns(4), POINTS))
    study.stop()
    with pytest.raises(EvaluationError, match="before the start"):
        study.run()


def test_a_stream_that_is_stopped_raises(tmp_path):
    with pytest.raises(Stopped):
        list(streamed(program(tmp_path), [Request(POINTS, False, [])], lambda: True))


@pytest.mark.parametrize("limit", [12, 20, 24])
def test_a_budget_that_ends_while_a_refinement_asks_ends_the_study(limit):
    from ffdstudio.optimize.objectives.function import PythonFunction

    function = PythonFunction(lambda p: float(np.mean((p[:, 1] - 0.05 * p[:, 0] ** 4) ** 2)))
    settings = Refinement(variables=20, positions=1, iterations=1)
    history = Study(
        task(function, columns(4), POINTS, "l2"), "lbfgs", settings, Budget(evaluations=limit)
    ).run()
    assert history.records[-1].kind == "end"
    assert history.records[-1].note == "evaluations spent"


def test_a_stop_ends_the_differences_of_a_function_too():
    from ffdstudio.optimize.objectives.function import PythonFunction

    calls = []

    def cost(points):
        calls.append(1)
        if len(calls) == 4:  # within the first differences
            study.stop()
        return float(np.mean(points[:, 1] ** 2 + points[:, 1]))

    study = Study(task(PythonFunction(cost), columns(8), POINTS))
    assert study.run().records[-1].note == "stopped"
    assert len(calls) == 4


def test_a_function_that_ends_python_has_failed():
    from ffdstudio.optimize.objectives.function import PythonFunction

    job = task(PythonFunction(lambda points: sys.exit("enough")), columns(4), POINTS)
    with pytest.raises(EvaluationError, match=r"sys.exit\('enough'\)"):
        Study(job).run()
