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
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import NumberEdit, VectorEdit, note, say
from ffdstudio.project.edit import Edit
from ffdstudio.project.interaction.flatness import normal_axis, plane_of
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.interaction.transforms import rotation, scaling


class TransformDialog(QDialog):
    """Edits the selection by way of the tools, so that symmetry and soft selection apply.

    Call `end` when it is closed.
    """

    def __init__(self, tools: Tools, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Transform points")
        self._edit: Edit | None = None
        self.move_by, self.scale = VectorEdit("Move by"), VectorEdit("Scale")
        self.axis, self.angle = QComboBox(), QDoubleSpinBox()
        self.about = QComboBox()
        self.wrong, self.follow = note(role="problem"), note()
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self._lay_out()
        self._begin(tools)
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
        layout.addWidget(self.follow)
        layout.addWidget(self.wrong)
        layout.addWidget(self.buttons)
        self.setMinimumWidth(400)

    def _begin(self, tools: Tools) -> None:
        say(self.follow, following(tools.options))
        self._pivot = tools.pivot()
        try:
            self._spread, self._edit = tools.begin()
        except InputError as error:
            self._refuse(sentence(str(error)))
            return
        self._stay_flat(normal_axis(plane_of(tools.document.model)))
        count = len(tools.document.selection)
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
        pivot = self._pivot if self.about.currentIndex() == 0 else np.zeros(3)
        turn = rotation(np.eye(3)[self.axis.currentIndex()], self.angle.value(), pivot)
        grow, shift = scaling(np.array(scale, dtype=float), pivot), np.array(move, dtype=float)
        change = lambda points: turn(grow(points)) + shift  # noqa: E731
        self._edit.place(self._spread.place(self._edit.start, change))

    def end(self, accepted: bool) -> None:
        """Keep what is seen, or put everything back."""
        if self._edit is not None and accepted:
            self._edit.commit()
        elif self._edit is not None:
            self._edit.abort()


def following(options: Options) -> str:
    """What goes with the selected points, in words; empty for nothing.

    Examples
    --------
    >>> from ffdstudio.project.interaction.spread import Mirror
    >>> following(Options(mirror=Mirror(1)))
    'Points opposite the plane y = 0 follow.'
    """
    parts = []
    if options.soft is not None:
        parts.append("near points (soft selection)")
    if options.mirror is not None:
        plane = f"{'xyz'[options.mirror.axis]} = {options.mirror.at:g}"
        parts.append(f"points opposite the plane {plane}")
    return f"{' and '.join(parts)} follow.".capitalize() if parts else ""
