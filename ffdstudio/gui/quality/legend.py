"""The scale of the colours, in a corner of the picture."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QLinearGradient, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from ffdstudio.gui.quality.choice import Choice
from ffdstudio.gui.quality.colours import map_of, scale_of
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.viewport import Viewport
from ffdstudio.meshes.measures import MEASURES
from ffdstudio.project.checks.checking import Checks, Digest

WIDTH, HEIGHT, MARGIN = 270, 58, 12


class Legend(QWidget):
    """Name of the measure, its colours, and the values at their ends and in the middle."""

    def __init__(self, studio: Studio, viewport: Viewport, checks: Checks, choice: Choice) -> None:
        super().__init__(viewport)
        self._studio, self._viewport = studio, viewport
        self._checks, self._choice = checks, choice
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.resize(WIDTH, HEIGHT)
        viewport.view_changed.connect(self._place)
        self._listening = Listening(
            (choice.changed, self.fill),
            (checks.changed, self._on_report),
            (checks.digested, self._on_report),
        )
        self.fill()

    def close_legend(self) -> None:
        """Stop listening."""
        self._listening.stop()
        self._viewport.view_changed.disconnect(self._place)

    @property
    def digest(self) -> Digest | None:
        """What the colours tell of the chosen body."""
        return self._checks.digest(self._choice.wanted.body, self._choice.wanted.measure)

    def _on_report(self, _key: str) -> None:
        self.fill()

    def fill(self) -> None:
        """Show the scale, if there are colours."""
        self.setVisible(self._choice.wanted.colour != "off" and self.digest is not None)
        self._place()
        self.update()

    def _place(self) -> None:
        x = self._viewport.width() - WIDTH - MARGIN
        self.move(max(MARGIN, x), self._viewport.height() - HEIGHT - MARGIN)

    @property
    def title(self) -> str:
        """What is coloured."""
        wanted, measure = self._choice.wanted, MEASURES[self._choice.wanted.measure]
        name = measure.title[:1].upper() + measure.title[1:]
        return f"Change of {measure.title}" if wanted.colour == "change" else name

    def paintEvent(self, _event: QPaintEvent) -> None:
        digest = self.digest
        if digest is None:
            return
        theme, change = self._studio.theme, self._choice.wanted.colour == "change"
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        plate = QColor(theme["plate"])
        plate.setAlpha(225)
        painter.setPen(QColor(theme["border"]))
        painter.setBrush(plate)
        painter.drawRoundedRect(QRectF(0.5, 0.5, WIDTH - 1, HEIGHT - 1), 4, 4)
        painter.setPen(QColor(theme["view_text"]))
        painter.drawText(QRectF(10, 4, WIDTH - 20, 17), Qt.AlignmentFlag.AlignLeft, self.title)
        bar = QRectF(10, 23, WIDTH - 20, 10)
        self._fill_bar(painter, bar, change)
        scale = scale_of(digest, change)
        for place, side in ((0.0, "Left"), (0.5, "HCenter"), (1.0, "Right")):
            where = getattr(Qt.AlignmentFlag, f"Align{side}")
            text = f"{scale.value(place) + 0.0:.3g}"
            painter.drawText(QRectF(10, 36, WIDTH - 20, 18), where, text)
        painter.end()

    def _fill_bar(self, painter: QPainter, bar: QRectF, change: bool) -> None:
        colours = map_of(self._choice.wanted.measure, change, self._studio.theme)
        gradient = QLinearGradient(QPointF(bar.left(), 0), QPointF(bar.right(), 0))
        for number in range(0, 256, 15):
            gradient.setColorAt(number / 255, QColor(*colours[number].tolist()))
        painter.fillRect(bar, gradient)
