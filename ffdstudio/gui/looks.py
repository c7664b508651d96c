"""Colours the bodies by what their shape has become, live, and shows the scale.

The values are made just before a picture is painted, and only when points have moved since: a
drag pays for them once a frame, and nothing else pays at all.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkLookupTable

from ffdstudio.gui.actors.body import BodyActor
from ffdstudio.gui.actors.shaders import REFLECTION, SOFT, extend
from ffdstudio.gui.overlay import Bar
from ffdstudio.gui.quality.colours import Colours, table
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.view.looks import LOOKS, Look

SIGNED = "CET-D1"  # blue for hollows, red for bumps
HEAT = ((1.0, 0.76, 0.2), (0.93, 0.33, 0.12), (0.6, 0.04, 0.24))  # from the colour of the body on
SHADERS = {"shaded": SOFT, "reflection": REFLECTION}


class Looks:
    """Keeps the colours of all bodies in step with the look that is chosen.

    Attributes
    ----------
    limit : float
        End of the scale; 0 where nothing is coloured, or all values are 0.
    """

    def __init__(self, studio: Studio, scene: Scene) -> None:
        self._studio, self._scene = studio, scene
        self.limit = 0.0
        self._stale, self._shown = True, ""
        document = studio.document
        self._listening = Listening(
            (document.moving, self._on_moved),
            (document.moved, self._on_moved),
            (document.structure_changed, self._on_moved),
            (studio.state.shown_changed, self._on_moved),
        )
        scene.viewport.about_to_paint.connect(self._follow)

    def close(self) -> None:
        """Stop listening."""
        self._listening.stop()
        self._scene.viewport.about_to_paint.disconnect(self._follow)

    def paint_with(self, _theme: Theme) -> None:
        """Take the colours of a theme."""
        self._on_moved()

    def _on_moved(self) -> None:
        self._stale = True
        self._scene.viewport.update()

    def _follow(self) -> None:
        if not self._stale:
            return
        self._stale = False
        name = self._studio.state.shown.look
        self._shown = name
        self._paint(LOOKS[name])

    def _paint(self, look: Look) -> None:
        found = {body.key: self._values(body.key, look) for body in self._bodies}
        known = [values for values in found.values() if values is not None]
        self.limit = look.limit(np.concatenate(known)) if known else 0.0
        lookup = _lookup(self._colours(look), self.limit, look.signed) if known else None
        for body in self._bodies:
            actor, values = self._scene.bodies[body.key], found[body.key]
            part = self._part(actor)
            part.paint(values, lookup)
            for each in (actor.full, actor.proxy):
                if each is not None:
                    code = SHADERS.get(self._shown, "")
                    extend(each.faces, code if each.shading is not None else "")
                    if each is not part:
                        each.paint(None)
        self._scene.viewport.overlay.put("look", self._legend(look, bool(known)))

    @property
    def _bodies(self) -> Any:
        return [b for b in self._studio.document.model.bodies if b.key in self._scene.bodies]

    def _part(self, actor: BodyActor) -> Any:
        """The surface that is drawn now: the proxy during a drag."""
        coarse = self._studio.document.editing is not None and actor.proxy is not None
        return actor.proxy if coarse else actor.full

    def _values(self, key: str, look: Look) -> Any:
        if look.values is None:
            return None
        document, actor = self._studio.document, self._scene.bodies[key]
        part = self._part(actor)
        if part is actor.full:
            return look.values(actor.rest, document.points(key), part.shading)
        rest = actor.rest[actor.surface.proxy.rows]  # type: ignore[union-attr]
        return look.values(rest, document.proxy_points(key), part.shading)

    def _colours(self, look: Look) -> Colours:
        if look.signed:
            return table(SIGNED, False)
        flat = all(self._scene.bodies[body.key].flat for body in self._bodies)
        stops = np.array([self._studio.theme.rgb("mesh" if flat else "body"), *HEAT])
        at = np.linspace(0, len(stops) - 1, 256)
        channels = [np.interp(at, range(len(stops)), channel) for channel in stops.T]
        return np.round(255 * np.column_stack(channels)).astype(np.uint8)

    def _legend(self, look: Look, coloured: bool) -> list[Bar]:
        if not coloured:
            return []
        low = -self.limit if look.signed else 0.0
        ends = tuple(f"{value + 0.0:.4g}" for value in (low, (low + self.limit) / 2, self.limit))
        colours = tuple(tuple(map(int, row)) for row in self._colours(look)[::15])
        return [Bar(look.title, ends, colours)]


def _lookup(colours: Colours, limit: float, signed: bool) -> Any:
    found = vtkLookupTable()
    rgba = np.column_stack([colours, np.full(len(colours), 255, np.uint8)])
    found.SetNumberOfTableValues(len(colours))
    found.SetTable(numpy_to_vtk(np.ascontiguousarray(rgba), deep=True))
    end = limit if limit > 0 else 1.0
    found.SetTableRange(-end if signed else 0.0, end)
    return found
