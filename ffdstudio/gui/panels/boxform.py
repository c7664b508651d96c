"""The fields of the lattice builder and how they lie; what they do is in `builder`."""

from __future__ import annotations

from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.panels.draft import DIRECTIONS
from ffdstudio.gui.panels.fields import NumberEdit, note
from ffdstudio.gui.panels.reachnote import ReachNote
from ffdstudio.gui.quality.freezehint import FreezeHint
from ffdstudio.gui.studio import Studio

SPACINGS = (("Greville abscissae", "greville"), ("Equal distances", "uniform"))


class BoxForm(QWidget):
    """Fields of a `Draft`, each with a note for what is wrong with it."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self.name = QLineEdit()
        self.around = QComboBox()
        self.margins = [QDoubleSpinBox() for _ in DIRECTIONS]
        self.margin = self.margins[0]
        self.auto = QCheckBox("Automatic")
        self.dimension = QComboBox()
        self.counts = [QSpinBox() for _ in DIRECTIONS]
        self.degrees = [QSpinBox() for _ in DIRECTIONS]
        self.low = [NumberEdit(f"Lower bound in {d}") for d in DIRECTIONS]
        self.high = [NumberEdit(f"Upper bound in {d}") for d in DIRECTIONS]
        self.rotated = QCheckBox("&Rotated frame")
        self.angles = [QDoubleSpinBox() for _ in "XYZ"]
        self.align = QPushButton("&Align to shape")
        self.spacing = QComboBox()
        self.frozen = QSpinBox()
        self.hint = FreezeHint(studio, self.frozen)
        self.inside, self.seat = note(), note()
        self.reach = ReachNote(studio)
        self.make = QPushButton("&Create")
        self.cancel = QPushButton("Cancel")
        self.notes = {
            key: note(role="problem")
            for key in (
                "name",
                "frozen",
                "other",
                *(f"{w} {n}" for w in ("direction", "bounds") for n in range(3)),
            )
        }
        self._set_ranges()
        self._lay_out()

    def _set_ranges(self) -> None:
        for letter, margin in zip(DIRECTIONS, self.margins, strict=True):
            margin.setRange(0, 1000)
            margin.setSuffix(" %")
            margin.setDecimals(1)
            margin.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
            margin.setAccessibleName(f"Margin along {letter}")
            margin.setToolTip(
                f"Room between shape and faces along {letter}, of the largest extent of the shape"
            )
        self.auto.setToolTip(
            "As much room as it takes to move the skin by 8 % of the chord, or by the thickness "
            "of a body, before a cell inverts"
        )
        for axis in range(3):
            self.counts[axis].setRange(2, 999)
            self.counts[axis].setAccessibleName(f"Control points in {DIRECTIONS[axis]}")
            self.degrees[axis].setRange(1, 20)
            self.degrees[axis].setAccessibleName(f"Degree in {DIRECTIONS[axis]}")
            self.angles[axis].setRange(-180, 180)
            self.angles[axis].setDecimals(3)
            self.angles[axis].setSuffix("°")
            self.angles[axis].setAccessibleName(f"Angle about {'XYZ'[axis]}")
        self.frozen.setRange(0, 99)
        for text, key in SPACINGS:
            self.spacing.addItem(text, key)
        for number, text in ((3, "3: i, j, k"), (2, "2: i, j"), (1, "1: i")):
            self.dimension.addItem(text, number)
        for box in (self.around, self.spacing):
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
            box.setMinimumContentsLength(10)
        self.make.setDefault(True)
        for button in (self.align, self.cancel):
            button.setAutoDefault(True)  # Return presses the button that has the keyboard

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Name", self.name)
        form.addRow(self.notes["name"])
        form.addRow("Ar&ound", self.around)
        row = QHBoxLayout()
        row.setSpacing(4)
        for margin in self.margins:
            row.addWidget(margin, 1)
        label = QLabel("&Margin")
        label.setBuddy(self.margin)
        form.addRow(label, row)
        form.addRow("", self.auto)
        form.addRow("&Directions", self.dimension)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addLayout(self._directions())
        layout.addWidget(self.seat)
        layout.addWidget(self.reach)
        layout.addWidget(self.rotated)
        layout.addWidget(self._frame())
        more = QFormLayout()
        more.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        more.addRow("S&pacing", self.spacing)
        more.addRow("Fro&zen layers", self.frozen)
        more.addRow(self.notes["frozen"])
        more.addRow(self.hint)
        layout.addLayout(more)
        layout.addWidget(self.notes["other"])
        layout.addWidget(self.inside)
        layout.addStretch(1)
        self.footer = QWidget()  # stays in view while the form is scrolled
        buttons = QHBoxLayout(self.footer)
        buttons.addStretch(1)
        buttons.addWidget(self.cancel)
        buttons.addWidget(self.make)

    def _directions(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setVerticalSpacing(3)
        for column, text in enumerate(("Points", "Degree", "From", "To"), start=1):
            grid.addWidget(note(text), 0, column)
        self._letters = [QLabel(letter) for letter in DIRECTIONS]
        for axis in range(3):
            row: list[QWidget] = [self._letters[axis], self.counts[axis], self.degrees[axis]]
            row += [self.low[axis], self.high[axis]]
            for column, widget in enumerate(row):
                grid.addWidget(widget, 3 * axis + 1, column)
            grid.addWidget(self.notes[f"direction {axis}"], 3 * axis + 2, 1, 1, 4)
            grid.addWidget(self.notes[f"bounds {axis}"], 3 * axis + 3, 1, 1, 4)
        for column, stretch in ((1, 2), (2, 2), (3, 3), (4, 3)):
            grid.setColumnStretch(column, stretch)
        return grid

    def _frame(self) -> QWidget:
        self._frame_box = QWidget()
        grid = QGridLayout(self._frame_box)
        grid.setContentsMargins(0, 0, 0, 0)
        for axis, letter in enumerate("XYZ"):
            grid.addWidget(note(f"About {letter}"), 0, axis)
            grid.addWidget(self.angles[axis], 1, axis)
        grid.addWidget(self.align, 2, 0, 1, 3)
        self._frame_box.hide()
        return self._frame_box
