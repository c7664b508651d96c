"""Lists of the quality panel: cells beyond the limits of a solver, and the worst cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem

from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.measures import MEASURES
from ffdstudio.project.checking import Digest, against

if TYPE_CHECKING:
    from ffdstudio.meshes.measures.report import Report

RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
CELL = Qt.ItemDataRole.UserRole
ROW = 22  # pixels


class _List(QTreeWidget):
    """Flat list with one wide column and numbers beside it."""

    def __init__(self, name: str, columns: list[str], wide: int) -> None:
        super().__init__()
        self.setAccessibleName(name)
        self.setRootIsDecorated(False)
        self.setUniformRowHeights(True)
        self.setHeaderLabels(columns)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        header = self.header()
        header.setStretchLastSection(False)
        header.setMinimumSectionSize(30)
        for column in range(len(columns)):
            mode = QHeaderView.ResizeMode.ResizeToContents
            header.setSectionResizeMode(
                column, QHeaderView.ResizeMode.Stretch if column == wide else mode
            )
            if column:
                self.headerItem().setTextAlignment(column, RIGHT)

    def _add(self, texts: list[str]) -> QTreeWidgetItem:
        item = QTreeWidgetItem(texts)
        for column in range(1, len(texts)):
            item.setTextAlignment(column, RIGHT)
        self.addTopLevelItem(item)
        return item

    def _fit(self, rows: int) -> None:
        """Be as high as so many rows."""
        height = self.sizeHintForRow(0) if self.topLevelItemCount() else ROW
        self.setFixedHeight(self.header().sizeHint().height() + rows * max(height, 16) + 6)


class LimitList(_List):
    """A solver's limits with the cells beyond them, undeformed and now."""

    def __init__(self) -> None:
        super().__init__("Cells beyond the limits", ["Cells with", "undeformed", "now"], 0)
        self.setSelectionMode(QTreeWidget.SelectionMode.NoSelection)

    def fill(self, report: Report, preset: str, theme: Theme) -> None:
        """Count the cells against a preset; more than before are marked."""
        self.clear()
        for limit, before, now in against(report, preset):
            measure = MEASURES[limit.measure]
            unit = "°" if measure.unit == "degrees" else ""
            name = f"{measure.title} {limit.relation} {limit.value:g}{unit}"
            item = self._add([name, spaced(before), spaced(now)])
            item.setToolTip(0, f"{measure.title} as defined by: {measure.standard}")
            if now:
                colour = theme["danger"] if now > before else theme["warning"]
                item.setForeground(2, QColor(colour))
        self._fit(max(1, self.topLevelItemCount()))


class WorstList(_List):
    """The worst cells; emits `picked` with the number of one that was clicked or chosen by key."""

    picked = Signal(int)

    def __init__(self) -> None:
        super().__init__("Worst cells", ["Cell", "value", "change", "at"], 3)
        self.setToolTip("Click a cell, or move with the arrow keys, to fly there")
        self.itemClicked.connect(self._pick)
        self.currentItemChanged.connect(self._on_current)
        self._filling = False

    def fill(self, digest: Digest, picked: int) -> None:
        """Show the worst cells of a measure."""
        self._filling = True
        self.clear()
        for worst in digest.worst:
            place = ", ".join(f"{x:.6g}" for x in worst.place)
            short = ", ".join(f"{x:.3g}" for x in worst.place)
            change = f"{digest.change[worst.cell]:+.3g}"
            item = self._add([f"{worst.cell}", f"{worst.value:.4g}", change, short])
            item.setData(0, CELL, worst.cell)
            item.setToolTip(0, f"Cell {worst.cell} (counted from 0)")
            item.setToolTip(3, place)
            if worst.cell == picked:
                self.setCurrentItem(item)
        self._filling = False
        self._fit(6)

    def cells(self) -> list[int]:
        """Numbers of the cells listed, the worst first."""
        items = [self.topLevelItem(row) for row in range(self.topLevelItemCount())]
        return [item.data(0, CELL) for item in items if item is not None]

    def _on_current(self, item: QTreeWidgetItem | None) -> None:
        if item is not None and not self._filling:
            self._pick(item)

    def _pick(self, item: QTreeWidgetItem) -> None:
        self.picked.emit(item.data(0, CELL))


def spaced(number: int) -> str:
    """Write a number with thin spaces between the thousands."""
    return f"{number:,}".replace(",", "\u202f")
