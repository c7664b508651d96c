"""Colours the displayed meshes by a measure.

1. The colours lie on actors of their own over the points of the bodies' actors, drawn a hair
   in front of them, so that they follow every drag without being told.
2. They show what the latest report says: during a drag that is the shape before it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk

from ffdstudio.aliases import Indices
from ffdstudio.gui.actors.body import MANY_FACES, BodyActor
from ffdstudio.gui.actors.vtk import actor, poly, ragged_cells
from ffdstudio.gui.quality.choice import Choice
from ffdstudio.gui.quality.colours import Colours, colours_of, map_of, scale_of
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.sections import SectionPlanes
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.project.checks.checking import Checks
from ffdstudio.project.model import Body
from ffdstudio.project.view.surface import outer_polygons


class Coat:
    """Colours over one body."""

    def __init__(self, renderer: Any, under: BodyActor) -> None:
        self._renderer, self.under = renderer, under
        self._data = poly(under.full.points)
        self.actor = actor(self._data)
        mapper = self.actor.GetMapper()
        mapper.ScalarVisibilityOn()
        mapper.SetColorModeToDirectScalars()
        mapper.SetScalarModeToUseCellData()
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-1.0, -1.0)
        self.actor.GetProperty().SetLighting(False)
        renderer.AddActor(self.actor)

    def paint(self, body: Body, colours: Colours, edge: tuple[float, float, float]) -> None:
        """Show (p, 3) colours of the polygons, without those of hidden markers."""
        surface = self.under.surface
        gone = [n for n, name in enumerate(surface.markers) if name in body.hidden_markers]
        keep = ~np.isin(surface.polygon_marker, gone)
        keep &= ~outer_polygons(surface, body.mesh)
        sizes = np.diff(surface.offsets)
        offsets = np.concatenate([[0], np.cumsum(sizes[keep])])
        self._data.SetPolys(ragged_cells(offsets, surface.connectivity[np.repeat(keep, sizes)]))
        scalars = numpy_to_vtk(np.ascontiguousarray(colours[keep]), deep=True)
        scalars.SetName("colours")
        self._data.GetCellData().SetScalars(scalars)
        self._data.Modified()
        look = self.actor.GetProperty()
        look.SetEdgeColor(*edge)
        look.SetEdgeOpacity(0.45)
        self.few = len(offsets) <= MANY_FACES

    def follow(self, on: bool, edges: bool) -> None:
        """Be seen where the body's surface is, cut off by the same planes."""
        faces = self.under.full.faces
        self.actor.SetVisibility(bool(on and faces.GetVisibility()))
        mapper, planes = self.actor.GetMapper(), faces.GetMapper().GetClippingPlanes()
        if planes is None:
            mapper.RemoveAllClippingPlanes()
        else:
            mapper.SetClippingPlanes(planes)
        self.actor.GetProperty().SetEdgeVisibility(edges and self.few)

    def close(self) -> None:
        """Leave the renderer."""
        self._renderer.RemoveActor(self.actor)


class Painter:
    """The coats of all bodies."""

    def __init__(
        self, studio: Studio, scene: Scene, sections: SectionPlanes, checks: Checks, choice: Choice
    ) -> None:
        self._studio, self._scene, self._checks, self._choice = studio, scene, checks, choice
        self._sections = sections
        self.coats: dict[str, Coat] = {}
        self._listening = Listening(
            (checks.changed, self._on_report),
            (checks.digested, self._on_report),
            (choice.changed, self.paint),
            (studio.document.structure_changed, self.paint),
            (sections.shown, self._paint_section),
        )
        scene.viewport.about_to_paint.connect(self._follow)

    def close(self) -> None:
        """Stop listening and leave the picture."""
        self._listening.stop()
        self._scene.viewport.about_to_paint.disconnect(self._follow)
        for coat in self.coats.values():
            coat.close()
        self.coats.clear()

    def _on_report(self, _key: str) -> None:
        self.paint()

    def paint(self) -> None:
        """Colour what can be coloured and take the coat off the rest."""
        bodies = self._studio.document.model.bodies if self._choice.wanted.colour != "off" else ()
        found = {body.key: self._outside(body.key) for body in bodies}
        for key in [key for key in self.coats if found.get(key) is None]:
            self.coats.pop(key).close()
        for body in bodies:
            colours = found[body.key]
            if colours is not None:
                self._coat(body.key).paint(body, colours, self._studio.theme.rgb("edge"))
        for key in self._sections.actors:
            self._paint_section(key)
        self._scene.viewport.update()

    def _paint_section(self, key: str) -> None:
        """Colour the cells that a section cuts, or take the colours away."""
        found, actor = self._sections.cuts[key], self._sections.actors[key]
        colours = None
        if self._choice.wanted.colour != "off" and len(found.cells):
            colours = self._colours(key, found.cells)
        actor.colour_faces(colours)
        self._scene.viewport.update()

    def _coat(self, key: str) -> Coat:
        under, old = self._scene.bodies[key], self.coats.get(key)
        if old is None or old.under is not under:
            if old is not None:
                old.close()
            self.coats[key] = Coat(self._scene.viewport.renderer, under)
        return self.coats[key]

    def _outside(self, key: str) -> Colours | None:
        """(p, 3) colour of each displayed polygon; None while it is not known."""
        cells = self._checks.cells(key)
        return None if cells is None else self._colours(key, cells)

    def _colours(self, key: str, cells: Indices) -> Colours | None:
        """(k, 3) colours of cells, -1 for none; None while they are not known."""
        wanted, report = self._choice.wanted, self._checks.report(key)
        digest = self._checks.digest(key, wanted.measure)
        if report is None or digest is None:
            return None
        change = wanted.colour == "change"
        values = digest.change if change else report.measures[wanted.measure]
        chosen = np.where(cells < 0, np.nan, values[cells])
        theme = self._studio.theme
        scale, colours = scale_of(digest, change), map_of(wanted.measure, change, theme)
        found = colours_of(chosen, scale, colours, theme)
        inverted = np.round(np.array(theme.rgb("danger")) * 255)
        found[(cells >= 0) & report.inverted[cells]] = inverted.astype(np.uint8)
        return found

    def _follow(self) -> None:
        shown = self._studio.state.shown
        for coat in self.coats.values():
            coat.follow(True, shown.edges)
