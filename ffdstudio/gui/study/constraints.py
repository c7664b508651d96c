"""The constraints of a study: a block of fields for each."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QToolButton, QVBoxLayout, QWidget

from ffdstudio.gui.panels.fields import note
from ffdstudio.gui.study.editors import Labels
from ffdstudio.gui.study.partform import Browse, KindForm
from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.spec.limits import ConstraintSpec


class ConstraintsEdit(QWidget):
    """Blocks of kind, fields and limits; emits `edited`, and `added` for a new one."""

    edited = Signal()
    added = Signal()

    def __init__(self, labels: Labels, browse: Browse) -> None:
        super().__init__()
        self._labels, self._browse = labels, browse
        self.rows: list[KindForm] = []
        self._frames: list[QFrame] = []
        self._bases: list[ConstraintSpec | None] = []
        self._kinds = list(CONSTRAINTS)
        self.none = note("None.")
        self.add = QPushButton("&Add constraint")
        self.add.setToolTip("Thickness, area, volume, nose radius, lift, moment, and others")
        self.add.clicked.connect(self._on_add)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(6)
        self._column.addWidget(self.none)
        self._column.addWidget(self.add)

    def value(self) -> tuple[ConstraintSpec, ...]:
        """The constraints; `InputError` if one of them is not complete."""
        pairs = zip(self.rows, self._bases, strict=True)
        return tuple(row.value(base) for row, base in pairs)

    def put(self, constraints: tuple[ConstraintSpec, ...]) -> None:
        """Show constraints."""
        while self.rows:
            self._remove(self.rows[0])
        for one in constraints:
            row = self._append(one)
            row.put(one)

    def for_sections(self, flat: bool) -> None:
        """Offer what fits a section, or a surface."""
        other = "surface" if flat else "section"
        self._kinds = [kind for kind in CONSTRAINTS if kind.needs != other]
        for row in list(self.rows):
            if row.kind in self._kinds:
                row.offer(self._kinds)
            else:
                self._remove(row)

    def _on_add(self) -> None:
        row = self._append(None)
        row.box.setFocus()
        self.added.emit()
        self.edited.emit()

    def _on_remove(self, row: KindForm) -> None:
        self._remove(row)
        self.edited.emit()

    def _append(self, base: ConstraintSpec | None) -> KindForm:
        frame, remove = QFrame(), QToolButton()
        row = KindForm(self._kinds, "Quantity", self._labels, self._browse)
        remove.setText("×")
        remove.setToolTip("Remove this constraint")
        remove.setAccessibleName("Remove this constraint")
        remove.clicked.connect(lambda: self._on_remove(row))
        line = QHBoxLayout(frame)
        line.setContentsMargins(0, 0, 0, 0)
        line.setSpacing(4)
        line.addWidget(row, 1)
        line.addWidget(remove)
        row.edited.connect(self.edited)
        self.rows.append(row)
        self._frames.append(frame)
        self._bases.append(base)
        self._column.insertWidget(self._column.count() - 1, frame)
        self.none.hide()
        return row

    def _remove(self, row: KindForm) -> None:
        number = self.rows.index(row)
        del self.rows[number], self._bases[number]
        frame = self._frames.pop(number)
        self._column.removeWidget(frame)
        frame.setParent(None)
        frame.deleteLater()
        self.none.setVisible(not self.rows)
