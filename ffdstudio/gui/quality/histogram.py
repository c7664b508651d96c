"""Cells by value: bars as they are now, a line as they were undeformed."""

from __future__ import annotations

import numpy as np
import pyqtgraph
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from ffdstudio.gui.quality.colours import map_of, scale_of
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.measures import MEASURES
from ffdstudio.project.checks.checking import Digest

DECADES = (0, 1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000)


def height(counts: np.ndarray) -> np.ndarray:
    """How high a number of cells is drawn: few bad ones among millions shall be seen."""
    return np.asarray(np.log10(1 + counts))


class Histogram(pyqtgraph.PlotWidget):  # type: ignore[misc]  # written without types
    """Bars in the colours of the picture; dashed lines where a solver draws the line."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Histogram of the measure, undeformed and now")
        self.setFixedHeight(176)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMouseEnabled(False, False)
        self.setMenuEnabled(False)
        self.hideButtons()
        self.bars = pyqtgraph.BarGraphItem(x0=[0], x1=[1], height=[0])
        self.line = pyqtgraph.PlotCurveItem([0, 1], [0], stepMode="center")
        self.addItem(self.bars)
        self.addItem(self.line)
        self.marks: list[pyqtgraph.InfiniteLine] = []
        for name in ("left", "bottom"):
            self.getAxis(name).enableAutoSIPrefix(False)
        left = self.getAxis("left")
        left.setTicks([[(float(height(np.array(n))), f"{n:g}") for n in DECADES]])
        left.setWidth(46)
        left.setLabel("cells")

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self.setBackground(theme["base"])
        for name in ("left", "bottom"):
            self.getAxis(name).setPen(theme["border"])
            self.getAxis(name).setTextPen(theme["muted"])
        self.line.setPen(pyqtgraph.mkPen(theme["text"], width=1.5))

    def clear_all(self) -> None:
        """Show nothing."""
        self.bars.setOpts(x0=[0], x1=[1], height=[0])
        self.line.setData([0, 1], [0])
        self.mark([], "#000000")

    def fill(self, digest: Digest, theme: Theme) -> None:
        """Show a measure."""
        edges = np.log10(digest.edges) if digest.scale.log else digest.edges
        middles = (digest.edges[1:] + digest.edges[:-1]) / 2
        places = scale_of(digest, False).place(middles)
        colours = map_of(digest.measure, False, theme)[np.round(places * 255).astype(int)]
        brushes = [QColor(*colour) for colour in colours.tolist()]
        self.bars.setOpts(
            x0=edges[:-1],
            x1=edges[1:],
            height=height(digest.now),
            brushes=brushes,
            pen=pyqtgraph.mkPen(theme["border"]),
        )
        self.line.setData(edges, height(digest.before))
        self.line.setVisible(bool(digest.before.any()))
        bottom, measure = self.getAxis("bottom"), MEASURES[digest.measure]
        bottom.setLogMode(digest.scale.log)
        unit = f" [{measure.unit}]" if measure.unit == "degrees" else ""
        bottom.setLabel(measure.title + unit)
        highest = max(1.0, float(height(max(digest.now.max(), digest.before.max()))))
        self.setXRange(float(edges[0]), float(edges[-1]), padding=0.02)
        self.setYRange(0, highest, padding=0.04)

    def mark(self, values: list[float], colour: str) -> None:
        """Draw dashed lines at values (on the axis as it is)."""
        for old in self.marks:
            self.removeItem(old)
        pen = pyqtgraph.mkPen(colour, width=1.5, style=Qt.PenStyle.DashLine)
        self.marks = [pyqtgraph.InfiniteLine(value, pen=pen) for value in values]
        for new in self.marks:
            self.addItem(new, ignoreBounds=True)
