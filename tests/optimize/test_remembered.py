"""What was evaluated before is used by a study that goes on, of the same objective alone."""

import json
import sys

import pytest

from ffdstudio.optimize.cases.case import read_case
from ffdstudio.optimize.objectives.identity import identity, program_files

CASE = """
[shape]
source = "naca0012"
points = 41
[lattice]
shape = [4, 2]
[objective]
kind = "program"
command = ["{python}", "./solver.py"]
{more}
[budget]
iterations = 1
"""
SOLVER = """
import json
rows = [[float(w) for w in r.split(",")] for r in open("points.csv")]
json.dump({"value": SHIFT + sum((r[1] - 0.1 * r[0]) ** 2 for r in rows)}, open("result.json", "w"))
"""


@pytest.fixture
def ran(tmp_path):
    def run(shift=0.0, resume=False, more=""):
        (tmp_path / "solver.py").write_text(SOLVER.replace("SHIFT", str(shift)))
        path = tmp_path / "case.toml"
        path.write_text(CASE.format(python=sys.executable, more=more))
        before = len(list(tmp_path.glob("out/runs/*")))
        case = read_case(path, tmp_path / "out", resume)
        cost = case.study.run().iterates[0].cost
        return cost, len(list(tmp_path.glob("out/runs/*"))) - before, case.task.objective.recalled

    return run


def test_without_resume_nothing_of_an_earlier_run_is_used(ran):
    first, fresh, known = ran()
    assert known == 0
    assert ran() == (first, fresh, 0)


def test_a_study_that_goes_on_uses_it_and_says_so(ran):
    first, fresh, _ = ran()
    assert ran(resume=True) == (first, 0, fresh)


def test_another_program_under_the_same_name_answers_anew(ran):
    first, _, _ = ran()
    second, fresh, known = ran(shift=1.0, resume=True)
    assert second == pytest.approx(first + 1)
    assert fresh > 0
    assert known == 0


def test_other_settings_answer_anew_but_not_other_limits(ran):
    _, fresh, _ = ran()
    assert ran(resume=True, more="time_limit = 99.0\nprocesses = 2")[1:] == (0, fresh)


def test_the_identity_tells_settings_and_files(tmp_path):
    solver = tmp_path / "solver"
    solver.write_text("a")
    said = identity({"kind": "program", "weight": 1.0}, program_files([str(solver), "-n", "4"]))
    assert said != identity({"kind": "program", "weight": 2.0}, [solver])
    assert json.loads(said)[1] == json.loads(identity({}, [solver]))[1]
    solver.write_text("b")
    assert said != identity({"kind": "program", "weight": 1.0}, [solver])
