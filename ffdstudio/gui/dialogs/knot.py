"""Where to insert a knot."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import NumberEdit, note, number_text, say


class KnotDialog(QDialog):
    """Direction and parameter; the middle of the widest span is proposed."""

    def __init__(self, lattice: Lattice, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Insert a knot")
        self._lattice = lattice
        self.problem = ""
        self.direction = QComboBox()
        self.direction.addItems(["i", "j", "k"][: lattice.dimension])
        self.place = NumberEdit("Parameter of the knot")
        self.spans, self.wrong = note(), note(role="problem")
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setText("Insert")
        form = QFormLayout()
        form.addRow("&Direction", self.direction)
        form.addRow("&Parameter", self.place)
        layout = QVBoxLayout(self)
        layout.addWidget(note("One more control point along a direction; the shape stays."))
        layout.addLayout(form)
        for widget in (self.wrong, self.spans, self.buttons):
            layout.addWidget(widget)
        self.setMinimumWidth(400)
        self.direction.currentIndexChanged.connect(self._propose)
        self.place.textEdited.connect(self._check)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self._propose()
        self.place.setFocus()  # what is typed at once is the number, in place of the proposal
        self.place.selectAll()

    @property
    def axis(self) -> int:
        """Direction that is chosen."""
        return self.direction.currentIndex()

    @property
    def knot(self) -> float:
        """Parameter that is typed."""
        return self.place.value or 0.0

    def _propose(self) -> None:
        knots = np.unique(self._lattice.knots[self.axis])
        widest = int(np.argmax(np.diff(knots)))
        self.place.put(float(knots[widest] + knots[widest + 1]) / 2)
        shown = [number_text(float(v), 5) for v in knots]
        if len(shown) > 12:
            shown = [*shown[:6], "…", *shown[-5:]]
        say(self.spans, "Knots now: " + ", ".join(shown))
        self._check()

    def _check(self) -> None:
        self.problem = ""
        if self.place.value is None:
            self.problem = "A number is needed."
        else:
            try:
                self._lattice.insert_knots(self.axis, [self.knot])
            except InputError as error:
                self.problem = sentence(str(error))
        say(self.wrong, self.problem)
        self.place.mark(bool(self.problem))
        self.adjustSize()
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setEnabled(not self.problem)
