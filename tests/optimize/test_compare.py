"""Comparisons: what is drawn, what is counted, and that a killed one goes on."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.optimize.compare import report
from ffdstudio.optimize.compare.linear import LinearProblem, minimised
from ffdstudio.optimize.compare.protocol import ADAPTIVE, Case, Protocol, drawn
from ffdstudio.optimize.compare.rivals import LATTICES, Modes, cst_fields, lattice
from ffdstudio.optimize.compare.session import compare, modes_of, sections_in
from ffdstudio.optimize.compare.trial import lowered, result_of
from ffdstudio.optimize.geometry.sections import opened, sampled
from ffdstudio.optimize.objectives.flow import FlowTarget

SMALL = Protocol(
    variables=(14,), panels=(61, 81), angles=(0.0, 3.0), count=2, rivals=("greville", "cst"),
    evaluations=40,
)  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    """Three sections and a file that is none."""
    place = tmp_path / "sections"
    place.mkdir()
    for name in ("2412", "4415", "1408"):
        points = naca4(name, 61)
        text = "\n".join(f"{x:.6f} {y:.6f}" for x, y in points)
        (place / f"naca{name}.dat").write_text(f"NACA {name}\n{text}\n")
    (place / "broken.dat").write_text("x\n1 0\n0 zero\n1 0\n")
    return place


def test_what_is_drawn_depends_on_name_and_seed_alone(folder):
    files = sections_in(folder)
    first = {case.path.name: case for case in drawn(files, SMALL)}
    fewer = {case.path.name: case for case in drawn(files[1:], SMALL)}
    assert all(first[name] == case for name, case in fewer.items())
    assert {c.panels % 2 for c in first.values()} == {1}
    assert all(61 <= c.panels <= 81 and 0 <= c.angle <= 3 for c in first.values())
    assert first != {c.path.name: c for c in drawn(files, replace(SMALL, seed=3))}


def test_a_comparison_is_resumed_and_reads_past_what_is_no_section(folder, tmp_path):
    files, out, told = sections_in(folder), tmp_path / "out", []
    results = compare(files, replace(SMALL, count=1), out, listener=told.append)
    assert sum("runs" in r for r in results) == 1
    name = next(r["target"] for r in results if "runs" in r)
    place = out / "targets" / f"{name}.json"
    before = place.read_bytes()
    (out / "targets" / "naca9999.dat.json").write_text("{ cut off")
    results = compare(files, replace(SMALL, count=3), out, listener=told.append)
    assert place.read_bytes() == before
    assert sorted(r["target"] for r in told if "runs" in r) == [
        "naca1408.dat", "naca2412.dat", "naca4415.dat"
    ]  # fmt: skip
    assert sum("runs" in r for r in results) == 3
    refused = [r for r in told if "refused" in r]
    assert all("broken.dat, line 3" in r["refused"] for r in refused)
    assert json.loads((out / "settings.json").read_text())["digest"] == SMALL.digest
    again = compare(files, replace(SMALL, count=3), out, listener=lambda r: pytest.fail("anew"))
    assert again == results
    place.write_bytes(before[: len(before) // 2])  # as a crash of the machine may leave it
    compare(files, replace(SMALL, count=3), out)
    anew, known = json.loads(place.read_bytes()), json.loads(before)
    assert anew["runs"]["adaptive-14"]["path"] == known["runs"]["adaptive-14"]["path"]
    names = report.write(results, SMALL, out)
    assert all((out / n).stat().st_size > 100 for n in names)
    table = (out / "runs.csv").read_text().splitlines()
    assert len(table) == 1 + 3 * 3


def test_no_time_is_no_target(folder, tmp_path):
    assert compare(sections_in(folder), SMALL, tmp_path / "out", seconds=0) == []


def test_everybody_begins_at_the_same_cost_and_pays_for_the_metric(folder):
    result = result_of(Case(folder / "naca2412.dat", 81, 2.0), SMALL)
    assert set(result["runs"]) == {"greville-14", "cst-14", "adaptive-14"}
    for run in result["runs"].values():
        solves, cost = run["path"][0]
        assert cost == pytest.approx(result["start"])
        assert solves in (4, 5)  # the flow, three for its response; CST asks for the gradient
        costs = [cost for _, cost in run["path"]]
        assert costs == sorted(costs, reverse=True)
    assert result["runs"]["adaptive-14"]["variables"] <= 14


def test_cst_reaches_a_section_of_its_own_space():
    points = sampled("naca0012", 81)
    fields = cst_fields(points, 8)
    shape = points.copy()
    shape[:, 1] += fields @ (0.02 * np.cos(np.arange(9)))
    flow = FlowTarget.like(shape, [1.0])
    problem = LinearProblem(flow, points, fields, "flow")
    minimised(problem, 60)
    assert min(cost for _, cost in problem.path) < 1e-6 * problem.path[0][1]


def test_modes_span_the_library_they_come_from(folder):
    modes = modes_of(sections_in(folder))
    points = opened(sampled("naca0012", 101), 0.0)
    assert modes.fields(points, 2).shape == (101, 2)
    rng = np.random.default_rng(0)
    way = np.linspace(0, 2 * np.pi, 201)
    known = np.stack([np.sin(way), np.sin(2 * way)])
    found = Modes(rng.normal(size=(6, 2)) @ known).fields(points, 2)
    turn = np.arccos(2 * points[:, 0] - 1)
    turn = np.where(np.arange(101) <= 50, turn, 2 * np.pi - turn)
    wanted = np.stack([np.sin(turn), np.sin(2 * turn)], axis=1)
    left = wanted - found @ np.linalg.lstsq(found, wanted, rcond=None)[0]
    assert np.abs(left).max() < 1e-6


@pytest.mark.parametrize("name", LATTICES)
def test_static_lattices_have_the_columns_that_are_asked_for(name):
    net = lattice(sampled("naca0012", 41), 11, name)
    assert net.shape == (11, 2)
    assert net.degrees == (3, 1)


def result(name: str, rival: float, ours: float, solves: tuple[int, int]) -> dict:
    runs = {
        "greville-14": {"path": [(4, 1.0), (solves[0], rival)]},
        "cst-14": {"path": [(4, 1.0), (60, 10 * rival)]},
        f"{ADAPTIVE}-14": {"path": [(4, 1.0), (solves[1], ours)]},
    }
    return {"target": name, "panels": 61, "angle": 0.0, "start": 1.0, "runs": runs}


def test_the_distribution_counts_failures_by_name():
    results = [
        result("a.dat", 1e-3, 1e-4, (20, 10)),
        result("b.dat", 1e-4, 4e-4, (20, 30)),
        result("c.dat", 1e-4, 5e-5, (20, 20)),
        {"target": "d.dat", "refused": "d.dat: no points"},
    ]
    results[2]["runs"]["cst-14"] = {"error": "no solution"}
    told = report.summary(results, SMALL)
    assert told["targets"] == 3
    part = told["N = 14"]
    assert part["factor"]["median"] == pytest.approx(2)
    assert part["below 1"] == {"b.dat": 0.25}
    assert part["below 0.5"] == ["b.dat"]
    assert part["solves to 0.001"]["median"] == 1.0
    assert told["refused"] == {"d.dat": "d.dat: no points"}
    text = report.text(told, SMALL)
    assert "Below 1 at N = 14: b.dat 0.25." in text
    results[0]["runs"][f"{ADAPTIVE}-14"] = {"error": "it broke"}
    assert report.factors(results, SMALL, 14)["a.dat"] == 0.0  # a failure is the worst


def test_costs_that_rise_are_not_told():
    assert lowered([(1, 4.0), (3, 5.0), (5, 2.0), (7, 2.0)]) == [(1, 4.0), (5, 2.0), (7, 2.0)]


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("[compare]\nrival = 3\n", "knows no 'rival'"),
        ("[compare]\nrivals = ['spline']\n", "no rival 'spline'"),
        ("[compare]\npanels = [401]\n", "panels cannot be"),
        ("[compare]\ncount = 'many'\n", "count cannot be 'many'"),
        ("[compare]\nvariables = [8]\n", "begins with 10 variables"),
        ("[method]\nname = 'slsqp'\n", "knows no 'method'"),
        ("compare = \n", "no TOML file"),
    ],
)
def test_settings_that_cannot_be_are_refused(tmp_path, text, cause):
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError, match=cause):
        Protocol.read(tmp_path / "case.toml")


def test_a_folder_without_sections_is_refused(tmp_path):
    with pytest.raises(InputError, match="no airfoil files"):
        sections_in(tmp_path)
    with pytest.raises(InputError, match="no folder"):
        sections_in(Path(tmp_path / "none"))
