"""One see-through ghost of all bodies as they were.

Its pixels are a pattern instead of being translucent (`shaders.SCREEN_DOOR`), so that bodies
that share a surface do not add up to an opaque one; of plane meshes only outlines are drawn.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ffdstudio.aliases import Array
from ffdstudio.gui.actors.body import BodyActor
from ffdstudio.gui.actors.shaders import SCREEN_DOOR, extend
from ffdstudio.gui.actors.surface import SurfaceActor
from ffdstudio.gui.actors.vtk import cells
from ffdstudio.gui.theme import Theme


class Ghost:
    """Surfaces where the bodies were."""

    def __init__(self, renderer: Any) -> None:
        self._renderer = renderer
        self._parts: dict[BodyActor, SurfaceActor] = {}
        self._origin: Array | None = None

    def show(self, bodies: Iterable[BodyActor], theme: Theme, origin: Array) -> None:
        """Show the ghosts of these bodies and of no others."""
        wanted = list(bodies)
        shifted = self._origin is None or (self._origin != origin).any()
        self._origin = origin.copy()
        for body in [b for b in self._parts if b not in wanted]:
            self._parts.pop(body).close()
        for body in wanted:
            new = body not in self._parts
            part = self._parts[body] if not new else self._made(body)
            self._parts[body] = part
            if new or shifted:  # once: it stays where it is during a drag
                part.place(body.rest, origin)
            part.colour(theme.rgb("ghost"), theme.rgb("ghost"), False)
            part.lines.GetProperty().SetOpacity(0.9)

    def _made(self, body: BodyActor) -> SurfaceActor:
        surface = body.surface
        part = SurfaceActor(self._renderer, len(surface.nodes), surface.shading)
        polygons, lines = body.cells_of_walls()
        part.set_cells(cells([]) if body.flat else polygons, lines)
        extend(part.faces, SCREEN_DOOR)
        return part

    def clip(self, body: BodyActor, plane: Any) -> None:
        """Hide what lies in front of a plane, of the ghost of one body."""
        if body in self._parts:
            self._parts[body].clip(plane)

    @property
    def parts(self) -> list[SurfaceActor]:
        """Surfaces that are shown."""
        return list(self._parts.values())

    def close(self) -> None:
        """Leave the renderer."""
        for part in self._parts.values():
            part.close()
        self._parts.clear()
