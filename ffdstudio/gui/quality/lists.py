"""Lists of the quality panel: cells beyond the limits of a solver, and the worst cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QGridLayout,
    QHeaderView,
    QLabel,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from ffdstudio.gui.panels.fields import note
from ffdstudio.gui.quality.notes import put
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.measures import MEASURES
from ffdstudio.project.checks.checking import Digest, against

if TYPE_CHECKING:
    from ffdstudio.meshes.measures.report import Report

RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
CELL = Qt.ItemDataRole.UserRole


class LimitList(QWidget):
    """A solver's limits with the cells beyond them, undeformed and now.

    Labels in a grid, which show a limit in full on as many lines as it takes. The header of a
    tree was painted over what lies below the panel when it was cut by the panel's edge.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Cells beyond the limits")
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(4, 2, 4, 2)
        self._grid.setVerticalSpacing(2)
        self._grid.setColumnStretch(0, 1)
        self.rows: list[list[QLabel]] = []
        self._add(["Cells with", "undeformed", "now"], "muted")

    def _add(self, texts: list[str], role: str) -> list[QLabel]:
        """Put labels into the next row."""
        number, labels = self._grid.rowCount(), []
        for column, text in enumerate(texts):
            label = note(text, role)
            label.setWordWrap(column == 0)
            label.setAlignment(RIGHT if column else LEFT)
            self._grid.addWidget(label, number, column)
            labels.append(label)
        return labels

    def fill(self, report: Report, preset: str, _theme: Theme) -> None:
        """Count the cells against a preset; more than before are marked."""
        found = against(report, preset)
        while len(self.rows) < len(found):
            self.rows.append(self._add(["", "", ""], ""))
        for number, row in enumerate(self.rows):
            for label in row:
                label.setVisible(number < len(found))
        for row, (limit, before, now) in zip(self.rows, found, strict=False):
            measure = MEASURES[limit.measure]
            unit = "°" if measure.unit == "degrees" else ""
            row[0].setText(f"{measure.title} {limit.relation} {limit.value:g}{unit}")
            row[0].setToolTip(f"{measure.title} as defined by: {measure.standard}")
            row[1].setText(spaced(before))
            put(row[2], spaced(now), "" if not now else "problem" if now > before else "warning")


class WorstList(QTreeWidget):
    """The worst cells; emits `picked` with the number of one that was clicked or chosen by key."""

    picked = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Worst cells")
        self.setRootIsDecorated(False)
        self.setUniformRowHeights(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._make_columns(["Cell", "value", "change", "at"], 3)
        self.setToolTip("Click a cell, or move with the arrow keys, to fly there")
        self.itemClicked.connect(self._pick)
        self.currentItemChanged.connect(self._on_current)
        self._filling = self._fitted = False

    def _make_columns(self, columns: list[str], wide: int) -> None:
        self.setHeaderLabels(columns)
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
        """Be as high as so many rows, once it is known how high they are."""
        if not self._fitted and self.topLevelItemCount():
            height = self.header().sizeHint().height() + rows * max(self.sizeHintForRow(0), 16)
            self.setFixedHeight(height + 6)
            self._fitted = True

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
