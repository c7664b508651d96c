"""The studies of the document as a table: looked at, renamed, duplicated, removed."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QMenu, QTableWidget, QTableWidgetItem

from ffdstudio.gui.study.runs import STATES, Run

COLUMNS = ("Name", "Objective", "Method", "N", "Best cost", "Evaluations", "State")
ROW, MOST = 22, 5  # height of a row in pixels, and how many are seen at once


class StudiesTable(QTableWidget):
    """One row a study, the one that is looked at selected.

    Signals: `looked_at`, `duplicated`, `removed`, `shown_in_form` with a run, `renamed` with a run
    and a name.
    """

    looked_at = Signal(object)
    renamed = Signal(object, str)
    duplicated = Signal(object)
    removed = Signal(object)
    shown_in_form = Signal(object)

    def __init__(self) -> None:
        super().__init__(0, len(COLUMNS))
        self._runs: list[Run] = []
        self.setAccessibleName("Studies")
        self.setToolTip("Studies of the project. Double-click a name to change it")
        self.setHorizontalHeaderLabels(COLUMNS)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(ROW)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setTabKeyNavigation(False)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.customContextMenuRequested.connect(self._offer)
        self.itemSelectionChanged.connect(self._on_selection)
        self.itemChanged.connect(self._on_edit)

    def fill(self, runs: list[Run], chosen: Run | None) -> None:
        """Show runs."""
        self.blockSignals(True)
        self._runs = list(runs)
        self.setRowCount(len(runs))
        for row, run in enumerate(runs):
            for column, text in enumerate(_texts(run)):
                self._put(row, column, text)
        if chosen in self._runs:
            self.selectRow(self._runs.index(chosen))
        else:
            self.clearSelection()
        self.blockSignals(False)
        self.setVisible(bool(runs))
        self.setFixedHeight(self.horizontalHeader().height() + ROW * min(len(runs), MOST) + 4)

    def _put(self, row: int, column: int, text: str) -> None:
        item = self.item(row, column)
        if item is None:
            item = QTableWidgetItem()
            if column:
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
            self.setItem(row, column, item)
        if item.text() != text:
            item.setText(text)

    def _on_selection(self) -> None:
        row = self.currentRow()
        if 0 <= row < len(self._runs) and self.selectedItems():
            self.looked_at.emit(self._runs[row])

    def _on_edit(self, item: QTableWidgetItem) -> None:
        run = self._runs[item.row()]
        name = item.text().strip()
        if item.column() == 0 and name != run.name:
            self.renamed.emit(run, name)

    def _offer(self, place: QPoint) -> None:
        item = self.itemAt(place)
        if item is not None:
            menu = self.menu(self._runs[item.row()])
            menu.exec(self.viewport().mapToGlobal(place))
            menu.deleteLater()

    def menu(self, run: Run) -> QMenu:
        """What can be done with a study."""
        menu = QMenu(self)
        name = self.item(self._runs.index(run), 0)
        assert name is not None
        menu.addAction("&Rename", lambda: self.editItem(name))
        menu.addAction("&Duplicate", lambda: self.duplicated.emit(run))
        menu.addAction("Show in the &form", lambda: self.shown_in_form.emit(run))
        remove = menu.addAction("Re&move", lambda: self.removed.emit(run))
        remove.setEnabled(not run.alive)
        return menu


def _texts(run: Run) -> tuple[str, ...]:
    last = run.iterates[-1] if run.iterates else None
    best = min((record.cost for record in run.iterates), default=None)
    return (
        run.name,
        run.spec.objective.title,
        run.spec.method.title,
        "" if last is None else str(last.variables),
        "" if best is None else f"{best:.3e}",
        "" if last is None else str(last.evaluation),
        STATES[run.state],
    )
