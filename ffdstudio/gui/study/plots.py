"""What the plots share: pyqtgraph in the colours of the theme, and panels made when seen.

pyqtgraph takes a third of a second to load, so a plot is made when its panel is first shown.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QComboBox, QVBoxLayout, QWidget

from ffdstudio.gui.theme import Theme

SERIES = {
    "light": ("#1f6feb", "#d9480f", "#2b8a3e", "#9c36b5", "#0b7285", "#a8600a"),
    "dark": ("#6ea8fe", "#ff922b", "#69db7c", "#da77f2", "#3bc9db", "#ffd43b"),
}


KEY_HEIGHT = 18  # pixels


def series(theme: Theme, number: int) -> str:
    """Colour of the curve of that number."""
    colours = SERIES[theme.name]
    return colours[number % len(colours)]


def make_plot(name: str, x: str, y: str) -> Any:
    """Plot with a grid, mouse zoom and no menu of its own."""
    import pyqtgraph as pg

    plot = pg.PlotWidget()
    plot.setAccessibleName(name)
    plot.setMenuEnabled(False)
    plot.setLabel("bottom", x)
    plot.setLabel("left", y)
    plot.getPlotItem().getAxis("left").enableAutoSIPrefix(False)
    plot.getPlotItem().getAxis("bottom").enableAutoSIPrefix(False)
    plot.getPlotItem().setClipToView(True)
    plot.setMinimumSize(110, 110)
    return plot


def put_key(plot: Any, *curves: tuple[str, str, str]) -> None:
    """Tell curves by mark, name and colour in a line above a plot, where it hides none of them."""
    words = [f'<span style="color: {colour}">{mark} {name}</span>' for mark, name, colour in curves]
    item = plot.getPlotItem()
    item.setTitle("&nbsp; ".join(words), size="8pt")
    item.titleLabel.setMaximumHeight(KEY_HEIGHT)
    item.layout.setRowFixedHeight(0, KEY_HEIGHT)


def paint_plot(plot: Any, theme: Theme) -> None:
    """Give a plot the colours of a theme."""
    import pyqtgraph as pg

    plot.setBackground(theme["base"])
    for side in ("left", "bottom"):
        axis = plot.getPlotItem().getAxis(side)
        axis.setPen(pg.mkPen(theme["border"]))
        axis.setTextPen(pg.mkPen(theme["text"]))
        axis.labelStyle = {"color": theme["text"]}
        axis.setLabel(axis.labelText)
    plot.showGrid(x=True, y=True, alpha=0.18)
    legend = plot.getPlotItem().legend
    if legend is not None:
        legend.setLabelTextColor(theme["text"])
        legend.setBrush(None)  # what lies under it is not hidden
        for _, label in legend.items:
            label.setText(label.text, color=theme["text"])


def narrow(box: QComboBox, letters: int = 8) -> QComboBox:
    """Let a box be narrower than its longest row."""
    box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
    box.setMinimumContentsLength(letters)
    return box


def choice(rows: Mapping[str, str], letters: int = 8) -> QComboBox:
    """Box that offers the texts and keeps the keys."""
    box = narrow(QComboBox(), letters)
    for key, text in rows.items():
        box.addItem(text, key)
    return box


class WhenSeen(QWidget):
    """Makes a panel when it is first shown."""

    def __init__(self, make: Callable[[], QWidget], theme: Theme) -> None:
        super().__init__()
        self._make, self._theme = make, theme
        self.panel: Any = None
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)

    def showEvent(self, event: QShowEvent) -> None:
        self.made()
        super().showEvent(event)

    def made(self) -> Any:
        """Return the panel, made now if need be."""
        if self.panel is None:
            self.panel = self._make()
            self.layout().addWidget(self.panel)  # type: ignore[union-attr]
            self.panel.paint_with(self._theme)
        return self.panel

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self._theme = theme
        if self.panel is not None:
            self.panel.paint_with(theme)

    def close_panel(self) -> None:
        """Stop listening."""
        if self.panel is not None:
            self.panel.close_panel()
