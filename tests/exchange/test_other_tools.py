"""Lattices of GoTools, geomdl, splinepy and PyGeM, against the tools or plain formulas."""

import json
import math

import numpy as np
import pytest

from ffdstudio import InputError, Lattice, read_lattice, write_lattice
from ffdstudio.exchange import read_lattice_file


def weighted(shape=(5, 4, 3)):
    rng = np.random.default_rng(11)
    box = Lattice.box([0, 1, 2], [1, 3, 5], shape).insert_knots(0, [0.3])
    noise = 0.1 * rng.random(box.control_points.shape)
    return box.moved(box.control_points + noise, 0.5 + rng.random(box.shape))


@pytest.mark.parametrize("suffix", [".g2", ".geomdl.json", ".splinepy.json"])
def test_a_weighted_lattice_goes_there_and_back(tmp_path, suffix):
    lattice = weighted()
    assert write_lattice(tmp_path / f"a{suffix}", lattice).exact
    back, current = read_lattice(tmp_path / f"a{suffix}")
    assert back is current
    assert back.same_space(lattice)
    assert np.abs(back.control_points - lattice.control_points).max() < 1e-14
    assert np.array_equal(back.weights, lattice.weights)


@pytest.mark.parametrize("shape", [(6, 4), (7,)])
@pytest.mark.parametrize("suffix", [".g2", ".splinepy.json"])
def test_fewer_directions_go_there_and_back(tmp_path, shape, suffix):
    lattice = weighted(shape)
    write_lattice(tmp_path / f"a{suffix}", lattice)
    back = read_lattice(tmp_path / f"a{suffix}")[0]
    assert np.abs(back.control_points - lattice.control_points).max() < 1e-14


def surface(corners):
    """A bilinear surface of GoTools, u fastest."""
    rows = "\n".join(" ".join(map(repr, corner)) for corner in corners)
    return f"200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n{rows}\n"


R = math.sqrt(0.5)


@pytest.mark.parametrize(
    ("across", "axes"),
    [
        ([1.0, 0.0, 0.0], [[1, 0, 0], [0, 0, 1]]),
        ([-1.0, 0.0, 0.0], [[1, 0, 0], [0, 0, 1]]),
        ([0.0, 1.0, 0.0], [[0, 1, 0], [0, 0, 1]]),
        ([1.0, 1.0, 0.0], [[R, R, 0], [0, 0, 1]]),
        ([1.0, 0.0, 0.5], [[1, 0, 0], [0, 0, 1]]),
    ],
)
@pytest.mark.parametrize("size", [1.0, 1e200])
def test_an_upright_surface_has_the_axes_of_its_plane(tmp_path, across, axes, size):
    up, start = np.array([0.0, 0.0, 2.0]), np.array([3.0, 4.0, 5.0])
    across = np.array(across)
    corners = size * np.array([start, start + across, start + up, start + across + up])
    (tmp_path / "a.g2").write_text(surface(corners.tolist()))
    assert np.allclose(read_lattice(tmp_path / "a.g2")[0].axes, axes, rtol=0, atol=1e-15)


def test_surfaces_that_lie_or_lean_are_seen_along_z(tmp_path):
    tilted = [[0.0, 0.0, 0.0], [1.0, 0.0, 9.0], [0.0, 1.0, 0.0], [1.0, 1.0, 9.0]]
    (tmp_path / "a.g2").write_text(surface(tilted))
    assert np.array_equal(read_lattice(tmp_path / "a.g2")[0].axes, np.eye(3)[:2])


def test_a_surface_that_is_only_a_line_gets_no_axes_of_its_own(tmp_path):
    for corners in ([[0.0, 0.0, 0.0]] * 4, [[float(k), 0.0, 0.0] for k in range(4)]):
        (tmp_path / "a.g2").write_text(surface(corners))
        assert np.array_equal(read_lattice(tmp_path / "a.g2")[0].axes, np.eye(3)[:2])


def test_an_upright_surface_and_curve_of_splinepy_have_their_own_axes(tmp_path):
    for shape, axes in (((4, 3), [[1, 0, 0], [0, 0, 1]]), ((4,), [[0, 1, 0]])):
        lattice = Lattice.box([0, 0], [2, 1], shape=shape, axes=axes)
        flat = Lattice(lattice.degrees, lattice.knots, lattice.control_points)  # axes x, y
        write_lattice(tmp_path / "a.splinepy.json", flat)
        assert read_lattice(tmp_path / "a.splinepy.json")[0] == lattice


@pytest.mark.parametrize(
    "name",
    ["sample_geomdl.json", "sample_splinepy.json", "sample_volume.g2", "sample_volume_rat.g2"],
)
def test_the_unit_cube_of_every_tool_is_the_identity(shared, name):
    rest, _ = read_lattice(shared / "lattices" / name)
    u = np.random.default_rng(1).random((20, 3))
    assert np.abs(rest.evaluate(u) - u).max() < 1e-15


def test_splinepy_reads_what_we_write(tmp_path):
    splinepy = pytest.importorskip("splinepy")
    lattice = weighted()
    write_lattice(tmp_path / "a.splinepy.json", lattice)
    spline = splinepy.io.json.load(str(tmp_path / "a.splinepy.json"))[0]
    if isinstance(spline, dict):
        spline = splinepy.NURBS(
            **{k: spline[k] for k in ("degrees", "knot_vectors", "control_points", "weights")}
        )
    low, high = lattice.domain.T
    u = low + (high - low) * np.random.default_rng(4).random((50, 3))
    assert np.abs(spline.evaluate(u) - lattice.evaluate(u)).max() < 1e-13


def pygem(points, box, moves):
    """PyGeM's deformation by its definition: origin + R diag(l) (s + sum mu B(s))."""
    origin, length, angles = box
    a, b, c = np.radians(angles)
    rx = [[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]
    ry = [[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]]
    rz = [[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]]
    to_world = np.array(rx) @ ry @ rz @ np.diag(length)
    s = (points - origin) @ np.linalg.inv(to_world).T
    shift = np.zeros_like(s)
    for index in np.ndindex(moves.shape[:3]):
        factor = np.ones(len(s))
        for k, i in enumerate(index):
            n = moves.shape[k] - 1
            factor *= math.comb(n, i) * s[:, k] ** i * (1 - s[:, k]) ** (n - i)
        shift += factor[:, None] * moves[index]
    return origin + (s + shift) @ to_world.T


def test_a_pygem_file_deforms_as_pygem_does(shared):
    from ffdstudio import embed

    rest, current = read_lattice(shared / "lattices" / "sample_pygem.prm")
    box = np.zeros(3), [1.0, 2.0, 3.0], [10.0, 20.0, 30.0]
    moves = np.zeros((3, 3, 3, 3))
    moves[1, 1, 1, 0] = 0.2
    inside = rest.evaluate(0.02 + 0.96 * np.random.default_rng(8).random((200, 3)))
    ours = embed(rest, inside).deform(current)
    assert np.abs(ours - pygem(inside, box, moves)).max() < 1e-13
    assert np.abs(ours - inside).max() > 0.01


def test_a_pygem_file_comes_back(shared, tmp_path):
    rest, current = read_lattice(shared / "lattices" / "sample_pygem.prm")
    assert write_lattice(tmp_path / "a.prm", rest, current).exact
    back = read_lattice(tmp_path / "a.prm")
    for old, new in zip((rest, current), back, strict=True):
        assert np.abs(old.control_points - new.control_points).max() < 1e-14


def test_pygem_takes_straight_bezier_boxes_only(tmp_path):
    bezier = Lattice.box([0, 0, 0], [1, 1, 1], (3, 3, 3), (2, 2, 2))
    assert write_lattice(
        tmp_path / "a.prm", bezier, bezier.moved(bezier.control_points + 0.1)
    ).exact
    with pytest.raises(InputError, match="right-angled box"):
        write_lattice(tmp_path / "a.prm", bezier.moved(bezier.control_points**2))
    with pytest.raises(InputError, match="degree 3"):
        write_lattice(tmp_path / "a.prm", Lattice.box([0, 0, 0], [1, 1, 1], (5, 5, 5)))


def test_a_bare_json_is_told_by_its_content(shared, tmp_path):
    for name, kind in (("sample_geomdl.json", "geomdl"), ("sample_splinepy.json", "splinepy")):
        assert read_lattice_file(shared / "lattices" / name).format == kind
    write_lattice(tmp_path / "a.json", weighted())
    assert read_lattice_file(tmp_path / "a.json").format == "ffdstudio-lattice"
    (tmp_path / "b.json").write_text("{}")
    with pytest.raises(InputError, match="neither suffix nor content"):
        read_lattice(tmp_path / "b.json")


def edited(path, source, change):
    data = json.loads(source.read_text())
    change(data)
    path.write_text(json.dumps(data))
    return path


@pytest.mark.parametrize(
    ("suffix", "text", "words"),
    [
        (".g2", "700 1 0 0\n3 0\n2 2\n0 0 1 1", "ends too early"),
        (".g2", "700 1 0 0\n3 0\n" + "2 2\n0 0 1 1\n" * 3 + "0 " * 23, "ends too early"),
        (".g2", "700 1 0 0\n3 0\n" + "2 2\n0 0 1 1\n" * 3 + "0 " * 23 + "inf", "finite"),
        (".g2", "700 1 0 0\n3 1\n" + "2 2\n0 0 1 1\n" * 3 + "0 " * 32, "positive"),
        (".g2", "700 1 0 0\n3 0\n" + "2 3\n0 0 0 1 1\n" * 3 + "0 " * 24, "degree 2"),
        (".g2", "999 1 0 0\n", "curves, surfaces and volumes"),
        (".g2", "700 1 0 0\n4 0\n", "2 or 3 coordinates"),
        (".prm", "[Box info]\nn control points x: 3\n", "missing"),
        (".prm", "no section", "no section"),
        (".prm", "[Box info]\n[Box info]\n", "already exists"),
        (".splinepy.json", '{"SplineList": []}', "list of objects"),
        (".splinepy.json", '{"SplineList": [{"degrees": [1.5]}]}', "whole numbers"),
        (".splinepy.json", '{"SplineList": [], "Base64Encoding": true}', "base64"),
        (".geomdl.json", '{"shape": {"type": "surface"}}', "only volumes"),
        (".geomdl.json", '{"shape": {"type": "volume", "data": [{}]}}', "degree_u"),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path, suffix, text, words):
    path = tmp_path / f"a{suffix}"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as error:
        read_lattice(path)
    assert str(path) in str(error.value)
