"""Inverted cells: sign changes against the undeformed mesh, folds inside, degenerate starts."""

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, inverted
from ffdstudio.meshes.measures.bezier import folded, hex_coefficients
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.faces import topology_of
from tests.meshes.shapes import CUBE, UNIT, block, crowd, in_plane


def shape_functions(u, v, w):
    """Trilinear shape functions in VTK's order."""
    a, b, c = 1 - u, 1 - v, 1 - w
    return np.array(
        [a * b * c, u * b * c, u * v * c, a * v * c, a * b * w, u * b * w, u * v * w, a * v * w]
    )


def sampled_jacobians(nodes, count=9):
    """(cells,) least and largest Jacobian over a grid, by complex-step derivatives."""
    least, most = np.full(len(nodes), np.inf), np.full(len(nodes), -np.inf)
    for place in np.stack(np.meshgrid(*[np.linspace(0, 1, count)] * 3), axis=-1).reshape(-1, 3):
        steps = [shape_functions(*(place + 1e-30j * e)).imag / 1e-30 for e in np.eye(3)]
        columns = [np.einsum("knd,n->kd", nodes, step) for step in steps]
        values = np.linalg.det(np.stack(columns, axis=-1))
        least, most = np.minimum(least, values), np.maximum(most, values)
    return least, most


def test_nothing_is_inverted_where_nothing_moved():
    for kind in UNIT:
        mesh = crowd(kind, distortion=0.6)
        assert inverted(mesh).count == 0
        assert inverted(mesh, mesh.points).count == 0


@pytest.mark.parametrize("kind", UNIT)
def test_mirrored_cells_are_inverted_and_only_those(kind):
    mesh = crowd(kind, count=20)
    points = mesh.points.copy()
    points[mesh.cells[kind][7], 1] *= -1
    assert inverted(mesh, points).cells.tolist() == [7]


@pytest.mark.parametrize("kind", ["triangle", "quad", "tetra", "wedge", "hexahedron"])
def test_cells_listed_the_other_way_round_keep_their_sign(kind):
    mesh = crowd(kind, count=20)
    mirrored = mesh.with_points(mesh.points * [1, -1, 1])
    small = in_plane(mesh, 0.01 * np.sin(7 * mesh.points))
    assert inverted(mirrored, mirrored.points + small).count == 0


@pytest.mark.parametrize("kind", ["triangle", "quad"])
def test_a_surface_in_space_is_judged_by_its_undeformed_normal(kind):
    mesh = crowd(kind, count=5, surface=True)
    turned = mesh.points.copy()
    turned[mesh.cells[kind][2]] *= [1, -1, 1]
    assert inverted(mesh, turned).cells.tolist() == [2]


def test_a_collapsed_corner_has_no_sign_to_lose():
    points = CUBE.copy()
    points[[2, 6]] = points[[3, 7]]  # a wedge written as a hexahedron
    mesh = Mesh(points, {"hexahedron": [np.arange(8)]})
    assert inverted(mesh, points + 0.05 * np.sin(9 * points)).count == 0
    assert inverted(mesh, points * [1, 1, -1]).count == 1


def test_second_order_cells_are_judged_by_their_corners():
    mesh = Mesh(np.vstack([CUBE[[0, 1, 3, 4]], np.zeros((6, 3))]), {"tetra10": [np.arange(10)]})
    points = mesh.points.copy()
    points[3, 2] = -1
    assert inverted(mesh, points).count == 1


def test_a_hexahedron_negative_inside_is_found_though_its_corners_are_good():
    rng = np.random.default_rng(0)
    nodes = CUBE + rng.uniform(-0.55, 0.55, (4000, 8, 3))
    block = CellBlock("hexahedron", np.arange(32000).reshape(-1, 8), np.arange(4000))
    found = folded(block, nodes.reshape(-1, 3))
    least, most = sampled_jacobians(nodes)
    seen = (least <= 0) & (most > 0)
    assert not (seen & ~found).any()
    assert (found & ~seen).sum() <= 0.002 * len(nodes)  # between the samples
    corners = hex_coefficients(nodes.transpose(2, 1, 0))[::2, ::2, ::2].reshape(8, -1)
    hidden = np.flatnonzero(found & (corners > 0.02).all(axis=0))
    assert len(hidden) > 5
    for cell in hidden[:5]:
        mesh = Mesh(CUBE, {"hexahedron": [np.arange(8)]})
        result = inverted(mesh, nodes[cell])
        assert (result.count, result.corners) == (1, 0)


def test_bezier_coefficients_bound_the_jacobian():
    nodes = CUBE + np.random.default_rng(3).uniform(-0.4, 0.4, (500, 8, 3))
    bounds = hex_coefficients(nodes.transpose(2, 1, 0)).reshape(27, -1)
    least, most = sampled_jacobians(nodes, 6)
    assert (bounds.min(axis=0) <= least + 1e-12).all()
    assert (bounds.max(axis=0) >= most - 1e-12).all()


def test_a_wedge_is_folded_exactly_where_its_jacobian_changes_sign():
    rng = np.random.default_rng(2)
    nodes = UNIT["wedge"] + rng.uniform(-0.6, 0.6, (3000, 6, 3))
    block = CellBlock("wedge", np.arange(18000).reshape(-1, 6), np.arange(3000))
    found = folded(block, nodes.reshape(-1, 3))
    low, high = nodes[:, :3], nodes[:, 3:]
    values = []
    for t in np.linspace(0, 1, 101):
        at = (1 - t) * low + t * high
        for corner in range(3):
            columns = [at[:, 1] - at[:, 0], at[:, 2] - at[:, 0], high[:, corner] - low[:, corner]]
            values.append(np.linalg.det(np.stack(columns, axis=-1)))
    values = np.array(values)
    seen = (values.min(axis=0) <= 0) & (values.max(axis=0) > 0)
    assert not (seen & ~found).any()
    assert (found & ~seen).sum() <= 3  # between the samples
    ends = (values[:3] > 0).all(axis=0) & (values[-3:] > 0).all(axis=0)
    hidden = np.flatnonzero(found & ends)
    assert len(hidden) > 2
    result = inverted(Mesh(UNIT["wedge"], {"wedge": [np.arange(6)]}), nodes[hidden[0]])
    assert (result.count, result.corners) == (1, 0)


def test_the_cells_of_a_face_based_mesh_are_judged_like_the_same_cells_listed():
    points, cells = block(3, 2, 2)
    listed = Mesh(points, {"hexahedron": cells})
    faced = Mesh(points, faces=topology_of(listed).faces)
    rng = np.random.default_rng(1)
    for size in (0.05, 0.15, 0.3):
        moved = points + size * rng.normal(size=points.shape)
        assert inverted(faced, moved).cells.tolist() == inverted(listed, moved).cells.tolist()


def test_points_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match="points"):
        inverted(crowd("tetra"), np.zeros((3, 3)))
