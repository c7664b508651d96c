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

POINT, HALO, FIXED, XRAY = 12.0, 21.0, 5.5, 8.0  # pixels
FAINT, IN_FRONT = 0.22, -25_000.0  # opacity behind surfaces; offset that is always in front
DEEP = 0.55  # how much of its colour the farthest point loses


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
    """Points, net, coloured axes and halos of weighted points of one lattice.

    1. Frozen points are small: they are there to be known, not to be grabbed.
    2. What lies behind a surface is drawn once more, faintly and in front of everything: the
       offset of coincident topology moves it to the viewer's side of the depth buffer.
    3. Colours fade towards the ground with the distance from the viewer (`cue`).
    """

    def __init__(self, renderer: Any, shape: tuple[int, ...], scale: float = 1.0) -> None:
        self._renderer = renderer
        self.shape = shape
        self.count = int(np.prod(shape))
        self.points = Points(self.count)
        self._cloud, self._fixed = poly(self.points), poly(self.points)
        self._halo = poly(self.points)
        self._net = poly(self.points, lines=cells([net_edges(shape)]))
        self.cloud, self.fixed, self.halo = map(actor, (self._cloud, self._fixed, self._halo))
        self.net = actor(self._net)
        self.xray = [actor(self._cloud), actor(self._net)]
        self.axes = [
            actor(poly(self.points, lines=cells([line[None]]))) for line in axis_lines(shape)
        ]
        self._colours = np.zeros((self.count, 3))
        self._ground, self._line = np.zeros(3), np.zeros(3)
        self._nearness = np.ones(self.count)
        self._style(scale)
        for item in self.actors:
            renderer.AddActor(item)

    @property
    def actors(self) -> list[Any]:
        """Everything that was added to the renderer."""
        return [*self.xray, self.net, *self.axes, self.fixed, self.cloud, self.halo]

    def _style(self, scale: float) -> None:
        sizes = ((self.cloud, POINT), (self.halo, HALO), (self.fixed, FIXED), (self.xray[0], XRAY))
        for item, size in sizes:
            item.GetProperty().SetPointSize(size * scale)
            item.GetProperty().SetRenderPointsAsSpheres(True)
            item.GetProperty().SetAmbient(0.45)
            item.GetProperty().SetDiffuse(0.6)
        self.halo.GetProperty().SetOpacity(0.4)
        for item in (self.cloud, self.fixed, self.net, *self.xray):
            show_colours(item)
        for item in [self.net, self.xray[1], *self.axes]:
            item.GetProperty().SetLighting(False)
            item.GetMapper().SetRelativeCoincidentTopologyLineOffsetParameters(-1.0, -4.0)
        for item in (self.net, self.xray[1]):
            item.GetProperty().SetLineWidth(1.3 * scale)
        for item in self.axes:
            item.GetProperty().SetLineWidth(3.2 * scale)
        for item in self.xray:
            item.GetProperty().SetOpacity(FAINT)
            item.GetMapper().SetRelativeCoincidentTopologyLineOffsetParameters(-1.0, IN_FRONT)
            item.GetMapper().SetRelativeCoincidentTopologyPointOffsetParameter(IN_FRONT)

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
        self._colours = np.array([theme.rgb(n) for n in names])[kind]
        self._ground, self._line = np.array(theme.rgb("view_bottom")), np.array(theme.rgb("net"))
        small = kind == names.index("frozen")
        self._cloud.SetVerts(cells([np.flatnonzero(~small)[:, None]]))
        self._fixed.SetVerts(cells([np.flatnonzero(small)[:, None]]))
        self._halo.SetVerts(cells([np.flatnonzero(weighted)[:, None]]))
        self._recolour()
        self._colour(theme, active)

    def cue(self, towards: Array) -> None:
        """Take the direction to the viewer: what is far from him fades."""
        depths = -(self.points.array @ towards)
        span = float(np.ptp(depths)) or 1.0
        nearness = 1.0 - DEEP * (depths - depths.min()) / span
        if not np.allclose(nearness, self._nearness, atol=5e-3):
            self._nearness = nearness
            self._recolour()

    def _recolour(self) -> None:
        near = self._nearness[:, None]
        for data, colours in ((self._cloud, self._colours), (self._net, self._line)):
            mixed = near * colours + (1 - near) * self._ground
            colour_points(data, np.round(255 * mixed).astype(np.uint8))
        self._fixed.GetPointData().SetScalars(self._cloud.GetPointData().GetScalars())

    def _colour(self, theme: Theme, active: bool) -> None:
        self.halo.GetProperty().SetColor(*theme.rgb("weighted"))
        for item, name in zip(self.axes, "ijk", strict=False):
            item.GetProperty().SetColor(*theme.rgb(f"axis_{name}"))
        for item in (self.net, *self.axes, self.cloud):
            item.GetProperty().SetOpacity(1.0 if active else 0.35)
        self.fixed.GetProperty().SetOpacity(0.8 if active else 0.3)

    def show(self, visible: bool) -> None:
        """Show or hide all of it."""
        for item in self.actors:
            item.SetVisibility(visible)

    def close(self) -> None:
        """Leave the renderer."""
        for item in self.actors:
            self._renderer.RemoveActor(item)
