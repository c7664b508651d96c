import sys

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.nearest import Triangles, closest
from ffdstudio.optimize.objectives.base import Request
from ffdstudio.optimize.objectives.failures import EvaluationError
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.objectives.function import PythonFunction
from ffdstudio.optimize.objectives.program import ExternalProgram
from ffdstudio.optimize.objectives.remembered import Remembered
from ffdstudio.optimize.objectives.stream import streamed
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.runs.study import Budget, Study, Task
from ffdstudio.optimize.variables.metrics import Surface
from tests.optimize.cases import columns, section, task

POINTS = section(41)
CAMBER = """
import json, csv
rows = [[float(w) for w in r] for r in csv.reader(open("points.csv"))]
gap = [0.5 * (a[1] + b[1]) - 0.05 * a[0] * (1 - a[0]) for a, b in zip(rows, rows[::-1])]
json.dump({"value": sum(g * g for g in gap), "measures": {"n": len(gap)}}, open("result.json", "w"))
"""


def program(tmp_path, text, **options):
    script = tmp_path / "solver.py"
    script.write_text(text)
    return ExternalProgram([sys.executable, str(script)], tmp_path / "runs", **options)


def test_nearest_points_on_triangles_agree_with_a_dense_sample():
    rng = np.random.default_rng(0)
    corner = rng.normal(size=(3, 3))
    a, b = np.meshgrid(np.linspace(0, 1, 401), np.linspace(0, 1, 401))
    inside = a + b <= 1 + 1e-12
    a, b = a[inside][:, None], b[inside][:, None]
    samples = corner[0] + a * (corner[1] - corner[0]) + b * (corner[2] - corner[0])
    for point in 2 * rng.normal(size=(40, 3)):
        exact = np.linalg.norm(closest(point, corner) - point)
        assert exact <= np.linalg.norm(samples - point, axis=1).min() + 1e-12
        assert exact == pytest.approx(np.linalg.norm(samples - point, axis=1).min(), abs=1e-2)


def test_the_search_finds_the_nearest_of_all_triangles():
    rng = np.random.default_rng(1)
    points, triangles = rng.normal(size=(60, 3)), rng.integers(0, 60, size=(90, 3))
    triangles = triangles[[len(set(t)) == 3 for t in triangles.tolist()]]
    surface, queries = Triangles(points, triangles), 2 * rng.normal(size=(50, 3))
    foot, _ = surface.project(queries)
    every = closest(queries[:, None], surface.corner[None])
    least = np.linalg.norm(every - queries[:, None], axis=2).min(axis=1)
    np.testing.assert_allclose(np.linalg.norm(foot - queries, axis=1), least, atol=1e-12)


def test_the_flow_cost_has_the_gradient_of_its_value():
    target = FlowTarget([0.0, 3.0], lift=[0.1, 0.5], moment=[0.0, -0.1])
    gradient = target.evaluate(POINTS).gradient
    step = np.zeros_like(POINTS)
    step[:, 1] = 1e-4 * np.sin(np.pi * POINTS[:, 0])
    ahead, behind = (target.evaluate(POINTS + d, False).value for d in (step, -step))
    assert (gradient * step).sum() == pytest.approx((ahead - behind) / 2, rel=1e-5)


def test_an_external_program_drives_a_study_by_differences(tmp_path):
    job = task(program(tmp_path, CAMBER, processes=2), columns(4), POINTS)
    history = Study(job, budget=Budget(iterations=2)).run()
    assert history.iterates[-1].cost < 0.5 * history.iterates[0].cost
    assert history.iterates[-1].measures["n"] == 41


def test_an_objective_without_gradient_is_refined_by_differences():
    goal = 0.05 * POINTS[:, 0] ** 4
    function = PythonFunction(
        lambda points: float(np.mean((points[:, 1] - POINTS[:, 1] - goal) ** 2))
    )
    settings = Refinement(variables=10, positions=1, iterations=3)
    history = Study(task(function, columns(4), POINTS, "l2"), "lbfgs", settings).run()
    assert history.iterates[-1].variables == 10
    assert history.iterates[-1].cost < 1e-5 * history.iterates[0].cost


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("raise SystemExit('out of licences')", "status 1.*out of licences"),
        ("import time; time.sleep(60)", "took more than 1 s"),
        ("open('result.json', 'w').write('nonsense')", "does not hold a value"),
        ("open('result.json', 'w').write('{\"value\": NaN}')", "no finite number"),
        ("open('result.json', 'w').write('{\"value\": 1, \"measures\": {\"cl\": NaN}}')", "cl nan"),
        ("open('result.json', 'w').write('{\"value\": true}')", "value is true, no number"),
        ("open('result.json', 'w').write('{\"value\": \"12\"}')", "no number"),
        ("open('result.json', 'w').write('{\"value\": null}')", "value is null, no number"),
        (
            "open('result.json', 'w').write('{\"value\": 1, \"measures\": {\"cl\": false}}')",
            "cl is",
        ),
        ("open('result.json', 'w').write('{\"value\": 1, \"measures\": [1]}')", "not hold"),
        ("open('result.json', 'w').write('{\"value\": 1' + '0' * 400 + '}')", "not hold"),
        ("open('result.json', 'w').write('[' * 100000)", "nested"),
        ("open('result.json', 'w').write('[1]')", "does not hold a value"),
        ("open('result.json', 'wb').write(b'\\xff\\xfe1')", "does not hold a value"),
        ("pass", "cannot read"),
    ],
)
def test_a_program_that_fails_is_reported(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        program(tmp_path, text, time_limit=1.0).evaluate(POINTS, False)


def test_a_program_that_fails_later_loses_nothing(tmp_path):
    text = CAMBER + "\nimport os\nif len(os.listdir('..')) > 12: raise SystemExit(3)\n"
    solver = Remembered(program(tmp_path, text), tmp_path / "known")
    history = Study(task(solver, columns(4), POINTS), folder=tmp_path / "study").run()
    assert history.records[-1].note.startswith("failed: ")
    assert history.iterates[-1].cost <= history.iterates[0].cost
    runs = len(list((tmp_path / "runs").iterdir()))
    (tmp_path / "solver.py").write_text(CAMBER)  # mended
    again = Study(
        task(solver, columns(4), POINTS), budget=Budget(iterations=1), folder=tmp_path / "study",
        resume=True,
    ).run()  # fmt: skip
    assert again.records[-1].note == "iterations spent"
    assert len(list((tmp_path / "runs").iterdir())) <= runs + 20  # those that were known stayed


def test_a_sensitivity_file_takes_the_place_of_differences(tmp_path):
    text = CAMBER + (
        "\nwith open('sensitivity.csv', 'w') as out:\n"
        "    for a, g in zip(rows, gap): out.write(f'0,{g},0\\n')\n"
    )
    found = program(tmp_path, text, sensitivity=True).evaluate(POINTS)
    assert found.gradient.shape == (41, 3)
    wrong = program(
        tmp_path, CAMBER + "\nopen('sensitivity.csv','w').write('1,2,3')", sensitivity=True
    )
    with pytest.raises(EvaluationError, match="41 rows"):
        wrong.evaluate(POINTS)


def test_a_function_by_name_runs_in_processes_of_its_own():
    jobs = [Request(k * POINTS, False) for k in (1, 2, 3)]
    found = list(streamed(PythonFunction("numpy:sum", processes=2), jobs))
    assert [one.value for _, one in found] == pytest.approx([np.sum(j.points) for j in jobs])
    assert all(job is mine for (job, _), mine in zip(found, jobs, strict=True))


@pytest.mark.parametrize("name", ["numpy", "numpy:nothing", "no.such:thing", "numpy:pi"])
def test_a_function_that_cannot_be_had_is_refused(name):
    with pytest.raises(InputError):
        PythonFunction(name)


def test_a_function_that_fails_or_returns_nonsense_is_reported():
    with pytest.raises(EvaluationError, match="ZeroDivisionError"):
        PythonFunction(lambda points: 1 / 0).evaluate(POINTS)
    with pytest.raises(EvaluationError, match="no number"):
        PythonFunction(lambda points: "much").evaluate(POINTS)
    with pytest.raises(EvaluationError, match="gradient of shape"):
        PythonFunction(lambda points: 1.0, gradient=True).evaluate(POINTS)


def test_a_missing_neuralfoil_is_named():
    pytest.importorskip("numpy")
    try:
        import neuralfoil  # noqa: F401
    except ImportError:
        from ffdstudio.optimize.objectives.neural import NeuralFoil

        with pytest.raises(InputError, match=r"pip install .*neuralfoil"):
            NeuralFoil(2.0, 1e6, 0.5)


def test_volume_points_outside_the_metric_do_not_matter():
    far = np.vstack([POINTS, POINTS + [100, 0, 0]])
    edges = np.column_stack([np.arange(40), np.arange(1, 41)])
    surface = Surface.edges(far, edges)
    assert surface.mass[41:].sum() == 0
    lattice = columns(5)
    function = PythonFunction(lambda p: float(np.sum((p[:41, 1] - 0.01) ** 2)))
    history = Study(
        Task(function, ffd.embed(lattice, far), surface), budget=Budget(iterations=3)
    ).run()
    assert history.iterates[-1].cost < history.iterates[0].cost
