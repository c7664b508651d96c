"""A body on the screen: its surface, a coarse proxy during drags, points inside a lattice."""

from __future__ import annotations

from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.gui.actors.surface import Rgb, SurfaceActor
from ffdstudio.gui.actors.vtk import actor, cells, poly, ragged_cells
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.project.model import Body
from ffdstudio.project.view.surface import DisplaySurface, Proxy, outer_polygons

MANY_FACES = 60_000  # edges of more faces than these would only be a dark veil
FADED, CLEAR = 2.5, 14.0  # pixels between edges at which they are not seen, and fully


class BodyActor:
    """All that is drawn of one body; told what to show by `Scene`."""

    def __init__(self, renderer: Any, surface: DisplaySurface, mesh: Mesh) -> None:
        self._renderer = renderer
        self.surface, self.flat = surface, is_plane(mesh)
        self.full = SurfaceActor(renderer, len(surface.nodes), surface.shading)
        self.rest = mesh.points[surface.nodes]
        self.spacing = _spacing(surface, self.rest)
        self._hull = outer_polygons(surface, mesh)
        self._far = actor(poly(self.full.points))
        self._far.GetProperty().FrontfaceCullingOn()
        renderer.AddActor(self._far)
        self.proxy = None if surface.proxy is None else self._coarse(surface.proxy)
        self._hull_shown = False
        self._dot_data = poly(self.full.points)
        self.dots = actor(self._dot_data)
        self._hidden: frozenset[str] | None = None
        renderer.AddActor(self.dots)

    def _coarse(self, proxy: Proxy) -> SurfaceActor:
        """Actor of the proxy, without the triangles of the far field."""
        found = SurfaceActor(self._renderer, len(proxy.rows), proxy.shading)
        seen = np.zeros(len(self.surface.nodes), dtype=bool)
        walls = np.repeat(~self._hull, np.diff(self.surface.offsets))
        seen[self.surface.connectivity[walls]] = True
        corners = proxy.triangles
        if proxy.shading is not None:
            corners = proxy.shading.connectivity.reshape(-1, 3)
        kept = corners[seen[proxy.rows[proxy.triangles]].all(axis=1)]
        found.set_cells(cells([kept]), cells([proxy.lines]))
        found.show(False)
        return found

    # ---- looks ------------------------------------------------------------------------------

    def dress(self, body: Body, theme: Theme, edges: bool, outer: bool = False) -> None:
        """Take colour and markers from the body; `outer` is whether to show the far field."""
        self._hull_shown = outer
        if body.hidden_markers != self._hidden:
            self._hidden = body.hidden_markers
            self.full.set_cells(*self._cells(body.hidden_markers, False))
            connectivity = self.surface.connectivity
            far = self._polygons(body.hidden_markers, self._hull, connectivity)
            self._far.GetMapper().GetInput().SetPolys(far)
        own = theme.rgb("mesh" if self.flat else "body")
        colour = _rgb(body.colour) if body.colour else own
        few = len(self.surface.offsets) <= MANY_FACES
        self.full.colour(colour, theme.rgb("edge"), edges and few)
        # a plane mesh is seen straight on: light would only dim it
        self.full.faces.GetProperty().SetLighting(not self.flat)
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

    def _cells(self, hidden: frozenset[str], in_hull: bool) -> tuple[Any, Any]:
        """Polygons as they are shaded, of the hull or not, and lines, but hidden markers."""
        surface, shading = self.surface, self.surface.shading
        lines = surface.lines[~np.isin(surface.line_marker, self._gone(hidden))]
        corners = surface.connectivity if shading is None else shading.connectivity
        return self._polygons(hidden, self._hull == in_hull, corners), cells([lines])

    def _polygons(self, hidden: frozenset[str], among: Mask, connectivity: Indices) -> Any:
        """Some polygons, without those of hidden markers."""
        keep = among & ~np.isin(self.surface.polygon_marker, self._gone(hidden))
        if keep.all():
            return ragged_cells(self.surface.offsets, connectivity)
        sizes = np.diff(self.surface.offsets)
        offsets = np.concatenate([[0], np.cumsum(sizes[keep])])
        return ragged_cells(offsets, connectivity[np.repeat(keep, sizes)])

    def cells_of_walls(self) -> tuple[Any, Any]:
        """Polygons as they are shaded, without the far field, and lines."""
        return self._cells(frozenset(), False)

    def _gone(self, hidden: frozenset[str]) -> list[int]:
        return [number for number, name in enumerate(self.surface.markers) if name in hidden]

    def fade_edges(self, pixel: float) -> None:
        """Let the edges of faces go where they would be a veil; `pixel` is the length of one."""
        wide = self.spacing / max(pixel, 1e-300)
        self.full.edge_strength(float(np.clip((wide - FADED) / (CLEAR - FADED), 0.0, 1.0)))

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

    def show(self, visible: bool, coarse: bool) -> None:
        """Show or hide the surface, and the proxy instead of the surface."""
        coarse = coarse and self.proxy is not None
        self.full.show(visible and not coarse)
        self._far.SetVisibility(visible and not coarse and self._hull_shown)
        if self.proxy is not None:
            self.proxy.show(visible and coarse)
        self.dots.SetVisibility(visible and not coarse)

    def clip(self, plane: Any) -> None:
        """Hide what lies in front of a plane."""
        self._far.GetMapper().RemoveAllClippingPlanes()
        if plane is not None:
            self._far.GetMapper().AddClippingPlane(plane)
        for part in (self.full, self.proxy):
            if part is not None:
                part.clip(plane)

    def close(self) -> None:
        """Leave the renderer."""
        for part in (self.full, self.proxy):
            if part is not None:
                part.close()
        self._renderer.RemoveActor(self.dots)
        self._renderer.RemoveActor(self._far)


def _spacing(surface: DisplaySurface, points: Array) -> float:
    """Typical length of an edge: the median of a sample."""
    corners = surface.connectivity
    if len(corners) < 2:
        return 0.0
    first = np.arange(0, len(corners) - 1, 1 + len(corners) // 2000)
    lengths = np.linalg.norm(points[corners[first + 1]] - points[corners[first]], axis=1)
    return float(np.median(lengths))


def _rgb(colour: str) -> Rgb:
    return tuple(int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))  # type: ignore[return-value]
