"""A surface on the screen: polygons and lines over shared points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk

from ffdstudio.aliases import Array
from ffdstudio.gui.actors.vtk import Points, actor, poly

Rgb = tuple[float, float, float]
Colours = NDArray[np.uint8]


class SurfaceActor:
    """Polygons and lines over shared points.

    It has no normals: VTK shades it face by face on the graphics card. Stored normals would
    be stale from the first drag on.
    """

    def __init__(self, renderer: Any, count: int) -> None:
        self._renderer = renderer
        self.points = Points(count)
        self._faces, self._lines = poly(self.points), poly(self.points)
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

    def colour(self, colour: Rgb, edge: Rgb, edges: bool) -> None:
        """Colour faces, lines, and the edges of faces where they shall be seen."""
        look = self.faces.GetProperty()
        look.SetColor(*colour)
        look.SetEdgeColor(*edge)
        look.SetEdgeVisibility(edges)
        look.SetEdgeOpacity(0.5)
        look.SetAmbient(0.25)
        look.SetDiffuse(0.8)
        self.lines.GetProperty().SetColor(*edge)
        self.lines.GetProperty().SetLineWidth(2.0)
        self.lines.GetProperty().SetLighting(False)

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
