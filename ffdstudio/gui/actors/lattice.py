"""A control net on the screen: one cloud of points as spheres and one set of lines.

One widget a control point would take minutes for a thousand of them; this takes two draw
calls, and a drag writes into one shared array.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.gui.actors.vtk import Points, actor, cells, colour_points, poly, show_colours
from ffdstudio.gui.theme import Theme

POINT, HALO = 11.0, 21.0  # pixels


def net_edges(shape: tuple[int, ...]) -> Indices:
    """(k, 2) flat numbers of neighbouring control points."""
    numbers = np.arange(np.prod(shape)).reshape(shape)
    pairs = []
    for axis in range(len(shape)):
        lines = np.moveaxis(numbers, axis, 0)
        pairs.append(np.stack([lines[:-1].ravel(), lines[1:].ravel()], axis=1))
    return np.concatenate(pairs)


def axis_lines(shape: tuple[int, ...]) -> list[Indices]:
    """Flat numbers along each axis, starting at control point (0, 0, 0)."""
    numbers = np.arange(np.prod(shape)).reshape(shape)
    return [
        np.moveaxis(numbers, axis, 0).reshape(count, -1)[:, 0] for axis, count in enumerate(shape)
    ]


class LatticeActor:
    """Points, net, coloured axes and halos of weighted points of one lattice."""

    def __init__(self, renderer: Any, shape: tuple[int, ...], scale: float = 1.0) -> None:
        self._renderer = renderer
        self.shape = shape
        self.count = int(np.prod(shape))
        self.points = Points(self.count)
        verts = cells([np.arange(self.count)[:, None]])
        self._cloud = poly(self.points, verts=verts)
        self._halo = poly(self.points)
        self.cloud, self.halo = actor(self._cloud), actor(self._halo)
        self.net = actor(poly(self.points, lines=cells([net_edges(shape)])))
        self.axes = [
            actor(poly(self.points, lines=cells([line[None]]))) for line in axis_lines(shape)
        ]
        self._style(scale)
        for item in self.actors:
            renderer.AddActor(item)

    @property
    def actors(self) -> list[Any]:
        """Everything that was added to the renderer."""
        return [self.net, *self.axes, self.cloud, self.halo]

    def _style(self, scale: float) -> None:
        for item, size in ((self.cloud, POINT), (self.halo, HALO)):
            item.GetProperty().SetPointSize(size * scale)
            item.GetProperty().SetRenderPointsAsSpheres(True)
            item.GetProperty().SetAmbient(0.45)
            item.GetProperty().SetDiffuse(0.6)
        self.halo.GetProperty().SetOpacity(0.4)
        show_colours(self.cloud)
        for item in [self.net, *self.axes]:
            item.GetProperty().SetLighting(False)
        self.net.GetProperty().SetLineWidth(1.3 * scale)
        for item in self.axes:
            item.GetProperty().SetLineWidth(3.2 * scale)

    def place(self, control_points: Array, origin: Array) -> None:
        """Move to these control points, (..., 3) in world units."""
        self.points.write(control_points.reshape(-1, 3), origin)

    def mark(
        self,
        theme: Theme,
        selected: Mask,
        frozen: Mask,
        weighted: Mask,
        hovered: int | None = None,
        active: bool = True,
    ) -> None:
        """Colour the points by what they are; the later in this list wins."""
        names = ["point", "weighted", "frozen", "selected", "hovered"]
        kind = np.zeros(self.count, dtype=np.int64)
        for number, mask in enumerate((weighted, frozen, selected), start=1):
            kind[mask] = number
        if hovered is not None:
            kind[hovered] = 4
        table = np.array([np.round(np.array(theme.rgb(n)) * 255) for n in names], dtype=np.uint8)
        colour_points(self._cloud, table[kind])
        self._halo.SetVerts(cells([np.flatnonzero(weighted)[:, None]]))
        self._colour(theme, active)

    def _colour(self, theme: Theme, active: bool) -> None:
        self.halo.GetProperty().SetColor(*theme.rgb("weighted"))
        self.net.GetProperty().SetColor(*theme.rgb("net"))
        for item, name in zip(self.axes, "ijk", strict=False):
            item.GetProperty().SetColor(*theme.rgb(f"axis_{name}"))
        for item in (self.net, *self.axes, self.cloud):
            item.GetProperty().SetOpacity(1.0 if active else 0.35)

    def show(self, visible: bool) -> None:
        """Show or hide all of it."""
        for item in self.actors:
            item.SetVisibility(visible)

    def close(self) -> None:
        """Leave the renderer."""
        for item in self.actors:
            self._renderer.RemoveActor(item)
