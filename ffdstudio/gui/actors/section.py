"""A plane through a volume mesh: the cells it cuts.

1. `cut` is work for a worker: arrays in, arrays out, no OpenGL.
2. Linear cells are cut by VTK's plane cutter into filled polygons. Meshes that list faces
   (OpenFOAM, Fluent) get the outlines of their cells: each face gives the line along which
   the plane crosses it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from ffdstudio.aliases import Array, Indices
from ffdstudio.gui.actors.surface import Rgb, SurfaceActor
from ffdstudio.gui.actors.vtk import Points, cells, ragged_cells
from ffdstudio.meshes import Faces, Mesh
from ffdstudio.meshes.topology import base_type, corners

CELL = "cell"  # name of the numbers of cells among VTK's data
VTK_TYPES = {"tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14}


@dataclass(frozen=True, eq=False)
class Cut:
    """Polygons (flat numbers and offsets) and lines over points, in world units.

    `cells` tells the cell of each polygon, numbered as the cells of the mesh are.
    """

    points: Array
    connectivity: Indices
    offsets: Indices
    lines: Indices
    cells: Indices


def cut(mesh: Mesh, points: Array, origin: Array, normal: Array) -> Cut:
    """Cut a volume mesh with its nodes at `points` along a plane."""
    if mesh.faces is not None:
        return _cut_faces(mesh.faces, points, origin, normal)
    return _cut_cells(mesh, points, origin, normal)


def _cut_cells(mesh: Mesh, points: Array, origin: Array, normal: Array) -> Cut:
    from vtkmodules.vtkCommonDataModel import vtkPlane
    from vtkmodules.vtkFiltersCore import vtkCutter

    plane, cutter = vtkPlane(), vtkCutter()
    plane.SetNormal(*normal)  # the points are relative to the plane's origin
    cutter.SetCutFunction(plane)
    cutter.SetInputData(_grid(mesh, points - origin))
    cutter.GenerateTrianglesOff()
    cutter.Update()
    out = cutter.GetOutput()
    if out.GetNumberOfPoints() == 0:
        return _nothing()
    polys = out.GetPolys()
    return Cut(
        vtk_to_numpy(out.GetPoints().GetData()).astype(np.float64) + origin,
        vtk_to_numpy(polys.GetConnectivityArray()).astype(np.int64),
        vtk_to_numpy(polys.GetOffsetsArray()).astype(np.int64),
        np.zeros((0, 2), dtype=np.int64),
        vtk_to_numpy(out.GetCellData().GetArray(CELL)).astype(np.int64),
    )


def _grid(mesh: Mesh, points: Array) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    solid = {kind: nodes for kind, nodes in mesh.cells.items() if base_type(kind) in VTK_TYPES}
    blocks = [corners(kind, nodes) for kind, nodes in solid.items()]
    types = [np.full(len(nodes), VTK_TYPES[base_type(k)], np.uint8) for k, nodes in solid.items()]
    places = Points(len(points))
    places.write(points, np.zeros(3))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(places.vtk)
    grid.SetCells(numpy_to_vtk(np.concatenate(types), deep=True), cells(blocks))
    numbers = numpy_to_vtk(np.arange(grid.GetNumberOfCells()), deep=True)
    numbers.SetName(CELL)
    grid.GetCellData().AddArray(numbers)
    return grid


def _cut_faces(faces: Faces, points: Array, origin: Array, normal: Array) -> Cut:
    """Two crossings of each face whose nodes lie on both sides."""
    sizes = np.diff(faces.offsets)
    face = np.repeat(np.arange(len(sizes)), sizes)
    begin = np.arange(len(faces.nodes))
    following = begin + 1
    following[faces.offsets[1:] - 1] = faces.offsets[:-1]
    side = (points - origin) @ normal
    a, b = faces.nodes[begin], faces.nodes[following]
    crossing = (side[a] > 0) != (side[b] > 0)
    counts = np.bincount(face[crossing], minlength=len(sizes))
    crossing &= counts[face] == 2
    a, b = a[crossing], b[crossing]
    share = side[a] / (side[a] - side[b])
    found = points[a] + share[:, None] * (points[b] - points[a])
    lines = np.arange(len(found)).reshape(-1, 2)
    none = np.zeros(0, np.int64)
    return Cut(found, none, np.zeros(1, np.int64), lines, none)


def _nothing() -> Cut:
    none = np.zeros(0, dtype=np.int64)
    return Cut(np.zeros((0, 3)), none, np.zeros(1, np.int64), none.reshape(0, 2), none)


def show(renderer: Any, found: Cut, origin: Array, colour: Rgb, edge: Rgb) -> SurfaceActor:
    """Put a cut into the picture."""
    actor = SurfaceActor(renderer, len(found.points))
    actor.set_cells(ragged_cells(found.offsets, found.connectivity), cells([found.lines]))
    actor.place(found.points, origin)
    actor.colour(colour, edge, True)
    actor.lines.GetProperty().SetLineWidth(1.0)
    actor.faces.GetProperty().SetLighting(False)
    return actor
