"""What is written over the picture: hover read-out, tool feedback, weight handle, axis labels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.gui.navigation import CORNER, triad_ends
from ffdstudio.gui.overlay import Band, Line, Ring, Shape, Text
from ffdstudio.gui.state import WindowState
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.viewport import Viewport
from ffdstudio.project.interaction.feedback import weight_handle
from ffdstudio.project.interaction.tools import Tools
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.plane_constraints import names_at, planes_in
from ffdstudio.project.view.camera import Camera

XYZ = ("axis_i", "axis_j", "axis_k")


class Readouts:
    """Fills the layers of the overlay; nothing here asks VTK for a picture."""

    def __init__(self, viewport: Viewport, tools: Tools, state: WindowState) -> None:
        self._viewport, self._tools, self._state = viewport, tools, state
        document = tools.document
        self._listening = Listening(
            (tools.changed, self._on_feedback),
            (state.hovered_changed, self._on_hover),
            (document.selection_changed, self._on_painted),
            (document.moved, self._on_moved),
            (document.structure_changed, self._on_moved),
            (state.preview_changed, self._on_painted),
        )
        viewport.painted.connect(self._on_painted)

    def close(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def _on_moved(self) -> None:
        """What was said of the point under the mouse may have become wrong."""
        self._state.hover(None)
        self._on_painted()

    @property
    def _item(self) -> LatticeItem | None:
        return self._tools.document.model.active_lattice

    # ---- what belongs to places in the scene: anew with every picture -----------------------

    def _on_painted(self) -> None:
        camera, overlay = self._viewport.camera_now(), self._viewport.overlay
        overlay.put("triad", self._triad(camera))
        item = self._item
        drawn = item is not None and item.visible and self._state.preview is None
        net = self._state.preview  # the one that is being built, else the one that is edited
        if net is None and item is not None and drawn and self._state.shown.net:
            net = item.current
        overlay.put("labels", self._labels(camera, net) if net is not None else ())
        overlay.put("handle", self._handle(camera, item) if drawn and item else ())
        overlay.put("soft", self._reach(camera) if drawn and item else ())
        if self._tools.busy:
            self._on_feedback()

    def _labels(self, camera: Camera, lattice: Lattice) -> Iterator[Shape]:
        net = lattice.control_points
        for axis in range(lattice.dimension):
            line = np.moveaxis(net, axis, 0).reshape(net.shape[axis], -1, 3)[:, 0]
            pixels = camera.project(line[-2:])
            if not np.isfinite(pixels).all():
                continue
            way = pixels[1] - pixels[0]
            place = pixels[1] + 16 * way / max(float(np.linalg.norm(way)), 1e-6)
            name = "ijk"[axis]
            yield Text((place[0] - 4, place[1] - 9), (name,), f"axis_{name}", bold=True)

    def _handle(self, camera: Camera, item: LatticeItem) -> Iterator[Shape]:
        point = self._tools.handle_point()
        if point is None:
            return
        place, weight = item.current.control_points[point], float(item.current.weights[point])
        foot = camera.project(place)[0]
        x, y = weight_handle(camera, place, weight)
        if not np.isfinite([*foot, x, y]).all():
            return
        yield Line((foot[0], foot[1] - 7), (x, y + 5), "weighted", 1.5)
        yield Ring((x, y), 5.0, "weighted", filled=True)
        yield Text((x + 9, y - 9), (f"w {weight:.3g}",), "weighted", bold=True)

    def _reach(self, camera: Camera) -> Iterator[Shape]:
        """Circle of soft selection about the selected points."""
        soft = self._tools.options.soft
        if soft is None or not self._tools.document.selection or self._tools.busy:
            return
        centre = self._tools.pivot()
        x, y = camera.project(centre)[0]
        if np.isfinite([x, y]).all():
            yield Ring((x, y), soft.radius / camera.pixel_size(centre), "muted", 1.2)

    def _triad(self, camera: Camera) -> Iterator[Shape]:
        """Axes in the corner; a click on an end looks from there."""
        view, height = self._viewport.view, float(self._viewport.height())
        middle = (CORNER, height - CORNER)
        for name, end in reversed(triad_ends(view, height).items()):  # the nearest come last
            axis = "xyz".index(name[1])
            if np.hypot(end[0] - middle[0], end[1] - middle[1]) < 4:
                continue
            if name[0] == "-":
                yield Ring(end, 3.0, XYZ[axis], 1.2)
                continue
            yield Line(middle, end, XYZ[axis], 2.0)
            out = [1.3 * e - 0.3 * m for e, m in zip(end, middle, strict=True)]
            yield Text((out[0] - 4, out[1] - 9), (name[1].upper(),), XYZ[axis])

    # ---- what belongs to the cursor ---------------------------------------------------------

    def _on_feedback(self) -> None:
        self._viewport.overlay.put("tool", self._feedback())

    def _feedback(self) -> Iterator[Shape]:
        said, camera = self._tools.feedback, self._viewport.camera_now()
        if said.band is not None:
            yield Band(said.band[:2], said.band[2:])
        if said.anchor is not None and said.lock is not None and not said.lock.plane:
            yield from self._axis(camera, said.anchor, np.array(said.lock.direction))
        if said.anchor is not None and said.radius > 0:
            x, y = camera.project(said.anchor)[0]
            yield Ring((x, y), said.radius / camera.pixel_size(said.anchor), "muted")
        if said.text:
            yield Text((said.at[0] + 18, said.at[1] + 14), (said.text,), plate=True)

    def _axis(self, camera: Camera, anchor: np.ndarray, along: np.ndarray) -> Iterator[Shape]:
        """Line through the anchor, across the picture."""
        size = camera.pixel_size(anchor)
        ends = camera.project(np.array([anchor - 60 * size * along, anchor + 60 * size * along]))
        way = ends[1] - ends[0]
        length = float(np.linalg.norm(way))
        if np.isfinite(length) and length > 1e-3:
            far = 4000 * way / length
            colour = XYZ[int(np.argmax(np.abs(along)))]
            yield Line(tuple(ends[0] - far), tuple(ends[1] + far), colour, 1.0, True)

    def _on_hover(self) -> None:
        item, point = self._item, self._state.hovered
        if item is None or point is None:
            self._viewport.overlay.put("hover")
            return
        x, y = self._viewport.camera_now().project(item.current.control_points[point])[0]
        slides = names_at(item.rest, point, planes_in(self._tools.document.model))
        lines = hover_text(item, point, slides)
        self._viewport.overlay.put("hover", [Text((x + 16, y + 12), lines, plate=True)])


def hover_text(
    item: LatticeItem, point: tuple[int, ...], slides: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """Lines that tell all of a control point; `slides` are the planes it slides in."""
    place, rest = item.current.control_points[point], item.rest.control_points[point]
    lines = [
        f"({', '.join(map(str, point))})" + ("  frozen" if item.frozen_mask[point] else ""),
        "at  " + ", ".join(f"{v:.5g}" for v in place),
    ]
    if (place != rest).any():
        lines.append("Δ  " + ", ".join(f"{v:.4g}" for v in place - rest))
    lines.append(f"weight  {item.current.weights[point]:.4g}")
    if slides and not item.frozen_mask[point]:
        lines.append("slides in " + " and ".join(slides))
    return tuple(lines)
