"""Fields for numbers that say what is wrong with them beside themselves."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QLineEdit, QWidget

MIXED = "mixed"


def number_text(value: float | None, digits: int = 5) -> str:
    """Short text of a number; empty for None."""
    return "" if value is None else f"{value:.{digits}g}"


def parse(text: str) -> float | str:
    """Return the number of a text, or why it is none.

    Examples
    --------
    >>> parse(" 1e-3 "), parse("1,5"), parse("two")
    (0.001, 1.5, 'a number is needed')
    """
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        return "a number is needed"
    return value if math.isfinite(value) else "the number must be finite"


class NumberEdit(QLineEdit):
    """Line for one number; emits `entered` when another valid one has been typed."""

    entered = Signal(float)
    refused = Signal(str)

    def __init__(self, name: str, tip: str = "") -> None:
        super().__init__()
        self.setAccessibleName(name)
        self._tip = tip or name
        self.setToolTip(self._tip)
        self.setMinimumWidth(52)
        self._shown = ""
        self._value: float | None = None
        self.returnPressed.connect(self._take)

    @property
    def value(self) -> float | None:
        """Number that is typed now; None if there is none."""
        found = parse(self.text())
        if self.text() == self._shown:
            return self._value
        return found if isinstance(found, float) else None

    def put(self, value: float | None, placeholder: str = "") -> None:
        """Show a number; with None, a grey placeholder."""
        self._value, self._shown = value, number_text(value)
        self.setToolTip(self._tip if value is None else f"{self._tip}: {value:.17g}")
        self.setText(self._shown)
        self.setCursorPosition(0)
        self.setPlaceholderText(placeholder)
        self.mark(False)

    def mark(self, wrong: bool) -> None:
        """Draw it as wrong, or as right."""
        if bool(self.property("wrong")) != wrong:
            self.setProperty("wrong", wrong)
            self.style().unpolish(self)
            self.style().polish(self)

    def _take(self) -> None:
        if self.text() == self._shown or not self.isModified():
            return
        found = parse(self.text())
        self.mark(isinstance(found, str))
        if isinstance(found, str):
            self.refused.emit(found)
            return
        self._shown, self._value = self.text(), found
        self.setText(self._shown)  # taken: nothing that was typed is left to undo
        self.entered.emit(found)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        self._take()
        super().focusOutEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.text() != self._shown:
            self.put(self._value, self.placeholderText())
            return
        super().keyPressEvent(event)


class VectorEdit(QWidget):
    """Some numbers in a row; emits `entered` with the place and the number."""

    entered = Signal(int, float)
    refused = Signal(str)

    def __init__(self, name: str, parts: Sequence[str] = "XYZ") -> None:
        super().__init__()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        self.edits = [NumberEdit(f"{name} {part}") for part in parts]
        for number, edit in enumerate(self.edits):
            edit.entered.connect(lambda value, n=number: self.entered.emit(n, value))
            edit.refused.connect(self.refused)
            row.addWidget(edit)

    def put(self, values: Sequence[float | None]) -> None:
        """Show numbers; None stands for values that differ."""
        for edit, value in zip(self.edits, values, strict=False):
            if not (edit.hasFocus() and edit.isModified()):
                edit.put(value, MIXED if value is None else "")

    def bar(self, place: int | None, why: str) -> None:
        """Keep one of the numbers as it is, and say why; None bars none."""
        for number, edit in enumerate(self.edits):
            edit.setEnabled(number != place)
            edit.setStatusTip(why if number == place else "")

    @property
    def values(self) -> list[float | None]:
        """The numbers that are typed now."""
        return [edit.value for edit in self.edits]


def note(text: str = "", role: str = "muted") -> QLabel:
    """Small text that wraps; `role` is "muted", "problem", "warning", "good" or "heading"."""
    label = QLabel(text)
    label.setWordWrap(True)
    label.setProperty("role", role)
    return label


def say(label: QLabel, text: str) -> None:
    """Show a text in a note, or hide the note if there is none."""
    label.setText(text)
    label.setVisible(bool(text))
