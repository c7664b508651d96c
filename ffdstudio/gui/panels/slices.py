"""Section curves of the bodies at a plane: before and now, live, with what they measure.

A worker cuts; the panel asks for the next cut when the last one has arrived, so that a drag
costs the window only the drawing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QSlider, QVBoxLayout, QWidget

from ffdstudio.aliases import Array, Indices
from ffdstudio.gui.first_view import interesting
from ffdstudio.gui.panels.fields import NumberEdit, note
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.plots import make_plot, paint_plot, put_key
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.project.interaction.occlusion import drawn_triangles
from ffdstudio.project.view.slices import Measures, measured, section_of

STEPS, FRAME_MS = 400, 33
Part = tuple[Array, Array, Indices]  # points at rest and now, triangles


class SlicesPanel(QWidget):
    """One plane across x, y or z through all visible bodies with faces."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._busy = self._stale = False
        self.cut: tuple[Array, Array] | None = None
        self.measures: tuple[Measures | None, Measures | None] = (None, None)
        self.axis, self.place = QComboBox(), QSlider(Qt.Orientation.Horizontal)
        self.axis.addItems([f"across {letter}" for letter in "XYZ"])
        self.axis.setCurrentIndex(1)
        self.axis.setAccessibleName("Axis of the section curves")
        self.place.setRange(0, STEPS)
        self.place.setValue(STEPS // 2)
        self.place.setAccessibleName("Slider for the place of the section curves")
        self.number = NumberEdit("Place of the section curves", "Coordinate of the plane")
        self.number.setFixedWidth(80)
        self.text = note()
        self.plot = make_plot("Section curves", "", "")
        self.plot.setAspectLocked(True)
        self._before = self.plot.plot(connect="pairs")
        self._now = self.plot.plot(connect="pairs")
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(FRAME_MS)
        self._timer.timeout.connect(self._ask)
        self._lay_out()
        self.axis.activated.connect(self._on_axis)
        self.place.valueChanged.connect(self._on_slide)
        self.number.entered.connect(self.ask)
        document = studio.document
        self._listening = Listening(
            (document.moving, self.ask),
            (document.moved, self.ask),
            (document.structure_changed, self._on_structure),
        )
        self._on_structure()

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        for widget in (self.axis, self.place, self.number):
            row.addWidget(widget)
        row.addWidget(self.text, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(row)
        layout.addWidget(self.plot, 1)

    def close_panel(self) -> None:
        """Stop listening."""
        self._timer.stop()
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        import pyqtgraph as pg

        paint_plot(self.plot, theme)
        muted, strong = theme["muted"], theme["highlight"]
        self._before.setPen(pg.mkPen(muted, width=1.5, style=Qt.PenStyle.DashLine))
        self._now.setPen(pg.mkPen(strong, width=2))
        put_key(self.plot, ("┄", "before", muted), ("━", "now", strong))

    # ---- the plane --------------------------------------------------------------------------

    def _on_structure(self) -> None:
        low, high = self._ends()
        if self.number.value is None or not low <= self.number.value <= high:
            self._on_axis()
        self.ask()

    def _on_axis(self) -> None:
        self._on_slide(self.place.value())

    def _on_slide(self, step: int) -> None:
        low, high = self._ends()
        self.number.put(low + (high - low) * step / STEPS)
        self.ask()

    def _ends(self) -> tuple[float, float]:
        box, axis = interesting(self._studio.document), self.axis.currentIndex()
        return (0.0, 0.0) if box is None else (float(box[0, axis]), float(box[1, axis]))

    # ---- cutting ----------------------------------------------------------------------------

    def ask(self, _value: object = None) -> None:
        """Cut anew, soon."""
        if not self._timer.isActive():
            self._timer.start()

    def _ask(self) -> None:
        if self._busy or not self.isVisible() or self.number.value is None:
            self._stale = True
            return
        document, axis = self._studio.document, self.axis.currentIndex()
        document.refresh()
        parts: list[Part] = []
        for body in document.model.bodies:
            if body.visible and not is_plane(body.mesh):
                surface = document.surface(body.key)
                rest, now = body.mesh.points[surface.nodes], document.points(body.key)
                parts.append((rest, now.copy(), drawn_triangles(surface, body)))
        normal = np.eye(3)[axis]
        origin = self.number.value * normal
        self._busy, self._stale = True, False
        work = lambda _: _cuts(parts, origin, normal)  # noqa: E731
        self._studio.jobs.start("Section curves", work, self._take, self._refuse)

    def _refuse(self, error: Exception) -> None:
        self._busy = False
        raise error

    def _take(self, found: tuple[Array, Array]) -> None:
        self._busy, self.cut = False, found
        axes = np.delete(np.eye(3), self.axis.currentIndex(), axis=0)
        for item, segments in zip((self._before, self._now), found, strict=True):
            flat = segments.reshape(-1, 3) @ axes.T
            item.setData(flat[:, 0], flat[:, 1])
        before, now = (measured(segments, axes) for segments in found)
        self.measures = before, now
        self.text.setText(told(before, now))
        self.text.show()
        if self._stale:
            self.ask()

    def showEvent(self, event: Any) -> None:
        super().showEvent(event)
        self.ask()


def _cuts(parts: list[Part], origin: Array, normal: Array) -> tuple[Array, Array]:
    none = np.zeros((0, 2, 3))
    before = [section_of(rest, triangles, origin, normal) for rest, _, triangles in parts]
    now = [section_of(points, triangles, origin, normal) for _, points, triangles in parts]
    return np.concatenate([none, *before]), np.concatenate([none, *now])


def told(before: Measures | None, now: Measures | None) -> str:
    """What a section measures, before and now, in a line."""
    if before is None or now is None:
        return "The plane cuts no body here."
    pairs = (("chord", "chord"), ("thickness", "thickness"), ("camber", "camber"))
    parts = [f"{n} {getattr(before, k):.4g} → {getattr(now, k):.4g}" for n, k in pairs]
    parts.append(f"twist {now.angle - before.angle + 0.0:.3g}°")
    return "   ".join(parts)
