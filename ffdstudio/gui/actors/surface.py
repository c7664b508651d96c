"""A surface on the screen: polygons and lines over shared points.

1. Faces that are shaded smoothly are drawn over points of their own, one for each normal that a
   point has (`Shading`); lines, dots and coats share the points of the surface.
2. Normals are made anew whenever points are placed: stored ones would be stale from the first
   drag on.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk

from ffdstudio.aliases import Array
from ffdstudio.gui.actors.vtk import Points, actor, poly
from ffdstudio.project.view.shading import Shading

Rgb = tuple[float, float, float]
Colours = NDArray[np.uint8]
AMBIENT, DIFFUSE, SPECULAR, POWER = 0.42, 0.66, 0.28, 28.0
EDGE_OPACITY = 0.5


class SurfaceActor:
    """Polygons and lines over shared points.

    Attributes
    ----------
    points : Points
        Of the surface, (count, 3).
    shading : Shading or None
        Whose drawn points the polygons of `set_cells` refer to; None for facets.
    """

    def __init__(self, renderer: Any, count: int, shading: Shading | None = None) -> None:
        self._renderer = renderer
        self.points, self.shading = Points(count), shading
        self._drawn = self.points if shading is None else Points(len(shading.rows))
        self._faces, self._lines = poly(self._drawn), poly(self.points)
        self._normals: NDArray[np.float32] | None = None
        if shading is not None:
            self._normals = np.zeros((len(shading.rows), 3), dtype=np.float32)
            self._normals[:, 2] = 1.0
            self._normal_data = numpy_to_vtk(self._normals)  # shares the memory
            self._normal_data.SetName("Normals")
            self._faces.GetPointData().SetNormals(self._normal_data)
        self.faces, self.lines = actor(self._faces), actor(self._lines)
        for item in self.actors:
            renderer.AddActor(item)

    @property
    def actors(self) -> list[Any]:
        """Everything that was added to the renderer."""
        return [self.faces, self.lines]

    def set_cells(self, polygons: Any, lines: Any) -> None:
        """Draw these cell arrays."""
        self._faces.SetPolys(polygons)
        self._lines.SetLines(lines)

    def place(self, points: Array, origin: Array) -> None:
        """Move to these points, (n, 3) in world units."""
        self.points.write(points, origin)
        if self.shading is not None and self._normals is not None:
            self._drawn.array[:] = self.points.array[self.shading.rows]
            self._drawn.changed()
            self._normals[:] = self.shading.normals(points)
            self._normal_data.Modified()

    def colour(self, colour: Rgb, edge: Rgb, edges: bool) -> None:
        """Colour faces, lines, and the edges of faces where they shall be seen."""
        look = self.faces.GetProperty()
        look.SetColor(*colour)
        look.SetEdgeColor(*edge)
        look.SetEdgeVisibility(edges)
        look.SetEdgeOpacity(EDGE_OPACITY)
        look.SetAmbient(AMBIENT)
        look.SetDiffuse(DIFFUSE)
        look.SetSpecular(SPECULAR)
        look.SetSpecularPower(POWER)
        if self.shading is not None:
            look.SetInterpolationToPhong()
        self.lines.GetProperty().SetColor(*edge)
        self.lines.GetProperty().SetLineWidth(2.0)
        self.lines.GetProperty().SetLighting(False)

    def edge_strength(self, strength: float) -> None:
        """Fade the edges of faces: 1 as usual, 0 not at all."""
        self.faces.GetProperty().SetEdgeOpacity(EDGE_OPACITY * strength)

    def colour_faces(self, colours: Colours | None) -> None:
        """Give each polygon a colour (red, green, blue) of its own; None takes them away."""
        mapper = self.faces.GetMapper()
        mapper.SetScalarVisibility(colours is not None)
        if colours is not None:
            scalars = numpy_to_vtk(np.ascontiguousarray(colours), deep=True)
            scalars.SetName("colours")
            self._faces.GetCellData().SetScalars(scalars)
            mapper.SetColorModeToDirectScalars()
            mapper.SetScalarModeToUseCellData()

    def paint(self, values: Array | None, table: Any = None) -> None:
        """Colour faces and lines by a value per point through a lookup table; None: not at all."""
        for data, item, rows in self._valued():
            mapper = item.GetMapper()
            mapper.SetScalarVisibility(values is not None)
            if values is None:
                continue
            chosen = values if rows is None else values[rows]
            scalars = numpy_to_vtk(np.ascontiguousarray(chosen, dtype=np.float32), deep=True)
            scalars.SetName("values")
            data.GetPointData().SetScalars(scalars)
            mapper.SetScalarModeToUsePointData()
            mapper.SetColorModeToMapScalars()
            mapper.SetLookupTable(table)
            mapper.UseLookupTableScalarRangeOn()
            mapper.InterpolateScalarsBeforeMappingOn()

    def _valued(self) -> list[tuple[Any, Any, Any]]:
        """Data, actor, and which points of the surface it draws."""
        rows = None if self.shading is None else self.shading.rows
        return [(self._faces, self.faces, rows), (self._lines, self.lines, None)]

    def fade(self, opacity: float) -> None:
        """Make it translucent."""
        for item in self.actors:
            item.GetProperty().SetOpacity(opacity)

    def clip(self, plane: Any) -> None:
        """Hide what lies in front of a vtkPlane; None shows all."""
        for item in self.actors:
            item.GetMapper().RemoveAllClippingPlanes()
            if plane is not None:
                item.GetMapper().AddClippingPlane(plane)

    def show(self, visible: bool) -> None:
        """Show or hide it."""
        for item in self.actors:
            item.SetVisibility(visible)

    def close(self) -> None:
        """Leave the renderer."""
        for item in self.actors:
            self._renderer.RemoveActor(item)
