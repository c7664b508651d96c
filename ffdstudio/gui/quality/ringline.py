"""The ring where smoothness ends, on the displayed surface, with the continuity it has."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.gui.actors.vtk import Points, actor, cells, poly
from ffdstudio.gui.overlay import Shape, Text
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.project.checks.freezing import continuity, is_box
from ffdstudio.project.view.rings import ring


class RingLine:
    """Lines where the active lattice, or the one being built, cuts the bodies."""

    def __init__(self, studio: Studio, scene: Scene) -> None:
        self._studio, self._scene = studio, scene
        self._actor: Any = None
        self._label: tuple[Array, str, str] | None = None
        document, state = studio.document, studio.state
        self._listening = Listening(
            (document.structure_changed, self.update),
            (document.moved, self._on_moved),
            (state.preview_changed, self.update),
            (state.shown_changed, self.update),
        )
        scene.viewport.painted.connect(self._write)

    def close(self) -> None:
        """Stop listening and leave the picture."""
        self._listening.stop()
        self._scene.viewport.painted.disconnect(self._write)
        self._clear()

    def _clear(self) -> None:
        if self._actor is not None:
            self._scene.viewport.renderer.RemoveActor(self._actor)
        self._actor, self._label = None, None

    @property
    def segments(self) -> Array:
        """(k, 2, 3) lines of the ring."""
        lattice, layers = self._subject()
        if lattice is None or not is_box(lattice):
            return np.zeros((0, 2, 3))
        document, found = self._studio.document, [np.zeros((0, 2, 3))]
        for body in document.model.bodies:
            if body.visible:
                surface = document.surface(body.key)
                rest = body.mesh.points[surface.nodes]
                # with frozen layers the faces of the lattice stay where they are
                now = rest if layers else document.points(body.key)
                found.append(ring(lattice, surface, rest, now))
        return np.concatenate(found)

    def _subject(self) -> tuple[Lattice | None, int]:
        """Lattice whose ring is shown, and its frozen layers."""
        state, item = self._studio.state, self._studio.document.model.active_lattice
        if state.preview is not None:
            return state.preview, state.preview_frozen
        if item is None or not item.visible or not state.shown.net:
            return None, 0
        return item.rest, item.frozen

    def _on_moved(self) -> None:
        if self._actor is None or not self._subject()[1]:  # where layers are frozen, it stays
            self.update()

    def update(self) -> None:
        """Cut anew."""
        self._clear()
        segments, layers = self.segments, self._subject()[1]
        if not len(segments):
            return
        colour = "frozen" if layers else "warning"
        points = Points(2 * len(segments))
        points.write(segments.reshape(-1, 3), self._scene.viewport.origin)
        lines = cells([np.arange(2 * len(segments)).reshape(-1, 2)])
        self._actor = actor(poly(points, lines=lines))
        look = self._actor.GetProperty()
        look.SetColor(*self._studio.theme.rgb(colour))
        look.SetLineWidth(2.5)
        look.SetLighting(False)
        self._scene.viewport.renderer.AddActor(self._actor)
        self._label = segments.reshape(-1, 3), continuity(layers), colour
        self._scene.viewport.update()

    def _write(self) -> None:
        self._scene.viewport.overlay.put("ring", self._shapes())

    def _shapes(self) -> Iterator[Shape]:
        """Name of the continuity, at the upper end of the ring in the picture."""
        if self._label is None or self._studio.document.editing is not None:
            return
        points, text, colour = self._label
        pixels = self._scene.viewport.camera_now().project(points)
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        if len(pixels):
            x, y = pixels[np.argmin(pixels[:, 1] + 1e-3 * pixels[:, 0])]
            yield Text((x + 6, y - 22), (text,), colour, bold=True)
