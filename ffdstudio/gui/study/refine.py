"""Refine here: the indicator of each knot interval as a bar; a click inserts the best knot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QStackedLayout,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import note, say
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.plots import choice, make_plot, paint_plot
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.consent import Consent
from ffdstudio.project import commands as c

if TYPE_CHECKING:
    from ffdstudio.project.studies.indicator import Bar

LETTERS = "ijk"
SETTLE_MS = 150
NO_LATTICE = "No lattice yet. Start a study, or build a lattice (Ctrl+L)."
NO_TARGET = "The bars need an objective: choose a shape and a target in the Study panel."
WAITING = "The bars come back when the study pauses or ends."


class RefinePanel(QWidget):
    """One plot a direction of the active lattice; its shape stays as it is."""

    def __init__(self, studio: Studio, runner: StudyRunner) -> None:
        super().__init__()
        self._studio, self._runner, self._theme = studio, runner, studio.theme
        self.bars: list[Bar] = []
        self.indicator = choice({one.name: one.title for one in INDICATORS}, 14)
        self.indicator.setAccessibleName("Indicator")
        self.best = QPushButton("Insert the &best")
        self.best.setToolTip("Insert the knot of the tallest bar; the shape stays")
        self.hint = note()
        self.hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.told = QLabel()
        self.told.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.plots = [self._plot(axis) for axis in range(3)]
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(SETTLE_MS)
        self._timer.timeout.connect(self._ask)
        self._lay_out()
        self.indicator.currentIndexChanged.connect(self.ask)
        self.best.clicked.connect(self.insert_best)
        document = studio.document
        self._listening = Listening(
            (document.moved, self.ask),
            (document.structure_changed, self.ask),
            (runner.draft_changed, self.ask),
            (runner.changed, self.ask),
            (runner.shown_changed, self.ask),
        )

    def _plot(self, axis: int) -> Any:
        plot = make_plot(f"Indicator along {LETTERS[axis]}", f"Knots along {LETTERS[axis]}", "")
        plot.setMouseEnabled(False, False)
        plot.hideButtons()
        plot.getPlotItem().getAxis("left").setStyle(showValues=False)
        plot.scene().sigMouseClicked.connect(lambda event: self._on_click(axis, event))
        plot.scene().sigMouseMoved.connect(lambda place: self._on_move(axis, place))
        return plot

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.setContentsMargins(6, 4, 6, 0)
        row.addWidget(self.indicator)
        row.addWidget(self.told, 1)
        row.addWidget(self.best)
        plots = QHBoxLayout()
        for plot in self.plots:
            plots.addWidget(plot)
        page = QWidget()
        inner = QVBoxLayout(page)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.setSpacing(4)
        inner.addLayout(row)
        inner.addLayout(plots, 1)
        blank = QWidget()
        QVBoxLayout(blank).addWidget(self.hint)
        self.pages = QStackedLayout(self)
        self.pages.addWidget(blank)
        self.pages.addWidget(page)

    def close_panel(self) -> None:
        """Stop listening."""
        self._timer.stop()
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self._theme = theme
        for plot in self.plots:
            paint_plot(plot, theme)
            plot.showGrid(x=False, y=False)
        self._draw()

    # ---- asking -------------------------------------------------------------------------------

    def ask(self) -> None:
        """Ask for the bars when things have settled."""
        if self.isVisible():
            self._timer.start()

    def showEvent(self, event: Any) -> None:
        super().showEvent(event)
        self._ask()

    def _ask(self) -> None:
        item, draft = self._studio.document.model.active_lattice, self._runner.draft
        if item is None:
            self._blank(NO_LATTICE)
        elif draft is None:
            self._blank(NO_TARGET)
        elif self._runner.alive and self._runner.following:
            if not self.bars:
                self._blank(WAITING)
        else:
            from ffdstudio.project.studies.indicator import bars

            model, name = self._studio.document.model, self.indicator.currentData()
            folder = self._runner.folders.of("indicator") if draft.objective.runs_code else None
            source = self._studio.document.records.source_of(draft.objective)
            consent = Consent(agreed=self._runner.consent.agreed)  # a panel asks for nothing
            self._studio.jobs.start(
                "Indicator",
                lambda _: bars(draft, model, item, name, folder, source, consent),
                self._take,
                self._refuse,
                "bars",
            )

    def _take(self, found: list[Bar]) -> None:
        self.bars = found
        self._draw()
        self.pages.setCurrentIndex(1)
        self.best.setEnabled(any(bar.knot is not None for bar in found))
        self._tell(self._tallest())

    def _refuse(self, error: Exception) -> None:
        if not isinstance(error, InputError):
            raise error
        self._blank(sentence(str(error)))

    def _blank(self, text: str) -> None:
        self.bars = []
        say(self.hint, text)
        self.pages.setCurrentIndex(0)

    # ---- drawing ------------------------------------------------------------------------------

    def _draw(self, hovered: Bar | None = None) -> None:
        import pyqtgraph as pg

        top = max((bar.score for bar in self.bars), default=0.0) or 1.0
        best = self._tallest()
        for axis, plot in enumerate(self.plots):
            mine = [bar for bar in self.bars if bar.axis == axis]
            plot.clear()
            plot.setVisible(bool(mine))
            if not mine:
                continue
            colours = [self._colour(bar, best, hovered) for bar in mine]
            plot.addItem(
                pg.BarGraphItem(
                    x0=[bar.low for bar in mine],
                    x1=[bar.high for bar in mine],
                    y0=0,
                    y1=[bar.score / top for bar in mine],
                    brushes=colours,
                    pen=pg.mkPen(self._theme["base"], width=1),
                )
            )
            ends = [mine[0].low, *(bar.high for bar in mine)]
            for knot in ends:
                plot.addItem(pg.InfiniteLine(knot, pen=pg.mkPen(self._theme["border"])))
            if hovered is not None and hovered.axis == axis and hovered.knot is not None:
                pen = pg.mkPen(self._theme["hovered"], width=2, style=Qt.PenStyle.DashLine)
                plot.addItem(pg.InfiniteLine(hovered.knot, pen=pen))
            plot.setRange(xRange=(ends[0], ends[-1]), yRange=(0, 1.08), padding=0.02)

    def _colour(self, bar: Bar, best: Bar | None, hovered: Bar | None) -> str:
        if bar is hovered:
            return self._theme["hovered"]
        return self._theme["highlight" if bar is best else "net"]

    def _tallest(self) -> Bar | None:
        free = [bar for bar in self.bars if bar.knot is not None]
        return max(free, key=lambda bar: bar.score, default=None)

    def _tell(self, bar: Bar | None) -> None:
        if bar is None:
            self.told.setText("The guards allow no further knot.")
        elif bar.knot is None:
            self.told.setText("The guards allow no knot in this interval.")
        else:
            self.told.setText(
                f"{LETTERS[bar.axis]} = {bar.knot:.4g}: {bar.score:.3g}. Click a bar to insert."
            )

    # ---- the mouse ----------------------------------------------------------------------------

    def _at(self, axis: int, place: Any) -> Bar | None:
        x = self.plots[axis].getPlotItem().vb.mapSceneToView(place).x()
        mine = [bar for bar in self.bars if bar.axis == axis]
        return next((bar for bar in mine if bar.low <= x <= bar.high), None)

    def _on_move(self, axis: int, place: Any) -> None:
        bar = self._at(axis, place)
        if bar is not None:
            self._draw(bar)
            self._tell(bar)

    def _on_click(self, axis: int, event: Any) -> None:
        bar = self._at(axis, event.scenePos())
        if bar is not None:
            self.insert(bar)

    def insert(self, bar: Bar) -> None:
        """Insert the best knot of an interval; an undoable edit."""
        item = self._studio.document.model.active_lattice
        if item is not None and bar.knot is not None and self._fits(item.rest.knots[bar.axis], bar):
            self._studio.do(c.InsertKnots(item.key, bar.axis, (bar.knot,)))

    def insert_best(self) -> None:
        """Insert the knot of the tallest bar."""
        bar = self._tallest()
        if bar is not None:
            self.insert(bar)

    @staticmethod
    def _fits(knots: Any, bar: Bar) -> bool:
        """Whether the bar is still about this lattice: newer bars may be under way."""
        ends = np.unique(knots)
        return bool(((ends[:-1] == bar.low) & (ends[1:] == bar.high)).any())
