"""The selected control points by numbers: position, displacement, weight, for one or many."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import NumberEdit, VectorEdit, note, say
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.edit import Edit
from ffdstudio.project.interaction import numeric_edits as typed
from ffdstudio.project.interaction.flatness import normal_axis, plane_of
from ffdstudio.project.model import Index, LatticeItem

FOLLOW_MS = 100  # between two readings during a drag
SAME = 1e-9  # of the lattice's diagonal: points that were moved alike differ in the last digits
ROUNDED = 1e-14  # of the diagonal: a displacement below it is none
TENTHS = 100  # steps of the weight's slider from 1 to 10, and from 1 to 0.1


class PointsPanel(QWidget):
    """What is typed here becomes one entry of the history."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._weighing: Edit | None = None
        self.heading = note(role="heading")
        self.hint = note("Click a control point in the picture, or draw a rubber band (B).")
        self.position = VectorEdit("Position")
        self.displacement = VectorEdit("Displacement")
        self.by = VectorEdit("Move by")
        self.weight = NumberEdit("Weight", "Weight of the selected points; 1 is neutral")
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.problem = note(role="problem")
        self.alone = note("Numbers move the selected points only: no symmetry, no soft selection.")
        self.fields = QWidget()
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(FOLLOW_MS)
        self._timer.timeout.connect(self.fill)
        self._lay_out()
        self._connect()
        self.fill()

    def _lay_out(self) -> None:
        form = QFormLayout(self.fields)
        form.setContentsMargins(0, 0, 0, 0)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("", _letters())
        form.addRow("&Position", self.position)
        form.addRow("&Displacement", self.displacement)
        form.addRow("Move &by", self.by)
        self.slider.setRange(-TENTHS, TENTHS)
        self.slider.setAccessibleName("Weight handle")
        self.slider.setToolTip("Drag to change the weight, 0.1 to 10")
        self.reset_weight = QPushButton("1")
        self.reset_weight.setToolTip("Reset the weight to 1")
        self.reset_weight.setAccessibleName("Reset the weight to 1")
        self.reset_weight.setFixedWidth(30)
        row = QHBoxLayout()
        row.addWidget(self.weight, 1)
        row.addWidget(self.slider, 2)
        row.addWidget(self.reset_weight)
        form.addRow("&Weight", row)
        form.labelForField(row).setBuddy(self.weight)  # type: ignore[attr-defined]
        layout = QVBoxLayout(self)
        for widget in (self.heading, self.hint, self.fields, self.alone, self.problem):
            layout.addWidget(widget)
        layout.addStretch(1)

    def _connect(self) -> None:
        self.position.entered.connect(self._set_position)
        self.displacement.entered.connect(self._set_displacement)
        self.by.entered.connect(self._move_by)
        self.weight.entered.connect(self._set_weight)
        self.reset_weight.clicked.connect(lambda: self._set_weight(1.0))
        self.slider.sliderPressed.connect(self._begin_weighing)
        self.slider.valueChanged.connect(self._weigh)
        self.slider.sliderReleased.connect(self._end_weighing)
        for field in (self.position, self.displacement, self.by, self.weight):
            field.refused.connect(lambda reason: say(self.problem, sentence(reason)))
        self._listening = Listening(
            (self._studio.document.selection_changed, self.fill),
            (self._studio.document.moved, self.fill),
            (self._studio.document.structure_changed, self.fill),
            (self._studio.document.moving, self._on_moving),
            (self._studio.state.mode_changed, self._on_mode),
        )

    def close_panel(self) -> None:
        """Stop listening."""
        self._timer.stop()
        self._listening.stop()

    def paint_with(self, _theme: Theme) -> None:
        """Nothing here has a colour of its own."""

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep room for all lines of the hint: docks do not ask how high a text is."""
        super().resizeEvent(event)
        margins = self.contentsMargins() + self.layout().contentsMargins()  # type: ignore[union-attr]
        width = self.width() - margins.left() - margins.right()
        self.hint.setMinimumHeight(self.hint.heightForWidth(width))

    # ---- showing ----------------------------------------------------------------------------

    def fill(self) -> None:
        """Show the selection."""
        item, points = self._studio.document.model.active_lattice, self._points()
        self.fields.setVisible(bool(points))
        self._on_mode()
        self.hint.setVisible(not points)
        say(self.problem, "")
        if item is None or not points:
            say(self.heading, "No control point selected")
            return
        where = tuple(np.array(points).T)
        positions, rest = item.current.control_points[where], item.rest.control_points[where]
        self._title(points, item)
        close = SAME * item.rest.diagonal
        self.position.put(_common(positions, close))
        step = positions - rest
        step[np.abs(step) < ROUNDED * item.rest.diagonal] = 0.0
        self.displacement.put(_common(step, close))
        self.by.put([0.0, 0.0, 0.0])
        weight = _common(item.current.weights[where][:, None])[0]
        self.weight.put(weight, "mixed")
        self._show_weight(weight)

    def _on_mode(self) -> None:
        """What a drag would take along stays where it is when a number is typed: say so."""
        state = self._studio.state
        spreads = state.soft or state.mirror >= 0
        self.alone.setVisible(spreads and bool(self._points()))

    def _on_moving(self) -> None:
        """During a drag, follow it some times a second: typing into a field costs more."""
        if self._weighing is None and not self._timer.isActive():
            self._timer.start()

    def _title(self, points: list[Index], item: LatticeItem) -> None:
        frozen = sum(bool(item.frozen_mask[point]) for point in points)
        name = f"({', '.join(map(str, points[0]))})" if len(points) == 1 else f"{len(points)}"
        text = f"Control point {name}" if len(points) == 1 else f"{name} control points"
        if frozen:
            text += " (frozen)" if frozen == len(points) else f", {frozen} of them frozen"
        say(self.heading, text)
        self.fields.setEnabled(frozen < len(points))
        out = normal_axis(plane_of(self._studio.document.model))
        for field in (self.position, self.displacement, self.by):
            field.bar(out, "A flat mesh stays in its plane")

    def _show_weight(self, weight: float | None) -> None:
        self.slider.blockSignals(True)
        self.slider.setValue(0 if weight is None else round(TENTHS * float(np.log10(weight))))
        self.slider.blockSignals(False)

    def _points(self) -> list[Index]:
        return sorted(self._studio.document.selection)

    # ---- edits ------------------------------------------------------------------------------

    def _type(self, change: Callable[[], None]) -> None:
        """Carry out a whole edit; what is wrong is said below the fields."""
        try:
            change()
        except InputError as error:
            say(self.problem, sentence(str(error)))

    def _set_position(self, axis: int, value: float) -> None:
        self._type(lambda: typed.set_position(self._studio.document, _only(axis, value)))

    def _set_displacement(self, axis: int, value: float) -> None:
        self._type(lambda: typed.set_displacement(self._studio.document, _only(axis, value)))

    def _move_by(self, axis: int, value: float) -> None:
        vector = _only(axis, value)
        self._type(lambda: typed.set_displacement(self._studio.document, vector, absolute=False))

    def _set_weight(self, value: float) -> None:
        self._type(lambda: typed.set_weight(self._studio.document, value))

    def _begin_weighing(self) -> None:
        try:
            self._weighing = self._studio.document.edit()
        except InputError as error:
            say(self.problem, sentence(str(error)))

    def _weigh(self, value: int) -> None:
        weight = 10 ** (value / TENTHS)
        if self._weighing is not None and self._weighing is self._studio.document.editing:
            self._weighing.weigh(np.full(len(self._weighing.points), weight))
            self.weight.put(weight)
        elif not self.slider.isSliderDown():  # moved by the keyboard
            self._set_weight(weight)

    def _end_weighing(self) -> None:
        edit, self._weighing = self._weighing, None
        if edit is not None and edit is self._studio.document.editing:
            edit.commit()


def _common(values: Array, close: float = 0.0) -> list[float | None]:
    """Value of each column, None where it differs by more than what rounding does."""
    same = np.ptp(values, axis=0) <= close
    return [float(v) if s else None for v, s in zip(values[0], same, strict=True)]


def _only(axis: int, value: float) -> list[float | None]:
    """One coordinate, the others as they are."""
    return [value if k == axis else None for k in range(3)]


def _letters() -> QWidget:
    row = QWidget()
    layout = QHBoxLayout(row)
    layout.setContentsMargins(0, 0, 0, 0)
    for letter in "XYZ":
        label = QLabel(letter)
        label.setProperty("role", "muted")
        label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        layout.addWidget(label)
    return row
