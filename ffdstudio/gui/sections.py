"""Keeps the section through volume meshes in step: cut by workers, after each edit anew."""

from __future__ import annotations

from functools import partial

import numpy as np
from psygnal import Signal
from vtkmodules.vtkCommonDataModel import vtkPlane

from ffdstudio.aliases import Array
from ffdstudio.gui.actors.section import Cut, cut, show
from ffdstudio.gui.actors.surface import SurfaceActor
from ffdstudio.gui.first_view import interesting
from ffdstudio.gui.jobs import Progress
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.state import SectionPlane
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.document import Document
from ffdstudio.project.model import Body
from ffdstudio.project.view.volume import countable


class SectionPlanes:
    """One cut a body; what lies between the plane and the viewer is hidden.

    `shown(key)` is emitted when the cut of a body is in the picture.
    """

    shown = Signal(str)

    def __init__(self, studio: Studio, scene: Scene) -> None:
        self._studio, self._scene = studio, scene
        self.actors: dict[str, SurfaceActor] = {}
        self.cuts: dict[str, Cut] = {}
        document = studio.document
        self._listening = Listening(
            (studio.state.shown_changed, self.update),
            (document.volume_changed, self._on_volume),
            (document.structure_changed, self.update),
        )

    def close(self) -> None:
        """Stop listening and leave the picture."""
        self._listening.stop()
        self._clear()

    def paint_with(self, _theme: Theme) -> None:
        """Take the colours of a theme."""
        self.update()

    def _on_volume(self, key: str) -> None:
        if self._studio.document.volume(key) is not None:
            self.update()

    def update(self) -> None:
        """Cut anew, or show all."""
        section, document = self._studio.state.shown.section, self._studio.document
        bodies = {body.key: body for body in document.model.bodies}
        if section is None:
            self._clear()
        for key, actor in self._scene.bodies.items():
            if section is None or key not in bodies or not _solid(bodies[key]):
                actor.clip(None)
                self._scene.ghost.clip(actor, None)
                continue
            origin, normal = self._plane(bodies[key], section)
            for part in (actor.clip, partial(self._scene.ghost.clip, actor)):
                part(self._clipping(origin, normal))
            self._start(bodies[key], origin, normal)
        self._scene.viewport.update()

    def _clear(self) -> None:
        for actor in self.actors.values():
            actor.close()
        self.actors.clear()

    def _plane(self, body: Body, section: SectionPlane) -> tuple[Array, Array]:
        normal = np.eye(3)[section.axis]
        return body.mesh.bounds.mean(axis=0) * (1 - normal) + section.at * normal, normal

    def _clipping(self, origin: Array, normal: Array) -> vtkPlane:
        """Plane that keeps what lies behind it, seen from where the viewer is."""
        viewport = self._scene.viewport
        towards = 1.0 if normal @ viewport.view.back >= 0 else -1.0
        plane = vtkPlane()
        plane.SetOrigin(*(origin - viewport.origin))
        plane.SetNormal(*(-towards * normal))
        return plane

    def _start(self, body: Body, origin: Array, normal: Array) -> None:
        volume = self._studio.document.volume(body.key)
        if volume is None:  # comes again when it is known
            return
        mesh, points = body.mesh, volume.points

        def work(progress: Progress) -> Cut:
            progress(0.0, "cutting")
            return cut(mesh, points, origin, normal)

        def done(found: Cut) -> None:
            self._show(body.key, found)

        self._studio.jobs.start(f"Cutting {body.name}", work, done, key=f"section {body.key}")

    def _show(self, key: str, found: Cut) -> None:
        old = self.actors.pop(key, None)
        if old is not None:
            old.close()
        if self._studio.state.shown.section is None or key not in self._scene.bodies:
            return
        viewport, theme = self._scene.viewport, self._studio.theme
        colours = theme.rgb("section"), theme.rgb("edge")
        self.cuts[key] = found
        self.actors[key] = show(viewport.renderer, found, viewport.origin, *colours)
        self.actors[key].show(self._studio.document.model.body(key).visible)
        viewport.update()
        self.shown.emit(key)


def _solid(body: Body) -> bool:
    return body.mesh.dimension == 3 and countable(body.mesh)


def reach(document: Document, axis: int) -> tuple[float, float]:
    """Lowest and highest place on an axis where there is something to cut."""
    ends = [body.mesh.bounds[:, axis] for body in document.model.bodies if _solid(body)]
    if not ends:
        return 0.0, 0.0
    low, high = float(np.min(ends)), float(np.max(ends))
    inset = 0.002 * (high - low)  # at the very ends a cut falls between the cells
    return low + inset, high - inset


def middle(document: Document, axis: int = 1) -> SectionPlane:
    """Section through the middle of what is of interest, as against the far field."""
    low, high = reach(document, axis)
    box = interesting(document)
    at = (low + high) / 2 if box is None else float(box[:, axis].mean())
    return SectionPlane(axis, min(max(at, low), high))
