"""The timeline: one slider through the iterates of a run, with its refinements marked."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPolygonF
from PySide6.QtWidgets import (
    QHBoxLayout,
    QPushButton,
    QSlider,
    QStyle,
    QStyleOptionSlider,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.resources import icon
from ffdstudio.gui.start import Elided
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme

EMPTY = "No iterates yet. Start a study; its iterates can be looked at here, while it runs too."


class MarkedSlider(QSlider):
    """Slider with small triangles above some of its places."""

    scrubbed = Signal(int)

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.marks: list[int] = []
        self.colour = QColor("black")
        self.setAccessibleName("Timeline")
        self.setToolTip("Iterate that is shown; triangles: refinements. Arrow keys step")
        self.setMinimumHeight(30)
        self.setPageStep(1)
        self.valueChanged.connect(self.scrubbed)

    def put(self, last: int, place: int, marks: list[int]) -> None:
        """Show a range, a place and marks, without telling of it."""
        self.blockSignals(True)
        self.setRange(0, max(0, last))
        self.setValue(place)
        self.blockSignals(False)
        if marks != self.marks:
            self.marks = marks
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.colour)
        for place in self.marks:
            x = self._x_of(place)
            corners = (QPointF(x - 3.5, 1), QPointF(x + 3.5, 1), QPointF(x, 7))
            painter.drawPolygon(QPolygonF(list(corners)))
        painter.end()

    def _x_of(self, place: int) -> float:
        """Where the middle of the handle is at a place."""
        option = QStyleOptionSlider()
        self.initStyleOption(option)
        style, control = self.style(), QStyle.ComplexControl.CC_Slider
        groove = QRectF(
            style.subControlRect(control, option, QStyle.SubControl.SC_SliderGroove, self)
        )
        handle = style.subControlRect(control, option, QStyle.SubControl.SC_SliderHandle, self)
        room = groove.width() - handle.width()
        part = place / self.maximum() if self.maximum() else 0.0
        return groove.left() + 0.5 * handle.width() + part * room


class Timeline(QWidget):
    """Slider, steps to and fro, and what to do with the iterate that is shown."""

    def __init__(self, runner: StudyRunner) -> None:
        super().__init__()
        self._runner = runner
        self.slider = MarkedSlider()
        self.text = Elided("", "muted", Qt.TextElideMode.ElideRight)
        self.first = self._tool("skip-backward", "First iterate", lambda: self._to(0))
        self.back = self._tool("step-backward", "One iterate back", lambda: self._by(-1))
        self.ahead = self._tool("step-forward", "One iterate on", lambda: self._by(1))
        self.last = self._tool("skip-forward", "Last iterate", lambda: self._to(10**9))
        self.follow = self._tool("fast-forward", "Show each new iterate as it comes", None)
        self.follow.setCheckable(True)
        self.use = QPushButton("Use this &iterate")
        self.use.setToolTip("Make the lattice what is shown, as an edit that can be undone")
        self.release = QPushButton("Put &back")
        self.release.setToolTip("Show the lattice as it is in the document again")
        self._lay_out()
        self.slider.scrubbed.connect(self._to)
        self.follow.clicked.connect(self._runner.follow)
        self.use.clicked.connect(self._runner.use)
        self.release.clicked.connect(self._runner.release)
        self._listening = Listening(
            (runner.grown, self.fill),
            (runner.changed, self.fill),
            (runner.shown_changed, self.fill),
        )
        self.fill()

    def _tool(self, name: str, tip: str, action: object) -> QToolButton:
        button = QToolButton()
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        button.setAutoRaise(True)
        button.setProperty("icon_name", name)
        if callable(action):
            button.clicked.connect(lambda: action())
        return button

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.setSpacing(2)
        for button in (self.first, self.back):
            row.addWidget(button)
        row.addWidget(self.slider, 1)
        for button in (self.ahead, self.last, self.follow):
            row.addWidget(button)
        below = QHBoxLayout()
        below.addWidget(self.text, 1)
        below.addWidget(self.release)
        below.addWidget(self.use)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 0, 6, 6)
        layout.setSpacing(2)
        layout.addLayout(row)
        layout.addLayout(below)

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self.slider.colour = QColor(theme["hovered"])
        for button in (self.first, self.back, self.ahead, self.last, self.follow):
            button.setIcon(icon(button.property("icon_name"), theme["text"]))
        self.slider.update()

    def fill(self) -> None:
        """Show the run and the place that are shown."""
        runner, run = self._runner, self._runner.run
        count = 0 if run is None else len(run.iterates)
        place = min(max(runner.place, 0), max(0, count - 1))
        marks = [] if run is None else [k + 1 for k in run.refined_at]
        self.slider.put(count - 1, place, marks)
        for widget in (self.slider, self.first, self.back, self.ahead, self.last):
            widget.setEnabled(count > 0)
        self.follow.setEnabled(runner.alive)
        self.follow.setChecked(runner.following and runner.alive)
        self.use.setEnabled(runner.showing)
        self.release.setEnabled(runner.showing)
        if run is None or not count:
            text = EMPTY
        else:
            text = f"{run.name}: {place + 1} of {count} · {run.sentence(place)}"
        self.text.put(text)
        self.text.setToolTip(text)

    def _by(self, step: int) -> None:
        self._to(self.slider.value() + step)

    def _to(self, place: int) -> None:
        run = self._runner.run
        if run is not None and run.iterates:
            self._runner.show(run, min(max(place, 0), len(run.iterates) - 1))
