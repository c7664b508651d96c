"""Cells of higher order: nodes where VTK has them, and folds that their corners do not show."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.meshes import Mesh, coverage, inverted, quality, safe_amplitude
from ffdstudio.meshes.measures.curved import coefficients, curve, order_of, places, split
from ffdstudio.meshes.safety.guard import Guard

NUMBERS = {
    "triangle6": 22, "triangle7": 34, "quad8": 23, "quad9": 28, "tetra10": 24, "hexahedron20": 25,
    "hexahedron27": 29, "wedge15": 26, "wedge18": 32, "triangle10": 69, "triangle15": 69,
    "quad16": 70, "quad25": 70, "tetra20": 71, "tetra35": 71, "hexahedron64": 72,
}  # fmt: skip
KINDS = [*NUMBERS, "pyramid13", "pyramid14"]


def nodes_of(kind):
    """(nodes, 3) of a cell with straight edges."""
    x = places(kind)
    if kind.startswith("pyramid"):
        a, b, c = x.T
        x = np.column_stack([(1 - c) * a + c / 2, (1 - c) * b + c / 2, c])
    return np.hstack([x, np.zeros((len(x), 3 - x.shape[1]))])


def mesh_of(kind, x=None):
    x = nodes_of(kind) if x is None else x
    flat = split(kind)[0] in ("triangle", "quad")
    return Mesh(x, {kind: [range(len(x))]}, dimension=2 if flat else 3)


@pytest.mark.parametrize("kind", NUMBERS)
def test_nodes_lie_where_vtk_has_them(kind):
    import vtk

    cell = vtk.vtkGenericCell.InstantiateCell(NUMBERS[kind])
    x = places(kind)
    if NUMBERS[kind] >= 69:
        cell.GetPointIds().SetNumberOfIds(len(x))
        cell.GetPoints().SetNumberOfPoints(len(x))
        if hasattr(cell, "SetUniformOrderFromNumPoints"):
            cell.SetUniformOrderFromNumPoints(len(x))
        else:
            cell.Initialize()
    flat = cell.GetParametricCoords()
    theirs = np.array([flat[i] for i in range(3 * len(x))]).reshape(-1, 3)[:, : x.shape[1]]
    assert x == pytest.approx(theirs, abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_coefficients_give_the_jacobian_of_the_map(kind):
    """By differences of the map at random places: a corner's coefficient is a value."""
    rng = np.random.default_rng(1)
    x = nodes_of(kind)
    affine = rng.uniform(-1, 1, (3, 3)) + 2 * np.eye(3)
    if x[:, 2].max() == 0:
        affine[2], affine[:, 2] = [0, 0, 1], [0, 0, 1]
    found = coefficients(kind, (x @ affine.T).T[:, :, None])
    assert found == pytest.approx(np.linalg.det(affine), rel=1e-6)
    assert found.shape == (*curve(kind).shape, 1)


@pytest.mark.parametrize("kind", KINDS)
def test_a_node_between_corners_that_goes_astray_is_seen(kind):
    """The corners stay, the middle of an edge is pulled through the cell."""
    mesh = mesh_of(kind)
    first = split(kind)[0]
    count = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}[first]
    move = np.zeros_like(mesh.points)
    centre = mesh.points.mean(axis=0)
    move[count] = 4 * (centre - mesh.points[count])
    assert coverage(mesh).missing == 0
    assert inverted(mesh, mesh.points + move).count == 1
    assert quality(mesh, mesh.points + move).inverted.tolist() == [True]
    limit = safe_amplitude(mesh, move)
    assert 0 < limit < 1
    assert inverted(mesh, mesh.points + 0.999 * limit * move).count == 0
    assert inverted(mesh, mesh.points + 1.001 * limit * move).count == 1


@pytest.mark.parametrize("kind", ["tetra10", "quad9", "hexahedron20"])
def test_the_guard_stops_where_the_amplitude_ends(kind):
    mesh = mesh_of(kind)
    first = len(places(split(kind)[0] + str(len(mesh.points))))
    node = {"tetra10": 4, "quad9": 4, "hexahedron20": 8}[kind]
    direction = mesh.points.mean(axis=0) - mesh.points[node]
    move = np.zeros_like(mesh.points)
    move[node] = direction
    guard = Guard(mesh, mesh.points, influence=[1.0], rows=[node])
    assert first == len(mesh.points)
    assert guard.limit(direction) == pytest.approx(safe_amplitude(mesh, move), rel=1e-6)


def test_cells_folded_at_rest_or_of_unknown_order_are_said_to_be_unchecked():
    x = nodes_of("tetra10")
    mixed = x[[0, 1, 2, 3, 9, 8, 7, 6, 5, 4]]  # nodes in another order
    assert coverage(mesh_of("tetra10", mixed)).unchecked == {"tetra10 folded at rest": 1}
    wild = Mesh(np.random.default_rng(0).random((12, 3)), {"wedge12": [range(12)]})
    assert coverage(wild).unchecked == {"wedge12": 1}
    assert order_of("hexahedron125") == 0  # rounding would be too large
