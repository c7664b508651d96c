"""Keeps what is drawn in step with the document and the viewer's choices.

1. Actors are made and dropped in `_sync`, coloured in `_dress`, moved in `_place`.
2. During a drag nothing is done per mouse event: the document says once that something moves,
   the viewport is asked for a repaint, and just before it paints (`about_to_paint`) the
   displayed points are brought up to date. So fifty moves cost one deformation and one picture.
3. `origin` is fixed when the first thing appears and when everything is new: moving it means
   writing all displayed points again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.frozen import frozen_mask
from ffdstudio.gui.actors.body import BodyActor
from ffdstudio.gui.actors.ghost import Ghost
from ffdstudio.gui.actors.lattice import LatticeActor
from ffdstudio.gui.first_view import interesting
from ffdstudio.gui.navigation import AXIS_VIEWS, looking
from ffdstudio.gui.panels.draft import inside_box
from ffdstudio.gui.state import WindowState
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.gui.viewport import Viewport
from ffdstudio.meshes.quasi2d import is_plane, plane_axes
from ffdstudio.project.document import Document
from ffdstudio.project.model import LatticeItem

PREVIEW = "preview"
MANY_FACES = 800_000  # of a surface: more are turned as a proxy
CUED = 50_000  # points of a net that fade with the distance


class Scene:
    """Actors of bodies and lattices in the viewport."""

    def __init__(
        self, viewport: Viewport, document: Document, state: WindowState, theme: Theme
    ) -> None:
        self.viewport, self.document, self.state, self.theme = viewport, document, state, theme
        self.bodies: dict[str, BodyActor] = {}
        self.ghost = Ghost(viewport.renderer)
        self.lattices: dict[str, LatticeActor] = {}
        self._nets: dict[str, tuple[int, ...]] = {}
        self._listening = Listening(
            (document.moving, self._on_moving),
            (document.moved, self._on_moved),
            (document.structure_changed, self._on_structure_changed),
            (document.selection_changed, self._on_marks_changed),
            (state.hovered_changed, self._on_marks_changed),
            (state.shown_changed, self._on_shown_changed),
            (state.navigating_changed, self._on_navigating),
            (state.preview_changed, self._on_preview_changed),
        )
        viewport.about_to_paint.connect(self._follow)
        self._on_structure_changed()

    def close(self) -> None:
        """Stop listening and take everything out of the viewport."""
        self._listening.stop()
        for body in self.bodies.values():
            body.close()
        self.ghost.close()
        for net in self.lattices.values():
            net.close()
        self.bodies.clear()
        self.lattices.clear()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self.theme = theme
        self._dress()

    # ---- what listens -----------------------------------------------------------------------

    def _on_structure_changed(self) -> None:
        empty = not self.bodies and not self.lattices
        self._sync()
        if empty and (self.bodies or self.lattices):
            self._first_look()
        self._dress()
        self._place()

    def _on_navigating(self) -> None:
        """Large surfaces are turned as their proxies, which have to be where those are."""
        for body in self.document.model.bodies:
            actor = self.bodies[body.key]
            if self.state.navigating and actor.proxy is not None and self.document.editing is None:
                actor.place_proxy(self.document.proxy_points(body.key), self.viewport.origin)
        self._show()

    def _on_moving(self) -> None:
        self.viewport.update()

    def _on_moved(self) -> None:
        self._place()

    def _on_marks_changed(self) -> None:
        for item in self.document.model.lattices:
            self._mark(item)
        self.viewport.update()

    def _on_shown_changed(self) -> None:
        self._dress()
        self._place()

    def _on_preview_changed(self) -> None:
        begins = PREVIEW not in self._nets
        self._sync_preview()
        self._frame()
        if begins and self.state.preview is not None:
            net = self.state.preview.control_points.reshape(-1, 3)
            self.viewport.fit(np.array([net.min(axis=0), net.max(axis=0)]))
        self._dress()
        self._place()

    def _follow(self) -> None:
        """Just before a picture: bring a drag's points up to date, and what depends on the view."""
        pixel = 2 * self.viewport.view.half_height / max(1, self.viewport.height())
        for actor in self.bodies.values():
            actor.fade_edges(pixel)
        for net in self.lattices.values():
            if net.count <= CUED:
                net.cue(self.viewport.view.back)
        if self.document.editing is None:
            return
        self.document.refresh()
        origin = self.viewport.origin
        for body in self.document.model.bodies:
            actor = self.bodies[body.key]
            if body.visible and actor.proxy is not None:
                actor.place_proxy(self.document.proxy_points(body.key), origin)
            elif body.visible:
                actor.place(self.document.points(body.key), origin)
        for item in self.document.model.lattices:
            self.lattices[item.key].place(item.current.control_points, origin)
        self._reveal()

    # ---- actors -----------------------------------------------------------------------------

    def _sync(self) -> None:
        model, renderer = self.document.model, self.viewport.renderer
        wanted = {body.key for body in model.bodies}
        for key in [k for k in self.bodies if k not in wanted]:
            self.bodies.pop(key).close()
        for body in model.bodies:
            surface = self.document.surface(body.key)
            old = self.bodies.get(body.key)
            if old is not None and old.surface is not surface:
                self.bodies.pop(body.key).close()
            if body.key not in self.bodies:
                self.bodies[body.key] = BodyActor(renderer, surface, body.mesh)
        shapes = {item.key: item.rest.shape for item in model.lattices}
        if PREVIEW in self._nets:
            shapes[PREVIEW] = self._nets[PREVIEW]
        self._sync_nets(shapes)

    def _sync_nets(self, shapes: dict[str, tuple[int, ...]]) -> None:
        for key in [k for k, shape in self._nets.items() if shapes.get(k) != shape]:
            self.lattices.pop(key).close()
            del self._nets[key]
        for key, shape in shapes.items():
            if key not in self.lattices:
                scale = self.viewport.devicePixelRatioF()
                self.lattices[key] = LatticeActor(self.viewport.renderer, shape, scale)
                self._nets[key] = shape

    def _sync_preview(self) -> None:
        shapes = {key: shape for key, shape in self._nets.items() if key != PREVIEW}
        if self.state.preview is not None:
            shapes[PREVIEW] = self.state.preview.shape
        self._sync_nets(shapes)

    # ---- looks ------------------------------------------------------------------------------

    def _dress(self) -> None:
        model, shown = self.document.model, self.state.shown
        for body in model.bodies:
            self.bodies[body.key].dress(body, self.theme, shown.edges, shown.outer)
        for item in model.lattices:
            self._mark(item)
        if self.state.preview is not None:
            preview, none = self.state.preview, np.zeros(self.state.preview.shape, dtype=bool)
            frozen = frozen_mask(preview.shape, self.state.preview_frozen, self.state.preview_open)
            masks = (none.ravel(), frozen.ravel(), none.ravel())
            self.lattices[PREVIEW].mark(self.theme, *masks)
        self._show()

    def _show(self) -> None:
        self._reveal()
        self.viewport.update()

    def _reveal(self) -> None:
        model, shown = self.document.model, self.state.shown
        editing = self.document.editing is not None
        for body in model.bodies:
            actor = self.bodies[body.key]
            turning = self.state.navigating and len(actor.surface.offsets) > MANY_FACES
            actor.show(body.visible, editing or turning)
        seen = [self.bodies[body.key] for body in model.bodies if body.visible]
        self.ghost.show(seen if shown.ghost else (), self.theme, self.viewport.origin)
        building = self.state.preview is not None
        for item in model.lattices:
            self.lattices[item.key].show(item.visible and shown.net and not building)

    def _mark(self, item: LatticeItem) -> None:
        model = self.document.model
        active = item.key == model.active
        selected = np.zeros(item.rest.shape, dtype=bool)
        hovered = None
        if active:
            for point in self.document.selection:
                selected[point] = True
            hovered = self._hovered(item.rest.shape)
        weighted = (item.current.weights != 1).ravel()
        masks = (selected.ravel(), item.frozen_mask.ravel(), weighted)
        self.lattices[item.key].mark(self.theme, *masks, hovered, active)

    def _hovered(self, shape: tuple[int, ...]) -> int | None:
        """Control point under the mouse; None if the net has lost it in the meantime."""
        point = self.state.hovered
        if point is None or len(point) != len(shape):
            return None
        there = all(k < count for k, count in zip(point, shape, strict=True))
        return int(np.ravel_multi_index(point, shape)) if there else None

    # ---- places -----------------------------------------------------------------------------

    def _place(self) -> None:
        """Write all positions; between drags, so it may take as long as there are points."""
        origin, model = self.viewport.origin, self.document.model
        for body in model.bodies:
            points = self.document.points(body.key)
            before = self.state.shown.before
            self.bodies[body.key].place(self.bodies[body.key].rest if before else points, origin)
            self.bodies[body.key].mark_inside(self._inside(body.key, points))
        for item in model.lattices:
            lattice = item.rest if self.state.shown.before else item.current
            self.lattices[item.key].place(lattice.control_points, origin)
            self._mark(item)
        if self.state.preview is not None:
            self.lattices[PREVIEW].place(self.state.preview.control_points, origin)
        self._frame()
        self._show()

    def _inside(self, key: str, points: Array) -> NDArray[np.bool_] | None:
        if self.state.preview is not None:
            return inside_box(self.state.preview, points)
        return self.document.inside(key) if self.state.shown.inside else None

    def bounds(self) -> Array:
        """(2, 3) box of everything there is."""
        model = self.document.model
        clouds = [body.mesh.bounds for body in model.bodies]
        clouds += [item.current.control_points.reshape(-1, 3) for item in model.lattices]
        if self.state.preview is not None:
            clouds.append(self.state.preview.control_points.reshape(-1, 3))
        if not clouds:
            return np.array([[-1.0] * 3, [1.0] * 3])
        points = np.concatenate(clouds)
        return np.array([points.min(axis=0), points.max(axis=0)])

    def shape_bounds(self) -> Array:
        """(2, 3) box of the shapes that the user came for, without the far field, and the nets."""
        found = interesting(self.document)
        clouds = [] if found is None else [found]
        if self.state.shown.net:
            nets = [item.current for item in self.document.model.lattices if item.visible]
            clouds += [net.control_points.reshape(-1, 3) for net in nets]
        if not clouds:
            return self.bounds()
        points = np.concatenate(clouds)
        return np.array([points.min(axis=0), points.max(axis=0)])

    def go_home(self) -> None:
        """Look as at the beginning: from the side and distance of the first picture."""
        self.viewport.view = replace(self.viewport.view, parallel=False)
        self._first_look()
        self._place()

    def _frame(self) -> None:
        self.viewport.set_scene(self.bounds())

    def _first_look(self) -> None:
        """Choose origin, side and distance when something appears in an empty scene."""
        bounds, viewport = self.bounds(), self.viewport
        viewport.origin = bounds.mean(axis=0)
        bodies = self.document.model.bodies
        flat = bool(bodies) and all(is_plane(body.mesh) for body in bodies)
        side = AXIS_VIEWS["corner"]
        if flat:
            right, up = plane_axes(bodies[0].mesh)
            side = tuple(np.cross(right, up)), tuple(up)
        view = looking(*side, viewport.view)
        parallel = flat or (view.parallel and not view.flat)
        view = replace(view, distance=1.0, parallel=parallel, flat=flat)
        viewport.set_scene(bounds)
        viewport.view = view
        found = interesting(self.document)
        viewport.fit(bounds if found is None else found)
