"""The constraints of a study, one row each."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QGridLayout, QPushButton, QToolButton, QVBoxLayout, QWidget

from ffdstudio.gui.panels.fields import NumberEdit, note
from ffdstudio.gui.study.plots import narrow
from ffdstudio.project.studies.plan import QUANTITIES, RELATIONS, Limit

PLACED = {"thickness": "x / c", "lift": "angle", "moment": "angle"}
SPATIAL = ("volume",)
SIGNS = {"at least": "≥", "at most": "≤", "equal to": "="}


@dataclass(eq=False)
class _Row:
    quantity: QComboBox
    relation: QComboBox
    value: NumberEdit
    place: NumberEdit
    remove: QToolButton

    @property
    def widgets(self) -> tuple[QWidget, ...]:
        return self.quantity, self.relation, self.value, self.place, self.remove


class LimitsEdit(QWidget):
    """Rows of quantity, relation, value and place; emits `changed`."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[_Row] = []
        self._plane = True
        self.none = note("None.")
        self.add = QPushButton("&Add constraint")
        self.add.setToolTip("Thickness, area, volume, nose radius, lift or moment")
        self.add.clicked.connect(self._append)
        self._grid = QGridLayout()
        self._grid.setSpacing(4)
        self._grid.setColumnStretch(0, 2)
        self._grid.setColumnStretch(2, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        for part in (self.none, self.add):
            layout.addWidget(part)
        layout.insertLayout(1, self._grid)

    @property
    def limits(self) -> tuple[Limit, ...]:
        """The constraints whose numbers are complete."""
        return tuple(
            Limit(
                row.quantity.currentText(),
                row.relation.currentData(),
                row.value.value,
                row.place.value or 0.0,
            )
            for row in self.rows
            if row.value.value is not None
        )

    def for_sections(self, plane: bool) -> None:
        """Offer what fits a section, or a surface."""
        if plane != self._plane:
            self._plane = plane
            for row in list(self.rows):
                self._remove(row)

    def _append(self) -> None:
        row = _Row(
            narrow(QComboBox(), 6),
            QComboBox(),
            NumberEdit("Value"),
            NumberEdit("Place"),
            QToolButton(),
        )
        names = [q for q in QUANTITIES if (q in SPATIAL) != self._plane]
        row.quantity.addItems(names)
        for relation in RELATIONS:
            row.relation.addItem(SIGNS[relation], relation)
            row.relation.setItemData(row.relation.count() - 1, relation, 3)  # tool tip
        row.relation.setFixedWidth(42)
        for edit in (row.value, row.place):
            edit.setMinimumWidth(38)
        row.remove.setText("×")
        row.remove.setToolTip("Remove this constraint")
        row.remove.setAccessibleName("Remove this constraint")
        row.quantity.setAccessibleName("Quantity")
        row.relation.setAccessibleName("Relation")
        row.remove.clicked.connect(lambda: self._remove(row))
        row.quantity.currentIndexChanged.connect(lambda: self._dress(row))
        for box in (row.quantity, row.relation):
            box.currentIndexChanged.connect(self.changed)
        for edit in (row.value, row.place):
            edit.textEdited.connect(self.changed)
        self.rows.append(row)
        at = self._grid.rowCount()
        for column, widget in enumerate(row.widgets):
            self._grid.addWidget(widget, at, column)
        self._dress(row)
        self.none.hide()
        row.value.setFocus()

    def _dress(self, row: _Row) -> None:
        placed = PLACED.get(row.quantity.currentText())
        row.place.setVisible(placed is not None)
        row.place.setPlaceholderText(placed or "")
        row.value.setPlaceholderText("value")

    def _remove(self, row: _Row) -> None:
        self.rows.remove(row)
        for widget in row.widgets:
            self._grid.removeWidget(widget)
            widget.deleteLater()
        self.none.setVisible(not self.rows)
        self.changed.emit()
