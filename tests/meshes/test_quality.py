"""Measures per cell against closed forms and VTK, and what a report says of them."""

import gc
import json
import weakref

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, inverted, quality
from ffdstudio.meshes.measures import MEASURES, corner_kernels
from ffdstudio.meshes.measures.bezier import HEX_EDGES, _nearly_straight
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.corners import jacobians
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.measures.layers import walls
from ffdstudio.meshes.measures.vectors import gathered
from tests.meshes.shapes import CUBE, UNIT, VTK_TYPE, block, crowd

VTK_NAME = {
    "triangle": "Triangle",
    "quad": "Quad",
    "tetra": "Tet",
    "pyramid": "Pyramid",
    "wedge": "Wedge",
    "hexahedron": "Hex",
}


def by_vtk(mesh, kind, measure):
    """(cells,) measure of one cell type by VTK's Verdict."""
    import pyvista as pv
    import vtk

    grid = pv.UnstructuredGrid({VTK_TYPE[kind]: mesh.cells[kind]}, mesh.points)
    ask = vtk.vtkMeshQuality()
    ask.SetInputData(grid)
    getattr(ask, f"Set{VTK_NAME[kind]}QualityMeasureTo{measure}")()
    ask.Update()
    return np.asarray(pv.wrap(ask.GetOutput())["Quality"])


@pytest.mark.parametrize("kind", UNIT)
def test_scaled_jacobian_is_verdicts(kind):
    mesh = crowd(kind, count=2000, distortion=0.2)
    ours = quality(mesh).measures["scaled_jacobian"]
    assert ours == pytest.approx(by_vtk(mesh, kind, "ScaledJacobian"), abs=1e-12)


@pytest.mark.parametrize("kind", ["triangle", "quad", "pyramid", "wedge", "hexahedron"])
def test_equiangle_skewness_is_verdicts(kind):
    mesh = crowd(kind, count=2000)
    ours = quality(mesh).measures["skewness"]
    assert ours == pytest.approx(by_vtk(mesh, kind, "EquiangleSkew"), abs=1e-12)


def test_equiangle_skewness_of_tetrahedra_is_the_worst_of_their_triangles():
    mesh = crowd("tetra", count=500)
    corners = mesh.points[mesh.cells["tetra"]]
    worst = np.zeros(500)
    for face in ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]):
        for i in range(3):
            a, b, c = (corners[:, face[(i + k) % 3]] for k in range(3))
            cosine = ((b - a) * (c - a)).sum(1)
            cosine /= np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
            angle = np.degrees(np.arccos(cosine))
            worst = np.maximum(worst, np.maximum((angle - 60) / 120, (60 - angle) / 60))
    assert quality(mesh).measures["skewness"] == pytest.approx(worst, abs=1e-12)


@pytest.mark.parametrize("kind", UNIT)
def test_volume_is_verdicts(kind):
    mesh = crowd(kind, count=500)
    name = "Area" if kind in ("triangle", "quad") else "Volume"
    assert quality(mesh).measures["volume"] == pytest.approx(by_vtk(mesh, kind, name), rel=1e-9)


def test_ideal_cells_score_best():
    height = np.sqrt(2 / 3)
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]])
    top = triangle.mean(axis=0) + [0, 0, height]
    ideal = {
        "triangle": triangle,
        "quad": CUBE[:4],
        "tetra": np.vstack([triangle, top]),
        "pyramid": np.vstack([CUBE[:4], [0.5, 0.5, np.sqrt(0.5)]]),
        "wedge": np.vstack([triangle, triangle + [0, 0, 1]]),
        "hexahedron": CUBE,
    }
    for kind, points in ideal.items():
        plane = kind in ("triangle", "quad")
        mesh = Mesh(points, {kind: [np.arange(len(points))]}, dimension=2 if plane else 3)
        measures = quality(mesh).measures
        assert measures["scaled_jacobian"] == pytest.approx(1, abs=1e-12)
        assert measures["skewness"] == pytest.approx(0, abs=1e-7)
        if kind != "pyramid":  # its centre does not lie over those of its triangles
            assert measures["orthogonal_quality"] == pytest.approx(1, abs=1e-12)
            assert measures["face_skewness"] == pytest.approx(0, abs=1e-12)


def test_closed_forms_of_sheared_and_stretched_bricks():
    points, cells = block(4, 3, 2)
    angle = np.radians(30)
    points = points * [4, 3, 2]
    points[:, 0] += np.tan(angle) * points[:, 1]
    report = quality(Mesh(points, {"hexahedron": cells}))
    # centres of neighbours in y are 30 degrees off the normal of the face between them
    assert report.measures["non_orthogonality"] == pytest.approx(30, abs=1e-9)
    assert report.measures["volume"] == pytest.approx(1, rel=1e-12)
    assert report.measures["orthogonal_quality"] == pytest.approx(np.cos(angle), rel=1e-12)
    assert report.measures["skewness"] == pytest.approx(30 / 90, rel=1e-12)
    assert report.measures["growth_ratio"] == pytest.approx(1, rel=1e-12)


def test_growth_ratio_is_that_of_a_geometric_progression():
    points, cells = block(1, 1, 6)
    points[:, 2] = (1.2 ** (6 * points[:, 2]) - 1) / 0.2
    report = quality(Mesh(points, {"hexahedron": cells}))
    assert report.measures["growth_ratio"] == pytest.approx(1.2, rel=1e-12)


def test_a_plane_mesh_has_the_measures_of_the_layer_of_cells_on_it():
    points, cells = block(5, 4, 1)
    points[:, :2] += 0.03 * np.sin(7 * points[:, [1, 0]])
    top = points[:, 2] == 1
    sides = {"front": {"quad": cells[:, :4]}, "back": {"quad": cells[:, 4:]}}
    kinds = dict.fromkeys(sides, "empty")
    solid = quality(Mesh(points, {"hexahedron": cells}, sides, kinds=kinds))
    plane = quality(Mesh(points * [1, 1, 0], {"quad": cells[:, :4]}, dimension=2))
    assert top.any()
    for name in ("non_orthogonality", "face_skewness", "aspect_ratio", "volume", "growth_ratio"):
        assert plane.measures[name] == pytest.approx(solid.measures[name], rel=1e-9, abs=1e-9)


def test_a_surface_in_space_has_areas_and_angles_but_no_neighbours():
    mesh = crowd("triangle", count=40, surface=True)
    measures = quality(mesh).measures
    a, b, c = mesh.points[mesh.cells["triangle"]].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert measures["volume"] == pytest.approx(areas, rel=1e-12)
    assert "non_orthogonality" not in measures


def test_cells_that_are_negative_from_the_start_are_counted_and_not_called_inverted():
    mesh = crowd("tetra", count=20)
    points = mesh.points.copy()
    points[mesh.cells["tetra"][[3, 8]]] *= [1, -1, 1]
    report = quality(mesh.with_points(points))
    assert (report.negative, int(report.inverted.sum())) == (2, 0)
    assert (report.measures["volume"] < 0).sum() == 2


def test_against_the_undeformed_mesh():
    points, cells = block(3, 3, 4)
    low = points[cells[:, :4]][..., 2].max(axis=1) == 0
    floor = {"floor": {"quad": cells[low][:, :4]}}
    mesh = Mesh(points, {"hexahedron": cells}, floor)
    stretched = points * [1, 1, 1.5]
    report = quality(mesh, stretched)
    assert report.measures["volume_ratio"] == pytest.approx(1.5, rel=1e-12)
    height = report.measures["first_layer_ratio"]
    assert height[low] == pytest.approx(1.5, rel=1e-12)
    assert np.isnan(height[~low]).all()
    assert (report.undeformed["volume"] == quality(mesh).measures["volume"]).all()


@pytest.mark.parametrize("kind", UNIT)
def test_measures_after_a_partial_move_are_those_of_a_fresh_evaluation(kind):
    rng = np.random.default_rng(0)
    if kind in ("hexahedron", "tetra"):
        points, cells = block(5, 5, 5)
        cells = cells if kind == "hexahedron" else cells[:, [0, 1, 3, 4]]
        mesh = Mesh(points, {kind: cells})
    else:
        mesh = crowd(kind, count=50)
    for _ in range(4):
        moved = mesh.points.copy()
        some = rng.random(len(moved)) < 0.1
        flat = [1, 1, 0] if mesh.dimension == 2 else 1
        moved[some] += 0.15 * rng.normal(size=(some.sum(), 3)) * flat
        report = quality(mesh, moved)
        fresh = quality(Mesh(moved, mesh.cells, dimension=mesh.dimension))
        for name, values in fresh.measures.items():
            if not name.endswith("ratio") or name in ("aspect_ratio", "growth_ratio"):
                np.testing.assert_allclose(report.measures[name], values, rtol=1e-11, atol=1e-13)
        assert (report.inverted == inverted(mesh, moved).mask).all()


def test_a_report_does_not_change_when_the_next_one_is_made():
    mesh = crowd("hexahedron", count=10)
    first = quality(mesh, 1.1 * mesh.points)
    kept = {name: values.copy() for name, values in first.measures.items()}
    quality(mesh, 2 * mesh.points + 0.1 * np.sin(mesh.points))
    for name, values in kept.items():
        np.testing.assert_array_equal(first.measures[name], values)
    assert first.solver_tests["SU2 negative dual volumes"] == 0


def test_faces_found_from_cells_are_shared_by_two_or_lie_outside():
    points, cells = block(3, 4, 5)
    faces = topology_of(Mesh(points, {"hexahedron": cells})).faces
    inner = 2 * 4 * 5 + 3 * 3 * 5 + 3 * 4 * 4
    outer = 2 * (4 * 5 + 3 * 5 + 3 * 4)
    assert ((faces.neighbour >= 0).sum(), (faces.neighbour < 0).sum()) == (inner, outer)


def test_cells_given_three_times_are_measured_all_the_same():
    points, cells = block(1, 1, 1)
    mesh = Mesh(points, {"hexahedron": np.repeat(cells, 3, axis=0)})
    assert quality(mesh).measures["volume"] == pytest.approx(1)


def test_solvers_own_tests_see_a_folded_mesh():
    points, cells = block(3, 3, 3)
    mesh = Mesh(points, {"hexahedron": cells})
    assert set(quality(mesh).solver_tests.values()) == {0}
    moved = points.copy()
    moved[np.linalg.norm(points - 1 / 3, axis=1).argmin()] += 5
    tests = quality(mesh, moved).solver_tests
    assert min(tests.values()) > 0


def test_dual_volumes_fill_the_mesh():
    from ffdstudio.meshes.measures.solvers import dual_volumes

    for kind in UNIT:
        mesh = crowd(kind, count=30)
        dual = dual_volumes(blocks_of(mesh), mesh.points, mesh.points)
        assert dual.sum() == pytest.approx(quality(mesh).measures["volume"].sum(), rel=1e-2)
        if kind in ("triangle", "tetra"):  # a node's share of a simplex
            values = jacobians(blocks_of(mesh).blocks[0], mesh.points)[0]
            share = np.repeat(values / (6 if kind == "triangle" else 24), len(UNIT[kind]))
            assert dual == pytest.approx(share, rel=1e-9)


def test_walls_are_told_by_kind_or_by_name():
    line = {"line": [[0, 1]]}
    names = ("Airfoil", "FARFIELD", "symmetry_z", "outlet")
    plain = Mesh([[0, 0, 0], [1, 0, 0]], {}, dict.fromkeys(names, line))
    assert walls(plain) == ("Airfoil",)
    told = Mesh(plain.points, {}, plain.markers, kinds={"outlet": "wall", "Airfoil": "patch"})
    assert walls(told) == ("outlet",)


def test_a_report_is_plain_json_and_names_its_standards():
    report = quality(crowd("wedge", count=12))
    told = json.loads(json.dumps(report.to_dict(), allow_nan=False))
    assert told["cells"] == 12
    assert told["inverted"] == 0
    for name, entry in told["measures"].items():
        assert entry["min"] <= entry["mean"] <= entry["max"]
        assert entry["standard"] == MEASURES[name].standard
    worst = told["measures"]["scaled_jacobian"]["worst"][0]
    values = report.measures["scaled_jacobian"]
    assert (worst["cell"], worst["value"]) == (values.argmin(), values.min())
    nodes = crowd("wedge", count=12).cells["wedge"][worst["cell"]]
    assert worst["place"] == pytest.approx(crowd("wedge", count=12).points[nodes].mean(axis=0))


def test_nothing_is_kept_of_a_mesh_that_nobody_holds():
    mesh = crowd("tetra", count=5)
    quality(mesh)
    gone = weakref.ref(mesh)
    del mesh
    gc.collect()
    assert gone() is None


def test_the_quick_bound_of_hexahedra_is_never_bolder_than_the_plain_one():
    mesh = crowd("hexahedron", count=3000, distortion=0.1)
    nodes, doubt = mesh.cells["hexahedron"], np.ones(3000, dtype=bool)
    everyone = np.arange(3000)
    corner_kernels.bounded(everyone, everyone, mesh.points, nodes, np.array(HEX_EDGES), doubt)
    plain = ~_nearly_straight(gathered(mesh.points, nodes))
    assert not (plain & ~doubt).any()
    assert not doubt.all()


def test_a_collapsed_face_does_not_speak_for_its_cell():
    points = CUBE.copy()
    points[[2, 6]] = points[[3, 7]]  # a wedge written as a hexahedron
    told = quality(Mesh(points, {"hexahedron": [np.arange(8)]})).measures
    wedge = quality(Mesh(UNIT["wedge"], {"wedge": [np.arange(6)]})).measures
    for name in ("volume", "non_orthogonality", "aspect_ratio"):
        assert told[name] == pytest.approx(wedge[name], rel=1e-9)
    assert told["face_skewness"] < 1
    assert told["orthogonal_quality"] > 0.5


@pytest.mark.parametrize("kind", UNIT)
def test_cells_without_size_are_measured_without_complaint(kind):
    mesh = crowd(kind, count=3)
    points = mesh.points.copy()
    points[mesh.cells[kind][1]] = 0
    told = quality(mesh.with_points(points)).to_dict()
    json.dumps(told, allow_nan=False)
    assert told["inverted"] == 0


def test_a_mesh_without_cells_is_refused():
    with pytest.raises(InputError, match="no cells"):
        ffd.quality(Mesh([[0, 0, 0]], {"vertex": [[0]]}))
