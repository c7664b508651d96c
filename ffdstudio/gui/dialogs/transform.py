"""Move, turn and scale the selected points by numbers, seen while they are typed."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QHBoxLayout,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.errors import InputError
from ffdstudio.gui.panels.fields import NumberEdit, VectorEdit, note, say
from ffdstudio.project.document import Document
from ffdstudio.project.edit import Edit
from ffdstudio.project.flatness import normal_axis, plane_of
from ffdstudio.project.transforms import rotation, scaling


class TransformDialog(QDialog):
    """Edits the selection of a document; call `end` when it is closed."""

    def __init__(self, document: Document, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Transform points")
        self._edit: Edit | None = None
        self.move_by, self.scale = VectorEdit("Move by"), VectorEdit("Scale")
        self.axis, self.angle = QComboBox(), QDoubleSpinBox()
        self.about = QComboBox()
        self.wrong = note(role="problem")
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self._lay_out()
        self._begin(document)
        self._connect()

    def _lay_out(self) -> None:
        self.axis.addItems(["about X", "about Y", "about Z"])
        self.axis.setCurrentIndex(2)
        self.about.addItems(["Centre of the points", "Origin (0, 0, 0)"])
        self.angle.setRange(-360, 360)
        self.angle.setDecimals(4)
        self.angle.setSuffix("°")
        self.move_by.put([0.0] * 3)
        self.scale.put([1.0] * 3)
        turn = QHBoxLayout()
        turn.addWidget(self.angle, 1)
        turn.addWidget(self.axis)
        form = QFormLayout()
        form.addRow("&Move by", self.move_by)
        form.addRow("Rotate by", turn)
        form.addRow("&Scale by", self.scale)
        form.addRow("&About", self.about)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.wrong)
        layout.addWidget(self.buttons)
        self.setMinimumWidth(400)

    def _begin(self, document: Document) -> None:
        try:
            self._edit = document.edit()
        except InputError as error:
            self._refuse(f"{error}.".capitalize())
            return
        self._stay_flat(normal_axis(plane_of(document.model)))
        count = len(self._edit.points)
        say(self.wrong, "")
        self.setWindowTitle(f"Transform {count} point{'' if count == 1 else 's'}")

    def _stay_flat(self, out: int | None) -> None:
        """Offer nothing that leads out of the plane of a flat mesh."""
        if out is None:
            return
        for field in (self.move_by, self.scale):
            field.bar(out, "A flat mesh stays in its plane")
        self.axis.setCurrentIndex(out)
        self.axis.setEnabled(False)

    def _connect(self) -> None:
        edits: list[NumberEdit] = [*self.move_by.edits, *self.scale.edits]
        for edit in edits:
            edit.textEdited.connect(self._show)
        for box in (self.axis, self.about):
            box.currentIndexChanged.connect(self._show)
        self.angle.valueChanged.connect(self._show)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)

    def _refuse(self, reason: str) -> None:
        say(self.wrong, reason)
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setEnabled(not reason)

    def _show(self) -> None:
        if self._edit is None:
            return
        move, scale = self.move_by.values, self.scale.values
        for edit in (*self.move_by.edits, *self.scale.edits):
            edit.mark(edit.value is None)
        if None in move or None in scale:
            self._refuse("A number is needed in every field.")
            return
        self._refuse("")
        start = self._edit.start
        pivot = start.mean(axis=0) if self.about.currentIndex() == 0 else np.zeros(3)
        turn = rotation(np.eye(3)[self.axis.currentIndex()], self.angle.value(), pivot)
        points = turn(scaling(np.array(scale, dtype=float), pivot)(start))
        self._edit.place(points + np.array(move, dtype=float))

    def end(self, accepted: bool) -> None:
        """Keep what is seen, or put everything back."""
        if self._edit is not None and accepted:
            self._edit.commit()
        elif self._edit is not None:
            self._edit.abort()
