"""What was evaluated before is used by a study that goes on, of the same objective alone."""

import io
import json
import sys
import zipfile

import numpy as np
import pytest

from ffdstudio import InputError
from ffdstudio.optimize.build.build import read_case
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request
from ffdstudio.optimize.objectives.identity import identity, program_files
from ffdstudio.optimize.objectives.remembered import Remembered

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


# ---- what lies in the folder may be anything --------------------------------------------------

POINTS = np.linspace(0, 1, 12).reshape(4, 3)


class Counting(Objective):
    """Says how often it was asked."""

    abilities = Abilities()

    def __init__(self):
        self.asked = 0

    def answer(self, request):
        self.asked += 1
        return Evaluation(1.5, 2 * request.points, flow=1, adjoint=1, measures={"cl": 0.5})


@pytest.fixture
def known(tmp_path):
    """A folder with one evaluation, and its file."""
    Remembered(Counting(), tmp_path / "known").answer(Request(POINTS))
    return next((tmp_path / "known").glob("*.npz"))


def asked_again(file):
    objective = Counting()
    found = Remembered(objective, file.parent).answer(Request(POINTS))
    assert found.value == 1.5
    assert found.measures == {"cl": 0.5}
    assert np.array_equal(found.gradient, 2 * POINTS)
    return objective.asked


def saved(**arrays):
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


HEAD = {"value": 1.0, "flow": 1, "adjoint": 1, "measures": {}}


def with_head(gradient=2 * POINTS, **changed):
    return saved(head=np.array(json.dumps(HEAD | changed)), gradient=gradient)


def packed_otherwise(method):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as file:
        file.writestr("head.npy", b"x" * 10_000)
    return stream.getvalue()


DAMAGED = {
    "nothing": b"",
    "no zip": b"\x93NUMPY",
    "zip in name only": b"PK\3\4" + bytes(100),
    "no head": saved(gradient=POINTS),
    "head of numbers": saved(head=POINTS),
    "head without JSON": saved(head=np.array("{")),
    "nested head": saved(head=np.array("[" * 5000)),
    "pickle": saved(head=np.array({"value": 1}, dtype=object)),
    "value is text": with_head(value="1"),
    "value is true": with_head(value=True),
    "value without end": saved(head=np.array('{"value": 1e999}')),
    "flow is text": with_head(flow="1"),
    "measures are a list": with_head(measures=[1]),
    "a measure is true": with_head(measures={"cl": True}),
    "another number of points": with_head(gradient=POINTS[:-1]),
    "a gradient that is not finite": with_head(gradient=POINTS * np.nan),
    "a gradient of texts": with_head(gradient=np.full((4, 3), "x")),
    "lzma": packed_otherwise(zipfile.ZIP_LZMA),
    "bzip2": packed_otherwise(zipfile.ZIP_BZIP2),
}


def test_an_undamaged_evaluation_is_not_asked_for_again(known):
    assert asked_again(known) == 0


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_evaluation_counts_as_none(known, name):
    known.write_bytes(DAMAGED[name])
    assert asked_again(known) == 1
    assert asked_again(known) == 0  # it was written anew


def test_every_cut_and_many_flipped_bits_count_as_none_or_change_nothing(known):
    whole = known.read_bytes()
    for place in range(0, len(whole), 7):
        flipped = bytearray(whole)
        flipped[place] ^= 1 << place % 8
        for data in (whole[:place], bytes(flipped)):
            known.write_bytes(data)
            asked_again(known)


def test_a_link_out_of_the_folder_ends_a_resume_before_anything_is_written(ran, tmp_path):
    ran()
    victim = tmp_path / "victim"
    victim.write_bytes(b"precious")
    (tmp_path / "out" / "history.csv").unlink(missing_ok=True)
    (tmp_path / "out" / "history.csv").symlink_to(victim)
    with pytest.raises(InputError, match=r"history\.csv' leaves the folder"):
        ran(resume=True)
    assert victim.read_bytes() == b"precious"
