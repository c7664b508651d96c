"""Editors for the fields of a description: which one a field gets follows from its type.

1. Wheels scroll the form: no editor changes under them.
2. An editor that shows a value gives the very same one back until somebody changes it.
"""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import msgspec
from msgspec import inspect
from PySide6.QtCore import Signal
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QWidget,
)

from ffdstudio.errors import InputError
from ffdstudio.gui.panels.fields import NumberEdit
from ffdstudio.gui.study.plots import narrow

MOST = 2**31 - 1
Labels = Mapping[str, str]


class Editor(QWidget):
    """Base of all editors; emits `edited` when the user has changed the value."""

    edited = Signal()

    def value(self) -> Any:
        """What is shown; `InputError` if that is no value."""
        raise NotImplementedError

    def put(self, value: Any) -> None:
        """Show a value, without telling of it."""
        raise NotImplementedError

    def _hold(self, *widgets: QWidget) -> None:
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        for widget in widgets:
            row.addWidget(widget)
        self.setFocusProxy(widgets[0])


class Spin(QSpinBox):
    """Number that the wheel does not change."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()


class Combo(QComboBox):
    """Box of choices that the wheel does not change."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()


class FlagEditor(Editor):
    """Yes or no."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self.box = QCheckBox(title)
        self._hold(self.box)
        self.box.toggled.connect(lambda: self.edited.emit())

    def value(self) -> bool:
        return self.box.isChecked()

    def put(self, value: bool) -> None:
        _quietly(self.box, lambda: self.box.setChecked(value))


class ChoiceEditor(Editor):
    """One of several words, or none."""

    def __init__(self, words: list[str | None], labels: Labels) -> None:
        super().__init__()
        self.box = narrow(Combo())
        for word in words:
            self.box.addItem("No" if word is None else labels.get(word, word), word)
        self._hold(self.box)
        self.box.currentIndexChanged.connect(lambda: self.edited.emit())

    def value(self) -> str | None:
        word: str | None = self.box.currentData()
        return word

    def put(self, value: str | None) -> None:
        _quietly(self.box, lambda: self.box.setCurrentIndex(self.box.findData(value)))


class CountEditor(Editor):
    """A whole number, or none."""

    def __init__(self, kind: inspect.IntType, optional: bool, unit: str) -> None:
        super().__init__()
        least = 0 if kind.ge is None else int(kind.ge)
        self._none = least - 1 if optional else None
        self.box = Spin()
        self.box.setRange(least if self._none is None else self._none, _most(kind))
        if optional:
            self.box.setSpecialValueText("none")
        self.box.setSuffix(f" {unit}" if unit else "")
        self._hold(self.box)
        self.box.valueChanged.connect(lambda: self.edited.emit())

    def value(self) -> int | None:
        return None if self.box.value() == self._none else self.box.value()

    def put(self, value: int | None) -> None:
        shown = self._none if value is None else value
        _quietly(self.box, lambda: self.box.setValue(shown or 0))


def _most(kind: inspect.IntType) -> int:
    return MOST if kind.le is None else int(kind.le)


class RealEditor(Editor):
    """A number, or none."""

    def __init__(self, title: str, optional: bool, unit: str) -> None:
        super().__init__()
        self._title, self._optional, self._unit = title, optional, unit
        self.line = NumberEdit(title)
        self.line.setMinimumWidth(64)
        self.line.put(None, "none" if optional else unit)
        self._hold(self.line)
        self.line.textEdited.connect(lambda: self.edited.emit())
        self.line.textEdited.connect(lambda: self.line.mark(False))

    def value(self) -> float | None:
        if not self.line.text().strip():
            if self._optional:
                return None
            raise InputError(f"{self._title}: a number is needed")
        found = self.line.value
        if found is None:
            self.line.mark(True)
            raise InputError(f"{self._title}: {self.line.text()!r} is no number")
        return found

    def put(self, value: float | None) -> None:
        self.line.put(value, "none" if self._optional else self._unit)


class TextEditor(Editor):
    """Some text; of a file, with a button that offers to choose it."""

    def __init__(self, title: str, browse: Callable[[], str | None] | None) -> None:
        super().__init__()
        self.line = QLineEdit()
        self.line.setAccessibleName(title)
        self._browse = browse
        parts: list[QWidget] = [self.line]
        if browse is not None:
            button = QPushButton("…")
            button.setFixedWidth(30)
            button.setToolTip("Choose a file")
            button.setAccessibleName(f"Choose a file: {title}")
            button.clicked.connect(self._choose)
            parts.append(button)
        self._hold(*parts)
        self.line.textEdited.connect(lambda: self.edited.emit())

    def _choose(self) -> None:
        chosen = None if self._browse is None else self._browse()
        if chosen:
            self.line.setText(chosen)
            self.edited.emit()

    def value(self) -> str:
        return self.line.text().strip()

    def put(self, value: str) -> None:
        self.line.setText(value)


class ListEditor(Editor):
    """Values with spaces or commas between them; words may stand in quotes."""

    def __init__(self, title: str, annotation: Any, numbers: bool, optional: bool) -> None:
        super().__init__()
        self._title, self._type, self._optional = title, annotation, optional
        self._numbers, self._shown, self._value = numbers, "", None
        self.line = QLineEdit()
        self.line.setAccessibleName(title)
        if optional:
            self.line.setPlaceholderText("none")
        self._hold(self.line)
        self.line.textEdited.connect(lambda: self.edited.emit())

    def value(self) -> Any:
        text = self.line.text()
        if text == self._shown:
            return self._value
        parts = self._parts(text)
        if not parts and self._optional:
            return None
        return tuple(parts)

    def _parts(self, text: str) -> list[Any]:
        try:
            words = shlex.split(text.replace(",", " ") if self._numbers else text)
            return [float(word) for word in words] if self._numbers else words
        except ValueError:
            raise InputError(f"{self._title}: {text!r} cannot be read") from None

    def put(self, value: Any) -> None:
        self._value = value
        words = value or ()
        self._shown = " ".join(map(repr, words)) if self._numbers else shlex.join(words)
        self.line.setText(self._shown)


class SetEditor(Editor):
    """Several of a few letters."""

    def __init__(self, words: list[str], optional: bool) -> None:
        super().__init__()
        self.boxes = {word: QCheckBox(word) for word in words}
        self._optional, self._value = optional, ()
        self._hold(*self.boxes.values())
        for box in self.boxes.values():
            box.toggled.connect(lambda: self.edited.emit())

    def value(self) -> tuple[str, ...] | None:
        chosen = tuple(word for word, box in self.boxes.items() if box.isChecked())
        if set(chosen) == set(self._value or ()):
            return self._value
        return None if self._optional and not chosen else chosen

    def put(self, value: tuple[str, ...] | None) -> None:
        self._value = value  # type: ignore[assignment]
        for word, box in self.boxes.items():
            _quietly(box, partial(box.setChecked, word in (value or ())))


def _quietly(widget: QWidget, change: Callable[[], Any]) -> None:
    blocked = widget.blockSignals(True)
    with contextlib.suppress(TypeError):
        change()
    widget.blockSignals(blocked)


# ---- which editor --------------------------------------------------------------------------


def editor_for(
    field: msgspec.structs.FieldInfo, labels: Labels, browse: Callable[[], str | None]
) -> Editor | None:
    """Editor for a field, None if the form does not offer it.

    Parameters
    ----------
    labels : mapping
        What words of choices are called.
    browse : callable
        Lets the user choose a file.
    """
    kind, extra, said = _bare(inspect.type_info(field.type))
    if not extra.get("form", False):
        return None
    kind, optional = _without_none(kind)
    kind = _bare(kind)[0]
    title, unit = str(said.get("title", field.name)), str(extra.get("unit", ""))
    made = _made(kind, optional, title, unit, labels, browse if extra.get("file") else None)
    if made is not None:
        tip = str(said.get("description", ""))
        made.setToolTip(tip[:1].upper() + tip[1:])
    return made


def _made(
    kind: inspect.Type, optional: bool, title: str, unit: str, labels: Labels,
    browse: Callable[[], str | None] | None,
) -> Editor | None:  # fmt: skip
    if isinstance(kind, inspect.BoolType):
        return FlagEditor(title)
    if isinstance(kind, inspect.LiteralType):
        words = [str(value) for value in kind.values]
        return ChoiceEditor([None, *words] if optional else [*words], labels)
    if isinstance(kind, inspect.IntType):
        return CountEditor(kind, optional, unit)
    if isinstance(kind, inspect.FloatType):
        return RealEditor(title, optional, unit)
    if isinstance(kind, inspect.StrType):
        return TextEditor(title, browse)
    if isinstance(kind, inspect.VarTupleType):
        item = _bare(kind.item_type)[0]
        if isinstance(item, inspect.LiteralType):
            return SetEditor([str(value) for value in item.values], optional)
        return ListEditor(title, kind, not isinstance(item, inspect.StrType), optional)
    return None


def _bare(kind: inspect.Type) -> tuple[inspect.Type, dict[str, Any], dict[str, Any]]:
    extra: dict[str, Any] = {}
    said: dict[str, Any] = {}
    while isinstance(kind, inspect.Metadata):
        extra |= kind.extra or {}
        said |= kind.extra_json_schema or {}
        kind = kind.type
    return kind, extra, said


def _without_none(kind: inspect.Type) -> tuple[inspect.Type, bool]:
    if not isinstance(kind, inspect.UnionType):
        return kind, False
    left = [one for one in kind.types if not isinstance(one, inspect.NoneType)]
    return left[0], len(left) < len(kind.types)
