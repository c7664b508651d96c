"""`ffdstudio demo`: the paper's morphing case, its figure 5, and the pressures."""

import json
import struct
import zlib

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ffdstudio import Project, embed, read_lattice, read_mesh
from ffdstudio.cli import pictures
from ffdstudio.cli.demos import contour, pressure
from ffdstudio.optimize.geometry.sections import sampled
from ffdstudio.samples import sample

NAMES = ["figure6_domain.png", "figure7_lattice.png", "figure8_deformed.png"]


def pixels(path):
    """Size and raw RGB bytes of an 8-bit PNG without looking through VTK."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, colour = struct.unpack(">IIBB", data[16:26])
    assert (depth, colour) == (8, 2)
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        packed += data[at + 8 : at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    return (width, height), zlib.decompress(packed)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    from ffdstudio.cli.main import main

    folder = tmp_path_factory.mktemp("demo") / "results"
    assert main(["demo", "--case", "morphing", "-o", str(folder)]) == 0
    return folder


def test_everything_is_there(results):
    figures = json.loads((results / "figures.json").read_text())["morphing"]
    assert {p.name for p in results.iterdir()} >= {*figures["files"], "figures.json"}
    assert figures["files"][-3:] == NAMES
    assert figures["inverted"] == 0
    assert figures["max_displacement"] > 0.05
    assert figures["safe_amplitude"] > 1
    assert {"read", "embed", "deform", "write"} <= figures["seconds"].keys()


def test_the_figures_are_those_of_the_files(results):
    figures = json.loads((results / "figures.json").read_text())["morphing"]
    before = read_mesh(results / "naca0012.su2").points
    after = read_mesh(results / "naca0012_morphed.su2").points
    assert figures["moved"] == int((before != after).any(axis=1).sum())
    assert figures["max_displacement"] == np.linalg.norm(after - before, axis=1).max()
    rest, current = read_lattice(results / "naca0012.lattice.json")
    assert np.array_equal(embed(rest, before).deform(current), after)


def test_the_project_opens(results):
    project = Project.open(results / "naca0012.ffdproj")
    assert project.problems == []
    assert len(project.mesh("NACA 0012").points) > 0
    assert project.lattices[0].current == read_lattice(results / "naca0012.lattice.json")[1]


def test_the_pictures_show_something(results):
    seen = []
    for name in NAMES:
        size, raw = pixels(results / name)
        assert size == pictures.SIZE
        assert len(set(raw[::997])) > 20
        seen.append(raw)
    assert len(set(seen)) == 3


def test_without_graphics_everything_else_is_written(ffdstudio, tmp_path, monkeypatch):
    def fail(*args, **options):
        raise RuntimeError("no OpenGL")

    monkeypatch.setattr(pictures, "draw", fail)
    assert ffdstudio("demo", "--case", "morphing", "-o", tmp_path / "out") == 0
    assert "no pictures" in ffdstudio.err
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert {"naca0012_morphed.su2", "naca0012.ffdproj", "figures.json"} <= names
    assert not names & set(NAMES)


@pytest.fixture(scope="module")
def contours(tmp_path_factory):
    folder = tmp_path_factory.mktemp("contour")
    return folder, contour.run(folder, evaluations=700)


def test_adaptive_is_there_sooner_and_with_fewer_variables(contours):
    _, figures = contours
    there, regular = figures["adaptive_at_regular_rms"], figures["regular"]
    assert there["variables"] < regular["variables"] == 70
    assert there["evaluations"] < regular["evaluations"]
    assert figures["adaptive"]["rms"] < regular["rms"]
    assert str(there["evaluations"]) in contour.told(figures)


def test_the_contour_is_as_far_from_the_target_as_the_figures_say(contours):
    folder, figures = contours
    nodes = sampled(sample("rae2822.dat"), 20001)[:, :2]
    reached = np.loadtxt(folder / "contour.dat", skiprows=1)
    far = cKDTree(nodes).query(reached)[0]
    assert np.sqrt(np.mean(far**2)) == pytest.approx(figures["adaptive"]["rms"], rel=0.02)


def test_figure_5_is_written_twice(contours):
    folder, figures = contours
    assert {p.name for p in folder.iterdir()} == set(figures["files"])
    text = (folder / "figure5_convergence.svg").read_text()
    assert text.startswith("<?xml")
    size = struct.unpack(">II", (folder / "figure5_convergence.png").read_bytes()[16:24])
    assert size == (1200, 675)
    rows = (folder / "figure5_regular.csv").read_text().splitlines()
    last = dict(zip(rows[0].split(","), rows[-1].split(","), strict=True))
    assert float(last["rms"]) == figures["regular"]["rms"]


def test_a_case_that_there_is_not_is_bad_usage(ffdstudio, tmp_path):
    assert ffdstudio("demo", "--case", "none", "-o", tmp_path / "out") == 2
    assert "contour" in ffdstudio.err
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def matched(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pressure")
    return folder, pressure.run(folder, evaluations=12)


def test_the_pressures_on_the_morphed_mesh_are_those_of_the_figures(matched):
    folder, figures = matched
    start = read_mesh(folder / "naca0012.su2")
    known = pressure.study(start, pressure.lattices()["cosine"], 1, False)
    (before,) = known.task.objective.pressures(known.shape.points).values()
    costs = []
    for name in ("naca0012.su2", "pressure_morphed.su2"):
        study = pressure.study(read_mesh(folder / name), pressure.lattices()["cosine"], 1, False)
        (curves,) = study.task.objective.pressures(study.shape.points).values()
        gap = curves["shape"][1] - before["target"][1]
        costs.append(np.mean(gap**2))
    assert costs[1] / costs[0] == pytest.approx(figures["studies"]["adaptive"]["cost_ratio"])
    assert costs[1] < 0.01 * costs[0]


def test_the_volume_follows_and_the_far_field_stays(matched):
    folder, figures = matched
    mesh = read_mesh(folder / "naca0012.su2")
    after = read_mesh(folder / "pressure_morphed.su2").points
    rest, current = read_lattice(folder / "pressure.lattice.json")
    assert np.allclose(embed(rest, mesh.points).deform(current), after, rtol=0, atol=1e-14)
    far = np.unique(mesh.markers["farfield"]["line"])
    assert np.array_equal(after[far], mesh.points[far])
    assert figures["inverted"] == 0


def test_studies_are_compared_at_equal_solves(matched):
    folder, figures = matched
    rows = figures["studies"]
    assert all(row["solves"] <= figures["solves"] for row in rows.values())
    assert {p.name for p in folder.iterdir()} == set(figures["files"])
    assert f"{rows['adaptive']['cost_ratio']:.2e}" in pressure.told(figures)
    assert figures["best_static"] in pressure.told(figures)


def test_several_cases_share_the_copy_of_the_mesh(tmp_path):
    from ffdstudio.cli.demos.common import copied_mesh
    from ffdstudio.files import sources_kept

    with sources_kept():  # as around every command: the first case reads what the second copies
        mesh = copied_mesh(tmp_path)
        read_mesh(mesh)
        assert copied_mesh(tmp_path) == mesh
    assert mesh.read_bytes() == sample("naca0012.su2").read_bytes()
