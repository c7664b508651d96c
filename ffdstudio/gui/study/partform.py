"""Forms made from descriptions: one row for each field that is offered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
from msgspec import inspect
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFormLayout, QVBoxLayout, QWidget

from ffdstudio.errors import InputError
from ffdstudio.gui.study.editors import Combo, Editor, FlagEditor, Labels, editor_for
from ffdstudio.gui.study.plots import narrow
from ffdstudio.optimize.spec.rows import Part, Row

Browse = Callable[[], "str | None"]


def form_layout(parent: QWidget) -> QFormLayout:
    """Layout of all forms here."""
    form = QFormLayout(parent)
    form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
    form.setContentsMargins(0, 0, 0, 0)
    form.setVerticalSpacing(4)
    form.setHorizontalSpacing(8)
    return form


class PartForm(QWidget):
    """Fields of one table of a description; emits `edited`.

    Attributes
    ----------
    editors : dict
        By the name of their field.
    """

    edited = Signal()

    def __init__(self, kind: type[Part], labels: Labels, browse: Browse) -> None:
        super().__init__()
        self.kind = kind
        self.editors: dict[str, Editor] = {}
        self.layout_ = form_layout(self)
        for field in msgspec.structs.fields(kind):
            editor = editor_for(field, labels, browse)
            if editor is None:
                continue
            self.editors[field.name] = editor
            own = isinstance(editor, FlagEditor)  # it tells its name itself
            self.layout_.addRow("" if own else _title(field), editor)
            editor.edited.connect(self.edited)
            if not field.required:
                editor.put(field.default)

    def value(self, base: Part | None = None) -> Any:
        """The table that the fields say; what they do not offer is taken from a base.

        Raises
        ------
        InputError
            If a field holds no value, or they do not fit together.
        """
        given = {}
        if isinstance(base, self.kind):
            given = {f.name: getattr(base, f.name) for f in msgspec.structs.fields(self.kind)}
        given |= {name: editor.value() for name, editor in self.editors.items()}
        try:
            return self.kind(**given)
        except ValueError as error:
            raise InputError(f"[{self.kind.table}] {error}") from None

    def put(self, part: Part) -> None:
        """Show a table."""
        for name, editor in self.editors.items():
            editor.put(getattr(part, name))

    def show_row(self, name: str, visible: bool) -> None:
        """Show or hide the row of a field."""
        self.layout_.setRowVisible(self.editors[name], visible)


def _title(field: msgspec.structs.FieldInfo) -> str:
    kind = inspect.type_info(field.type)
    said = kind.extra_json_schema if isinstance(kind, inspect.Metadata) else None
    return str((said or {}).get("title", field.name))


class KindForm(QWidget):
    """A choice of kinds, and below it the fields of the one that is chosen.

    Signals: `edited` (any value), `chosen` (the user took another kind).
    """

    edited = Signal()
    chosen = Signal()

    def __init__(
        self, kinds: Sequence[type[Row]], title: str, labels: Labels, browse: Browse
    ) -> None:
        super().__init__()
        self._labels, self._browse = labels, browse
        self._forms: dict[type[Row], PartForm] = {}
        self.box = narrow(Combo())
        self.box.setAccessibleName(title)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(4)
        top = form_layout(head := QWidget())
        top.addRow(title, self.box)
        self._column.addWidget(head)
        self.offer(kinds)
        self.box.currentIndexChanged.connect(self._on_choice)

    def offer(self, kinds: Sequence[type[Row]]) -> None:
        """Offer kinds; the one that is chosen stays if it is among them."""
        known = [self.box.itemData(n) for n in range(self.box.count())]
        if known == list(kinds):
            return
        now = self.box.currentData()
        self.box.blockSignals(True)
        self.box.clear()
        for number, kind in enumerate(kinds):
            self.box.addItem(kind.title, kind)
            self.box.setItemData(number, kind.about(), 3)  # tool tip
        self.box.setCurrentIndex(kinds.index(now) if now in kinds else 0)
        self.box.blockSignals(False)
        self._show()

    @property
    def kind(self) -> type[Row]:
        """The kind that is chosen."""
        kind: type[Row] = self.box.currentData()
        return kind

    @property
    def form(self) -> PartForm:
        """The fields of the kind that is chosen."""
        if self.kind not in self._forms:
            form = PartForm(self.kind, self._labels, self._browse)
            form.edited.connect(self.edited)
            self._forms[self.kind] = form
            self._column.addWidget(form)
        return self._forms[self.kind]

    def choose(self, kind: type[Row]) -> None:
        """Take a kind, without telling of it."""
        self.box.blockSignals(True)
        places = [n for n in range(self.box.count()) if self.box.itemData(n) is kind]
        if places:
            self.box.setCurrentIndex(places[0])
        self.box.blockSignals(False)
        self._show()

    def value(self, base: Part | None = None) -> Any:
        """See `PartForm.value`."""
        return self.form.value(base)

    def put(self, row: Row) -> None:
        """Show a table of any of the kinds."""
        self.choose(type(row))
        self.form.put(row)

    def _on_choice(self) -> None:
        self._show()
        self.chosen.emit()
        self.edited.emit()

    def _show(self) -> None:
        current = self.form
        for form in self._forms.values():
            form.setVisible(form is current)
        self.setToolTip(self.kind.about())
