"""The histogram, made when there is something to show: pyqtgraph takes a while to load."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QVBoxLayout, QWidget

from ffdstudio.gui.theme import Theme
from ffdstudio.project.checks.checking import Digest

if TYPE_CHECKING:
    from ffdstudio.gui.quality.histogram import Histogram


class LateHistogram(QWidget):
    """Does what a `Histogram` does; empty until it is filled."""

    def __init__(self) -> None:
        super().__init__()
        self.plot: Histogram | None = None
        self._row = QVBoxLayout(self)
        self._row.setContentsMargins(0, 0, 0, 0)
        self.setFixedHeight(176)

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        if self.plot is not None:
            self.plot.paint_with(theme)

    def clear_all(self) -> None:
        """Show nothing."""
        if self.plot is not None:
            self.plot.clear_all()

    def fill(self, digest: Digest, theme: Theme) -> None:
        """Show a measure."""
        if self.plot is None:
            from ffdstudio.gui.quality.histogram import Histogram

            self.plot = Histogram()
            self.plot.paint_with(theme)
            self._row.addWidget(self.plot)
        self.plot.fill(digest, theme)

    def mark(self, values: list[float], colour: str) -> None:
        """Draw dashed lines at values."""
        if self.plot is not None:
            self.plot.mark(values, colour)
