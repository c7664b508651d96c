"""What is drawn over the picture with QPainter: labels, read-outs, rubber band, guide lines.

It lies on top of the viewport as a child that lets the mouse through. Repainting it asks
nothing of VTK: Qt lays the finished picture of the viewport below it again.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QLinearGradient, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from ffdstudio.gui.theme import Theme

Pixel = tuple[float, float]


@dataclass(frozen=True)
class Line:
    """Straight line; `colour` is a name of the theme."""

    start: Pixel
    end: Pixel
    colour: str
    width: float = 1.5
    dashed: bool = False


@dataclass(frozen=True)
class Ring:
    """Circle around a pixel."""

    centre: Pixel
    radius: float
    colour: str
    width: float = 1.5
    filled: bool = False


@dataclass(frozen=True)
class Text:
    """Lines of text beside a pixel; `plate` puts a background behind them."""

    at: Pixel
    lines: tuple[str, ...]
    colour: str = "view_text"
    plate: bool = False
    bold: bool = False


@dataclass(frozen=True)
class Band:
    """Rubber band."""

    start: Pixel
    end: Pixel


@dataclass(frozen=True)
class Bar:
    """Scale of colours in the lower right corner: title, texts along it, colours (r, g, b)."""

    title: str
    texts: tuple[str, ...]
    colours: tuple[tuple[int, ...], ...]


Shape = Line | Ring | Text | Band | Bar
BAR_WIDTH, BAR_HEIGHT, CORNER = 270, 58, 12


class Overlay(QWidget):
    """Layers of shapes by name; a layer is replaced as a whole."""

    def __init__(self, parent: QWidget, theme: Theme) -> None:
        super().__init__(parent)
        self.theme = theme
        self.layers: dict[str, tuple[Shape, ...]] = {}
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def put(self, layer: str, shapes: Iterable[Shape] = ()) -> None:
        """Show these shapes in a layer, instead of what it had."""
        new = tuple(shapes)
        if self.layers.get(layer, ()) != new:
            self.layers[layer] = new
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for shapes in self.layers.values():
            for shape in shapes:
                self._draw(painter, shape)
        painter.end()

    def _draw(self, painter: QPainter, shape: Shape) -> None:
        match shape:
            case Line():
                painter.setPen(self._pen(shape.colour, shape.width, shape.dashed))
                painter.drawLine(QPointF(*shape.start), QPointF(*shape.end))
            case Ring():
                painter.setPen(self._pen(shape.colour, shape.width))
                painter.setBrush(
                    QColor(self.theme[shape.colour]) if shape.filled else QColor(0, 0, 0, 0)
                )
                painter.drawEllipse(QPointF(*shape.centre), shape.radius, shape.radius)
            case Band():
                self._draw_band(painter, shape)
            case Text():
                self._draw_text(painter, shape)
            case Bar():
                self._draw_bar(painter, shape)

    def _pen(self, colour: str, width: float, dashed: bool = False) -> QPen:
        style = Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine
        return QPen(QColor(self.theme[colour]), width, style)

    def _draw_band(self, painter: QPainter, band: Band) -> None:
        fill = QColor(self.theme["highlight"])
        fill.setAlpha(40)
        painter.setPen(self._pen("highlight", 1.0))
        painter.setBrush(fill)
        painter.drawRect(QRectF(QPointF(*band.start), QPointF(*band.end)).normalized())

    def _draw_bar(self, painter: QPainter, bar: Bar) -> None:
        x = max(float(CORNER), self.width() - BAR_WIDTH - CORNER)
        y = self.height() - BAR_HEIGHT - CORNER
        painter.setFont(self.font())
        self._draw_plate(painter, QRectF(x, y, BAR_WIDTH, BAR_HEIGHT))
        painter.setPen(QColor(self.theme["view_text"]))
        inner = QRectF(x + 10, y + 4, BAR_WIDTH - 20, 17)
        painter.drawText(inner, Qt.AlignmentFlag.AlignLeft, bar.title)
        strip = QRectF(x + 10, y + 23, BAR_WIDTH - 20, 10)
        gradient = QLinearGradient(QPointF(strip.left(), 0), QPointF(strip.right(), 0))
        for number, colour in enumerate(bar.colours):
            gradient.setColorAt(number / (len(bar.colours) - 1), QColor(*colour))
        painter.fillRect(strip, gradient)
        sides = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter)
        for text, side in zip(bar.texts, (*sides, Qt.AlignmentFlag.AlignRight), strict=True):
            painter.drawText(QRectF(x + 10, y + 36, BAR_WIDTH - 20, 18), side, text)

    def _draw_plate(self, painter: QPainter, rect: QRectF) -> None:
        plate = QColor(self.theme["plate"])
        plate.setAlpha(225)
        painter.setPen(self._pen("border", 1.0))
        painter.setBrush(plate)
        painter.drawRoundedRect(rect, 4, 4)

    def _draw_text(self, painter: QPainter, text: Text) -> None:
        font = QFont(self.font())
        font.setBold(text.bold)
        painter.setFont(font)
        metrics = painter.fontMetrics()
        width = max(metrics.horizontalAdvance(line) for line in text.lines)
        rect = QRectF(text.at[0], text.at[1], width, metrics.height() * len(text.lines))
        if text.plate:
            rect = self._inside(rect.adjusted(0, 0, 14, 8))
            self._draw_plate(painter, rect)
            rect = rect.adjusted(7, 4, -7, -4)
        painter.setPen(QColor(self.theme[text.colour]))
        painter.drawText(rect, Qt.AlignmentFlag.AlignLeft, "\n".join(text.lines))

    def _inside(self, rect: QRectF) -> QRectF:
        """Shift a plate so that it stays in the picture."""
        x = min(rect.x(), self.width() - rect.width() - 4)
        y = min(rect.y(), self.height() - rect.height() - 4)
        return QRectF(max(4.0, x), max(4.0, y), rect.width(), rect.height())
