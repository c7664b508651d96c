"""NumPy arrays as VTK data, and the few lines that every actor needs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from ffdstudio.aliases import Array, Indices


class Points:
    """Displayed coordinates: float32, relative to an origin, written in place."""

    def __init__(self, count: int) -> None:
        self.array = np.zeros((count, 3), dtype=np.float32)
        self.vtk = vtkPoints()
        self._data = numpy_to_vtk(self.array)  # shares the memory of `array`
        self.vtk.SetData(self._data)

    def write(self, points: Array, origin: Array, rows: Indices | slice = slice(None)) -> None:
        """Take world coordinates for some rows and mark the data as changed."""
        self.array[rows] = points - origin
        self.changed()

    def changed(self) -> None:
        """Mark the data as changed, after `array` has been written to."""
        self._data.Modified()
        self.vtk.Modified()


def cells(groups: Iterable[Indices]) -> Any:
    """Cell array of several blocks (k, nodes) of point numbers."""
    blocks = [np.asarray(group, dtype=np.int64) for group in groups if len(group)]
    sizes = [np.full(len(block), block.shape[1]) for block in blocks]
    none = np.zeros(0, dtype=np.int64)
    offsets = np.concatenate([[0], np.cumsum(np.concatenate([none, *sizes]))])
    flat = np.concatenate([none, *(block.ravel() for block in blocks)])
    return ragged_cells(offsets, flat)


def ragged_cells(offsets: Indices, nodes: Indices) -> Any:
    """Cell array from flat point numbers and (k + 1) offsets."""
    array = vtkCellArray()
    array.SetData(
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(offsets, np.int64), deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(nodes, np.int64), deep=True),
    )
    return array


def poly(points: Points, polys: Any = None, lines: Any = None, verts: Any = None) -> Any:
    """Poly data over shared points."""
    data = vtkPolyData()
    data.SetPoints(points.vtk)
    for part, setter in ((polys, data.SetPolys), (lines, data.SetLines), (verts, data.SetVerts)):
        if part is not None:
            setter(part)
    return data


def actor(data: Any, pickable: bool = False) -> Any:
    """Actor for poly data."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    mapper.SetResolveCoincidentTopologyToPolygonOffset()  # lines on faces stay visible
    new = vtkActor()
    new.SetMapper(mapper)
    new.SetPickable(pickable)
    return new


def colour_points(data: Any, colours: NDArray[np.uint8]) -> None:
    """Give poly data a colour (red, green, blue) a point."""
    scalars = numpy_to_vtk(np.ascontiguousarray(colours), deep=True)
    scalars.SetName("colours")
    data.GetPointData().SetScalars(scalars)


def show_colours(target: Any) -> None:
    """Let an actor use the colours of its points as they are."""
    mapper = target.GetMapper()
    mapper.ScalarVisibilityOn()
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarModeToUsePointData()
