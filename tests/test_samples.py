"""The sample meshes are what their README says."""

import re
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.samples import sample


@pytest.fixture(scope="module")
def airfoil():
    return ffd.read_mesh(sample("naca0012.su2"))


@pytest.fixture(scope="module")
def air():
    return ffd.read_mesh(sample("wing_air.su2"))


def naca0012(x):
    """Half thickness from the textbook's formula, term by term."""
    powers = np.stack([np.sqrt(x), x, x**2, x**3, x**4])
    return 5 * 0.12 * np.array([0.2969, -0.1260, -0.3516, 0.2843, -0.1036]) @ powers


def as_bits(points):
    return {row.tobytes() for row in np.ascontiguousarray(points)}


def nodes_of(mesh, marker):
    return np.unique(np.concatenate([c.ravel() for c in mesh.markers[marker].values()]))


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def test_the_airfoil_mesh_has_the_size_and_markers_of_its_readme(airfoil):
    assert airfoil.dimension == 2
    assert {name: len(c) for name, c in airfoil.cells.items()} == {"triangle": 8026, "quad": 1649}
    assert {name: len(c["line"]) for name, c in airfoil.markers.items()} == {
        "airfoil": 200,
        "farfield": 52,
    }
    assert np.linalg.norm(airfoil.points - [0.5, 0, 0], axis=1).max() == pytest.approx(18)


def test_wall_nodes_lie_on_the_formula_with_a_closed_trailing_edge(airfoil):
    x, y = airfoil.points[nodes_of(airfoil, "airfoil"), :2].T
    np.testing.assert_allclose(np.abs(y), naca0012(x), rtol=0, atol=1e-15)
    assert (x.min(), x.max()) == (0.0, 1.0)
    assert y[x == 1.0].tolist() == [0.0]


def test_every_corner_of_every_cell_turns_left(airfoil):
    for cells in airfoil.cells.values():
        corners = airfoil.points[cells, :2]
        ahead = np.roll(corners, -1, axis=1) - corners
        behind = np.roll(corners, 1, axis=1) - corners
        lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
        assert (cross(ahead, behind) > 0.3 * lengths).all()


def test_the_cells_fill_the_area_between_wall_and_farfield(airfoil):
    def area(polygons):
        return cross(polygons, np.roll(polygons, -1, axis=1)).sum() / 2

    inside = sum(area(airfoil.points[cells, :2]) for cells in airfoil.cells.values())
    around = sum(
        sign * cross(*airfoil.points[lines["line"], :2].transpose(1, 0, 2)).sum() / 2
        for sign, lines in ((-1, airfoil.markers["airfoil"]), (1, airfoil.markers["farfield"]))
    )
    assert inside == pytest.approx(abs(around), rel=1e-12)


def test_layers_at_the_wall_are_thin_and_grow_slowly(airfoil):
    quads = airfoil.points[airfoil.cells["quad"], :2]
    along = np.linalg.norm(quads[:, 3] - quads[:, 0], axis=1)
    heights = np.linalg.norm(quads[:, 1] - quads[:, 0], axis=1)
    assert heights.min() == pytest.approx(2e-4)
    assert np.median(along / heights) > 5
    columns = heights[: 8 * 200].reshape(200, 8)
    np.testing.assert_allclose(columns[:, 1:] / columns[:, :-1], 1.3, rtol=1e-6)


@pytest.mark.parametrize(("name", "count"), [("naca0012.dat", 161), ("rae2822.dat", 129)])
def test_airfoil_coordinates_run_around_once(name, count):
    rows = sample(name).read_text().splitlines()[1:]
    x, y = np.array([row.split() for row in rows if row.strip()], dtype=float).T
    assert len(x) == count
    assert x[0] == x[-1] == 1.0
    assert np.count_nonzero(np.diff(np.sign(np.diff(x)))) == 1
    assert y[: count // 2].mean() > 0 > y[count // 2 :].mean()


def test_naca_coordinates_lie_on_the_formula():
    x, y = np.loadtxt(sample("naca0012.dat"), skiprows=1).T
    slope = np.abs(naca0012(np.clip(x + 5e-9, 0, 1)) - naca0012(np.clip(x - 5e-9, 0, None)))
    assert (np.abs(np.abs(y) - naca0012(x)) <= 5.1e-9 + slope).all()


def test_the_rae_section_is_the_published_one(shared):
    published = shared / "airfoils" / "rae2822.dat"
    assert sample("rae2822.dat").read_bytes() == published.read_bytes()


def test_the_air_has_the_size_and_markers_of_its_readme(air):
    assert (air.dimension, len(air.points), len(air.cells["tetra"])) == (3, 5034, 24460)
    assert set(air.markers) == {"WING", "SYMMETRY", "FARFIELD"}
    assert (air.points[nodes_of(air, "SYMMETRY"), 1] == 0).all()
    far = air.points[nodes_of(air, "FARFIELD")] - [1, 0, 0]
    np.testing.assert_allclose(np.linalg.norm(far, axis=1), 12, rtol=1e-14)


def test_tetrahedra_are_positive_and_leave_no_gap(air):
    corners = air.points[air.cells["tetra"]]
    assert np.linalg.det(corners[:, 1:] - corners[:, :1]).min() > 0
    used = np.sort(air.cells["tetra"], axis=1)
    faces = np.concatenate([np.delete(used, k, axis=1) for k in range(4)])
    faces, counts = np.unique(faces, axis=0, return_counts=True)
    marked = np.sort(np.concatenate([m["triangle"] for m in air.markers.values()]), axis=1)
    assert as_bits(faces[counts == 1]) == as_bits(marked)
    assert counts.max() == 2


def test_skin_structure_and_air_share_nodes_to_the_bit(air):
    skin = ffd.read_mesh(sample("wing_skin.vtu"))
    structure = ffd.read_mesh(sample("wing_structure.vtu"))
    wing = as_bits(air.points[nodes_of(air, "WING")])
    assert as_bits(skin.points) == wing
    shared = as_bits(structure.points) & wing
    assert len(shared) == 2 * (2 * 28 + 10 * 7)  # spars at every station, ribs between them
    assert as_bits(structure.points) & as_bits(air.points) == shared


def test_the_skin_is_closed_but_for_its_root_and_points_outwards(air):
    skin = ffd.read_mesh(sample("wing_skin.vtu"))
    triangles = skin.cells["triangle"]
    directed = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    single = as_bits(directed) - as_bits(directed[:, ::-1])
    ends = np.array([np.frombuffer(edge, dtype=directed.dtype) for edge in single])
    assert len(single) == 40
    assert (skin.points[ends, 1] == 0).all()
    volume = np.linalg.det(skin.points[triangles]).sum() / 6
    areas = 2 * np.trapezoid(naca0012(np.linspace(0, 1, 100_001)), dx=1e-5) * (1 + 0.5 + 0.25) / 3
    assert volume == pytest.approx(2.5 * areas, rel=0.01)


def test_an_unknown_sample_is_refused_with_the_names_there_are():
    with pytest.raises(ffd.InputError, match=r"no sample 'x'; there are: .*naca0012\.su2"):
        sample("x")
    with pytest.raises(ffd.InputError):
        sample("../pyproject.toml")


def test_a_wheel_carries_the_samples(root, tmp_path):
    """Built without a network by the build backend that pyproject.toml names."""
    code = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
    done = subprocess.run(
        [sys.executable, "-c", code, tmp_path], cwd=root, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    for path in (root / "sample_meshes").glob("*.*"):
        assert f"ffdstudio/sample_meshes/{path.name}" in names
    assert not [name for name in names if re.match("tests|benchmarks", name)]
