"""Convergence of studies, live, on common axes; the timeline below."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.plots import choice, make_plot, paint_plot, series
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.gui.study.runs import AGAINST, FIGURES, Run
from ffdstudio.gui.study.timeline import Timeline
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme

EXPORTS = "PNG picture (*.png);;SVG picture (*.svg);;CSV table (*.csv)"


class ConvergencePanel(QWidget):
    """One curve a study, triangles where it refined, a line at the iterate that is shown."""

    def __init__(self, studio: Studio, runner: StudyRunner) -> None:
        import pyqtgraph as pg

        super().__init__()
        self._studio, self._runner = studio, runner
        self.figure, self.against = choice(FIGURES, 10), choice(AGAINST, 10)
        self.figure.setAccessibleName("Figure")
        self.against.setAccessibleName("Against")
        self.logarithmic = QCheckBox("Lo&g")
        self.logarithmic.setToolTip("Logarithmic scale for the figure")
        self.logarithmic.setChecked(True)
        self.overlay = QCheckBox("&All")
        self.overlay.setToolTip("Draw all studies of this window on the same axes")
        self.overlay.setChecked(True)
        self.forget = QPushButton("&Drop")
        self.forget.setToolTip("Take the shown study out of the plot")
        self.export = QPushButton("E&xport…")
        self.export.setToolTip("Write the plot as PNG or SVG, or the figures as CSV")
        self.plot = make_plot("Convergence", "Evaluations", "Cost")
        self.plot.addLegend(offset=(-8, 8))
        self.here = pg.InfiniteLine(angle=90, movable=False)
        self.plot.addItem(self.here, ignoreBounds=True)
        self.timeline = Timeline(runner)
        self._curves: dict[Run, tuple[Any, Any]] = {}
        self._theme = studio.theme
        self._lay_out()
        self._connect()
        self.fill()

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.setContentsMargins(6, 4, 6, 0)
        row.addWidget(self.figure)
        row.addWidget(QLabel("against"))
        row.addWidget(self.against)
        row.addWidget(self.logarithmic)
        row.addWidget(self.overlay)
        row.addStretch(1)
        row.addWidget(self.forget)
        row.addWidget(self.export)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        layout.addLayout(row)
        layout.addWidget(self.plot, 1)
        layout.addWidget(self.timeline)

    def _connect(self) -> None:
        for box in (self.figure, self.against):
            box.currentIndexChanged.connect(self.fill)
        self.logarithmic.toggled.connect(self.fill)
        self.overlay.toggled.connect(self.fill)
        self.forget.clicked.connect(self._forget)
        self.export.clicked.connect(self.save)
        self.plot.scene().sigMouseClicked.connect(self._on_click)
        self._listening = Listening(
            (self._runner.grown, self.fill),
            (self._runner.changed, self.fill),
            (self._runner.shown_changed, self._on_shown),
        )

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()
        self.timeline.close_panel()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        import pyqtgraph as pg

        self._theme = theme
        paint_plot(self.plot, theme)
        self.here.setPen(pg.mkPen(theme["hovered"], width=1))
        for run, (curve, marks) in self._curves.items():
            self._colour(run, curve, marks)
        self.timeline.paint_with(theme)

    # ---- curves -------------------------------------------------------------------------------

    def fill(self) -> None:
        """Draw what there is."""
        name, against = self.figure.currentData(), self.against.currentData()
        logarithmic = self.logarithmic.isChecked()
        self.plot.setLogMode(x=False, y=logarithmic)
        self.plot.setLabel("bottom", AGAINST[against])
        self.plot.setLabel("left", FIGURES[name])
        every, one = self._runner.runs, self._runner.run
        shown = every if self.overlay.isChecked() else [one] if one is not None else []
        for run in [r for r in self._curves if r not in shown]:
            self._drop(run)
        for run in shown:
            self._draw(run, run.column(against), run.column(name), logarithmic)
        if any(run.iterates for run in shown):
            self.plot.enableAutoRange()
        else:  # ticks that mean something, while there is nothing
            self.plot.setRange(xRange=(0, 10), yRange=(-6, 0) if logarithmic else (0, 1))
        self.forget.setEnabled(self._runner.run is not None and not self._runner.run.alive)
        self.export.setEnabled(any(run.iterates for run in self._runner.runs))
        self._on_shown()

    def _draw(self, run: Run, x: Any, y: Any, logarithmic: bool) -> None:
        if run not in self._curves:
            curve = self.plot.plot(name=run.name, connect="finite")
            marks = self.plot.plot(symbol="t", pen=None, symbolSize=8)
            self._colour(run, curve, marks)
            self._curves[run] = (curve, marks)
            legend = self.plot.getPlotItem().legend
            legend.items[-1][1].setText(run.name, color=self._theme["text"])
        curve, marks = self._curves[run]
        good = np.isfinite(y) & ((y > 0) | (not logarithmic))
        curve.setData(x, np.where(good, y, np.nan))
        at = [k for k in run.refined_at if good[k]]
        marks.setData(x[at], y[at])

    def _colour(self, run: Run, curve: Any, marks: Any) -> None:
        import pyqtgraph as pg

        colour = series(self._theme, run.number)
        curve.setPen(pg.mkPen(colour, width=2))
        marks.setSymbolBrush(pg.mkBrush(colour))
        marks.setSymbolPen(pg.mkPen(self._theme["base"], width=0.5))

    def _drop(self, run: Run) -> None:
        for item in self._curves.pop(run):
            self.plot.removeItem(item)

    def _on_shown(self) -> None:
        run, place = self._runner.run, self._runner.place
        visible = run is not None and 0 <= place < len(run.iterates)
        self.here.setVisible(visible)
        if run is not None and visible:
            self.here.setValue(float(run.column(self.against.currentData())[place]))

    def _on_click(self, event: Any) -> None:
        """Go to the iterate nearest to a click."""
        run = self._runner.run
        if run is None or not run.iterates:
            return
        x = self.plot.getPlotItem().vb.mapSceneToView(event.scenePos()).x()
        column = run.column(self.against.currentData())
        self._runner.show(run, int(np.argmin(np.abs(column - x))))

    def _forget(self) -> None:
        if self._runner.run is not None:
            self._runner.forget(self._runner.run)

    # ---- files --------------------------------------------------------------------------------

    def save(self) -> None:
        """Ask for a name and write the plot or the figures; drawing is done by a worker."""
        folder = Path(self._studio.settings.text("folder", str(Path.home())))
        name = self.figure.currentData()
        suggestion = folder / f"convergence_{name}.png"
        path = self._studio.asker.save_path("Export convergence", EXPORTS, suggestion)
        if path is None:
            return
        runs = [r for r in self._runner.runs if r.iterates]
        if not self.overlay.isChecked() and self._runner.run is not None:
            runs = [self._runner.run]
        against = self.against.currentData()
        self._studio.jobs.start(
            f"Writing {path.name}",
            lambda _: write(path, runs, self._runner.run, name, against),
            lambda _: self._studio.say(f"Wrote {path.name}"),
        )


def write(path: Path, runs: list[Run], shown: Run | None, figure: str, against: str) -> None:
    """Write a plot of runs, or the figures of the shown one, by the suffix of the path.

    Raises
    ------
    InputError
        If it cannot be written, or the suffix means nothing.
    """
    import io

    from ffdstudio.errors import InputError
    from ffdstudio.files import write_bytes
    from ffdstudio.optimize import plots
    from ffdstudio.optimize.runs.record import RunHistory

    kind = path.suffix.lower().lstrip(".")
    histories = {run.name: RunHistory(list(run.history.records)) for run in runs}
    if kind == "csv":
        name = shown.name if shown is not None and shown.name in histories else runs[-1].name
        write_bytes(path, plots.table(histories[name]))
    elif kind in plots.KINDS:
        data = io.BytesIO()
        plots.convergence(histories, figure, against).savefig(data, format=kind, dpi=150)
        write_bytes(path, data.getvalue())
    else:
        raise InputError(f"{path.name}: the name must end in .png, .svg or .csv")
