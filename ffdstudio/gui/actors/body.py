"""A body on the screen: its surface, a coarse proxy during drags, its ghost, points inside."""

from __future__ import annotations

from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.gui.actors.surface import Rgb, SurfaceActor
from ffdstudio.gui.actors.vtk import actor, cells, poly, ragged_cells
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.project.model import Body
from ffdstudio.project.view.surface import DisplaySurface, Proxy

MANY_FACES = 60_000  # edges of more faces than these would only be a dark veil


class BodyActor:
    """All that is drawn of one body; told what to show by `Scene`."""

    def __init__(self, renderer: Any, surface: DisplaySurface, mesh: Mesh) -> None:
        self._renderer = renderer
        self.surface = surface
        self.full = SurfaceActor(renderer, len(surface.nodes))
        rest = mesh.points[surface.nodes]
        self._hull = hull(surface, mesh)
        self._far = actor(poly(self.full.points))
        self._far.GetProperty().FrontfaceCullingOn()
        renderer.AddActor(self._far)
        self.proxy: SurfaceActor | None = None
        if surface.proxy is not None:
            self.proxy = SurfaceActor(renderer, len(surface.proxy.rows))
            triangles = self._walls_of(surface.proxy)
            self.proxy.set_cells(cells([triangles]), cells([surface.proxy.lines]))
            self.proxy.show(False)
        self._rest = rest
        self._ghost: SurfaceActor | None = None
        self._dot_data = poly(self.full.points)
        self.dots = actor(self._dot_data)
        self._hidden: frozenset[str] | None = None
        renderer.AddActor(self.dots)

    def _walls_of(self, proxy: Proxy) -> Indices:
        """Triangles of the proxy without those of the far field."""
        surface = self.surface
        seen = np.zeros(len(surface.nodes), dtype=bool)
        seen[surface.connectivity[np.repeat(~self._hull, np.diff(surface.offsets))]] = True
        return proxy.triangles[seen[proxy.rows[proxy.triangles]].all(axis=1)]

    # ---- looks ------------------------------------------------------------------------------

    def dress(self, body: Body, theme: Theme, edges: bool) -> None:
        """Take colour and markers from the body."""
        if body.hidden_markers != self._hidden:
            self._hidden = body.hidden_markers
            self.full.set_cells(*self._cells(body.hidden_markers, self._hull, False))
            far = self._cells(body.hidden_markers, self._hull, True)[0]
            self._far.GetMapper().GetInput().SetPolys(far)
        colour = _rgb(body.colour) if body.colour else theme.rgb("mesh")
        few = len(self.surface.offsets) <= MANY_FACES
        self.full.colour(colour, theme.rgb("edge"), edges and few)
        # a plane mesh is seen straight on: light would only dim it
        self.full.faces.GetProperty().SetLighting(not is_plane(body.mesh))
        if self.proxy is not None:
            self.proxy.colour(colour, theme.rgb("edge"), False)
        self._far.GetProperty().SetColor(*theme.rgb("far"))
        self._far.GetProperty().SetLighting(False)
        self._far.GetProperty().SetRepresentationToWireframe()
        self._far.GetProperty().SetOpacity(0.6)
        look = self.dots.GetProperty()
        look.SetColor(*theme.rgb("inside"))
        look.SetPointSize(4.0)
        look.SetLighting(False)

    def _cells(
        self, hidden: frozenset[str], hull: Mask | None = None, in_hull: bool = False
    ) -> tuple[Any, Any]:
        """Polygons, of the hull or not, and lines, without those of hidden markers."""
        surface = self.surface
        gone = [number for number, name in enumerate(surface.markers) if name in hidden]
        lines = surface.lines[~np.isin(surface.line_marker, gone)]
        keep = ~np.isin(surface.polygon_marker, gone)
        if hull is not None:
            keep &= hull == in_hull
        if keep.all():
            return ragged_cells(surface.offsets, surface.connectivity), cells([lines])
        sizes = np.diff(surface.offsets)
        offsets = np.concatenate([[0], np.cumsum(sizes[keep])])
        return ragged_cells(offsets, surface.connectivity[np.repeat(keep, sizes)]), cells([lines])

    # ---- places -----------------------------------------------------------------------------

    def place(self, points: Array, origin: Array) -> None:
        """Show the full surface at these points."""
        self.full.place(points, origin)

    def place_proxy(self, points: Array, origin: Array) -> None:
        """Show the proxy at these points."""
        assert self.proxy is not None
        self.proxy.place(points, origin)

    def mark_inside(self, inside: Mask | None) -> None:
        """Dot the points inside a lattice; None dots nothing."""
        chosen = np.zeros(0, np.int64) if inside is None else np.flatnonzero(inside)
        self._dot_data.SetVerts(cells([chosen[:, None]]))
        self._dot_data.Modified()

    def show(self, visible: bool, ghost: bool, coarse: bool, theme: Theme, origin: Array) -> None:
        """Show or hide the surface, its ghost, and the proxy instead of the surface."""
        coarse = coarse and self.proxy is not None
        self.full.show(visible and not coarse)
        self._far.SetVisibility(visible and not coarse)
        if self.proxy is not None:
            self.proxy.show(visible and coarse)
        self.dots.SetVisibility(visible and not coarse)
        if visible and ghost:
            self._make_ghost(theme, origin).show(True)
        elif self._ghost is not None:
            self._ghost.show(False)

    def _make_ghost(self, theme: Theme, origin: Array) -> SurfaceActor:
        """Faint surface at rest; of a plane mesh only the outline, its cells would be a veil."""
        if self._ghost is None:
            self._ghost = SurfaceActor(self._renderer, len(self.surface.nodes))
            polygons, lines = self._cells(frozenset(), self._hull, False)
            flat = len(self.surface.lines) > 0
            self._ghost.set_cells(cells([]) if flat else polygons, lines)
        self._ghost.place(self._rest, origin)
        self._ghost.colour(theme.rgb("ghost"), theme.rgb("ghost"), False)
        self._ghost.fade(0.3)
        self._ghost.lines.GetProperty().SetOpacity(0.9)
        return self._ghost

    def clip(self, plane: Any) -> None:
        """Hide what lies in front of a plane."""
        self._far.GetMapper().RemoveAllClippingPlanes()
        if plane is not None:
            self._far.GetMapper().AddClippingPlane(plane)
        for part in (self.full, self.proxy, self._ghost):
            if part is not None:
                part.clip(plane)

    def close(self) -> None:
        """Leave the renderer."""
        for part in (self.full, self.proxy, self._ghost):
            if part is not None:
                part.close()
        self._renderer.RemoveActor(self.dots)
        self._renderer.RemoveActor(self._far)


def hull(surface: DisplaySurface, mesh: Mesh) -> Mask:
    """(p,) polygons of the far field around walls; seen from inside only, for the walls' sake."""
    names = wall_markers(mesh)
    if not names or is_plane(mesh):
        return np.zeros(len(surface.polygon_marker), dtype=bool)
    inner = [surface.markers.index(name) for name in names]
    return ~np.isin(surface.polygon_marker, inner)


def _rgb(colour: str) -> Rgb:
    return tuple(int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))  # type: ignore[return-value]
