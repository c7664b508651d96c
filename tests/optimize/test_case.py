"""Case files: what is said is done or refused, with the file's name."""

import tomllib

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.meshes import write_mesh
from ffdstudio.optimize.build.build import read_case
from ffdstudio.optimize.geometry.sections import target_contour, trailing_gap
from tests.optimize.cases import built

FLOW = """
[shape]
source = "naca0012"
points = 81
[lattice]
shape = [5, 2]
[objective]
kind = "flow"
angles = [2.0]
lift = [0.3]
"""
TABLES = {"shape", "lattice", "objective", "variables", "constraints", "refinement", "method"}


def changed(text, table, lines):
    """A case with keys of a table replaced or added."""
    values = tomllib.loads(text)
    new = tomllib.loads(lines)
    if table == "constraints":
        values[table] = [new]
    else:
        values[table] = {**values.get(table, {}), **new}
    return values


@pytest.mark.parametrize(
    ("table", "lines", "message"),
    [
        ("objective", "angles = []", r"\[objective\] angles must be a list of values, each"),
        ("objective", "processes = 0", "knows no processes"),
        ("objective", "lift = [0.1, 0.2]", "1 angles need as many values of lift"),
        ("objective", "moment_weights = [1.0]", "weight of the moment, but no target"),
        ("objective", "lift_weights = [-1.0]", "lift_weights must be"),
        ("lattice", "shape = [1e300, 2]", r"\[lattice\] shape must be"),
        ("lattice", "shape = [5.9, 2.2]", r"\[lattice\] shape must be"),
        ("lattice", "shape = [1000, 1000]", "more than 20000 control points"),
        ("lattice", "degrees = [3.7, 1]", r"\[lattice\] degrees must be"),
        ("lattice", "degrees = [3]", "2 directions need as many, got 1"),
        ("lattice", "lower = [0, -1]", "lower and upper go together"),
        ("variables", "fixed = [1, 2]", "fixed must be a list of values"),
        (
            "variables",
            'fixed = [["a", "b"]]',
            "fixed must be a list of values",
        ),
        (
            "variables",
            "fixed = [[1.5, 0]]",
            "fixed must be a list of values",
        ),
        ("variables", "fixed = [[9, 0]]", "no control point"),
        ("variables", 'directions = [["y"]]', r"\[variables\] directions must be"),
        ("variables", 'directions = ["z"]', "a section moves in x and y"),
        ("variables", 'mirror = "k"', "the lattice has i, j, no direction k"),
        ("variables", 'linked = ["k"]', "the lattice has i, j, no direction k"),
        ("variables", 'mirror = "j"\nmirror_normal = [0, 1]', "mirror_normal must be"),
        ("variables", 'mirror = "j"\nmirror_normal = [0, 0, 0]', "a normal has a length"),
        ("refinement", 'variables = 20\ndirections = ["k"]', "the lattice has i, j"),
        ("refinement", 'variables = 20\ndirections = [["i"]]', r"\[refinement\] directions must"),
        ("refinement", "variables = 9", "9 are fewer than the 10 of the first lattice"),
        ("method", "penalty = -1.0", "penalty must be a number above 0"),
        ("method", 'name = "gauss-newton"', "gauss-newton needs residuals"),
        ("constraints", 'kind = "thickness"\nat = [2.5]\nlower = 0.1', "at must be"),
        ("constraints", 'kind = "volume"\nlower = 0.1', "volume needs a surface in 3D"),
        ("constraints", 'kind = "area"\nlower = 0.1\nequal = 0.1', "equal goes without"),
        ("constraints", 'kind = "area"', "has no limit"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_runs(table, lines, message, tmp_path):
    with pytest.raises(InputError, match=message):
        built(changed(FLOW, table, lines), tmp_path)


def test_a_mirrored_direction_is_not_refined_and_the_case_says_so(tmp_path):
    values = changed(FLOW, "variables", 'mirror = "j"')
    values["refinement"] = {"variables": 20, "directions": ["i", "j"]}
    with pytest.raises(InputError, match="j is mirrored or linked"):
        built(values, tmp_path)


def test_rows_are_not_refined_one_by_one_with_fixed_points(tmp_path):
    values = changed(FLOW, "variables", "fixed = [[0, 0]]")
    values["refinement"] = {"variables": 20, "row_wise": True}
    with pytest.raises(InputError, match="row_wise: it knows frozen layers"):
        built(values, tmp_path)


def test_a_least_squares_method_says_that_it_knows_no_constraints(tmp_path):
    values = changed(FLOW, "constraints", 'kind = "area"\nlower = 0.09')
    values["objective"] = {"kind": "contour", "target": "naca2412"}
    values["method"] = {"name": "gauss-newton"}
    with pytest.raises(InputError, match="knows no constraints: use slsqp"):
        built(values, tmp_path)


def test_single_brackets_of_constraints_are_refused(tmp_path):
    values = {**tomllib.loads(FLOW), "constraints": {"kind": "area", "lower": 0.1}}
    with pytest.raises(InputError, match="double brackets"):
        built(values, tmp_path)


def test_the_length_of_a_mirrors_normal_does_not_matter(tmp_path):
    shapes = []
    for normal in ("[0, 1, 0]", "[0, 2, 0]"):
        values = changed(FLOW, "variables", f'mirror = "j"\nmirror_normal = {normal}')
        values["budget"] = {"iterations": 2}
        shapes.append(built(values, tmp_path).study.run().lattice(-1))
    np.testing.assert_allclose(shapes[0].control_points, shapes[1].control_points, atol=1e-12)


def test_the_source_gets_the_trailing_edge_of_its_target(shared, tmp_path):
    target = str(shared / "airfoils" / "nlr7301.dat")
    gap = trailing_gap(target_contour(target))
    values = changed(FLOW, "shape", "points = 301")
    values["objective"] = {"kind": "contour", "target": target}
    values["method"] = {"name": "gauss-newton", "metric": "l2"}
    values["refinement"] = {"variables": 70}
    case = built(values, tmp_path)
    assert case.shape.points[0, 1] - case.shape.points[-1, 1] == pytest.approx(gap, abs=1e-12)
    assert np.sqrt(2 * case.study.run().iterates[-1].cost) < 2e-6  # as near as `fit` comes
    values["shape"]["trailing_edge"] = "keep"
    kept = built(values, tmp_path)
    assert kept.shape.points[0, 1] == kept.shape.points[-1, 1]


@pytest.mark.parametrize(
    "goal",
    [
        {"kind": "contour", "target": "naca2412"},
        {"kind": "flow", "angles": [2.0], "target": "naca2412", "lift": [0.5]},
    ],
)
def test_a_section_of_another_length_and_place_gives_the_same_study(goal, root, tmp_path):
    mesh = ffd.read_mesh(root / "sample_meshes" / "naca0012.su2")
    moved = 2 * mesh.points + [3.0, 0.5, 0.0]
    write_mesh(mesh, tmp_path / "moved.su2", moved)
    values = tomllib.loads(FLOW)
    values["objective"], values["budget"] = goal, {"iterations": 3}
    values["constraints"] = [
        {"kind": "thickness", "at": [0.3], "lower": 0.1},
        {"kind": "lift", "angle": 2.0, "lower": 0.2},
        {"kind": "displacement", "direction": "y", "lower": -0.05, "upper": 0.05},
    ]
    values["method"] = {"name": "slsqp", "metric": "none"}
    costs = []
    for source in (root / "sample_meshes" / "naca0012.su2", tmp_path / "moved.su2"):
        values["shape"] = {"source": str(source), "marker": "airfoil"}
        history = built(values, tmp_path).study.run()
        costs.append([record.cost for record in history.iterates])
        assert max(v for k, v in history.iterates[-1].measures.items() if "viol" in k) < 1e-6
    assert costs[0][0] == pytest.approx(costs[1][0], rel=1e-6)
    assert costs[1][-1] < 0.5 * costs[1][0]


def test_constraints_of_a_program_are_those_of_the_section_in_its_mesh(root, tmp_path):
    mesh = str(root / "sample_meshes" / "naca0012.su2")
    values = tomllib.loads(FLOW)
    values["shape"] = {"source": mesh, "marker": "airfoil"}
    values["constraints"] = [
        {"kind": "area", "lower": 0.01},
        {"kind": "max-thickness", "lower": 0.1},
    ]
    part = built(values, tmp_path)
    values["objective"] = {"kind": "program", "command": ["true"]}
    whole = built(values, tmp_path, tmp_path / "out")
    assert len(whole.shape.points) > len(part.shape.points)
    for mine, its in zip(whole.task.constraints, part.task.constraints, strict=True):
        found, known = mine.slack(whole.shape.points), its.slack(part.shape.points)
        assert found.values == pytest.approx(known.values)
        slope = np.ones((len(whole.shape.points), 3)) * [0, 1, 0] * whole.shape.points
        here = slope[whole.shape.contour]
        assert found.derivatives @ slope.ravel() == pytest.approx(known.derivatives @ here.ravel())


def test_a_file_is_named_in_what_is_said_about_it(tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(FLOW.replace("[5, 2]", "[5, 1]"))
    with pytest.raises(InputError, match=r"wrong\.toml: \[lattice\] shape"):
        read_case(path)


def test_costs_of_flows_get_the_flow_metric_and_others_on_request(tmp_path):
    values = tomllib.loads(FLOW)
    history = built(values, tmp_path).study.run()
    assert history.iterates[0].flow == 4  # one flow and its response
    values["objective"] = {"kind": "contour", "target": "naca2412"}
    assert built(values, tmp_path).study.run().iterates[0].flow == 0
    values["method"] = {"name": "lbfgs", "metric": "flow", "angle": 3.0}
    history = built(values, tmp_path).study.run()
    assert history.iterates[0].flow == 4
    assert history.iterates[-1].cost < 1e-2 * history.iterates[0].cost
