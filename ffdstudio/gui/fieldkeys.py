"""Keys while a field has the focus: which are the field's, and which go on to the program.

1. Qt asks the field first (`ShortcutOverride`), and a line takes more than it needs: Undo and
   Redo even when nothing has been typed, and on X11 Ctrl+E, Ctrl+K, Ctrl+U and Ctrl+D.
2. What has been typed is undone by the field. When there is nothing of that, Undo is about the
   document: else it would bring back the rounded text of a value long taken, and leaving the
   field would enter that as another edit.
3. Only the field that has the focus is watched. A filter of the whole program would run Python
   for every event there is.
"""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, QObject, Slot
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QDoubleSpinBox,
    QLineEdit,
    QSpinBox,
    QWidget,
)

Standard = QKeySequence.StandardKey
FIELDS = (Standard.Copy, Standard.Cut, Standard.Paste, Standard.SelectAll)


class FieldKeys(QObject):
    """Lets the program's shortcuts through.

    Parameters
    ----------
    shortcuts : iterable of QKeySequence
        Keys of the program. Those that are letters with Ctrl win over a field's own use.
    """

    def __init__(self, app: QApplication, shortcuts: Iterable[QKeySequence]) -> None:
        super().__init__()
        self._app = app
        self._ours = {keys.toString() for keys in shortcuts if _letter_with_ctrl(keys)}
        app.focusChanged.connect(self._on_focus)

    def close(self) -> None:
        """Stop listening."""
        self._app.focusChanged.disconnect(self._on_focus)

    @Slot(QWidget, QWidget)
    def _on_focus(self, _old: QWidget | None, new: QWidget | None) -> None:
        if isinstance(new, QLineEdit | QAbstractSpinBox):
            new.installEventFilter(self)

    def eventFilter(self, field: QObject, event: QEvent) -> bool:
        if event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
            return False
        if not self._is_ours(field, event):
            return False
        event.ignore()
        return True

    def _is_ours(self, field: QObject, event: QKeyEvent) -> bool:
        if event.matches(Standard.Undo):
            return not _undoes(field)
        if event.matches(Standard.Redo):
            return not _redoes(field)
        if any(event.matches(key) for key in FIELDS):
            return False
        return QKeySequence(event.keyCombination()).toString() in self._ours


def _letter_with_ctrl(keys: QKeySequence) -> bool:
    text = keys.toString()
    return text.startswith("Ctrl+") and text[-1].isalpha() and text[-2] == "+"


def _undoes(field: QObject) -> bool:
    """Whether something has been typed that is not taken yet."""
    line = _line(field)
    return line is not None and line.isUndoAvailable() and not _taken(field)


def _redoes(field: QObject) -> bool:
    line = _line(field)
    return line is not None and line.isRedoAvailable() and not _taken(field)


def _line(field: QObject) -> QLineEdit | None:
    return field.lineEdit() if isinstance(field, QAbstractSpinBox) else field  # type: ignore[return-value]


def _taken(field: QObject) -> bool:
    """Whether a number box that waits for Return shows the value that it has given away."""
    if not isinstance(field, QSpinBox | QDoubleSpinBox) or field.keyboardTracking():
        return False
    shown = field.prefix() + field.textFromValue(field.value()) + field.suffix()  # type: ignore[arg-type]
    return field.text() == shown
