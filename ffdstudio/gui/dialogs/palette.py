"""The command palette: find any action by a few letters."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import (
    QDialog,
    QHeaderView,
    QLineEdit,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

STEPS = {
    Qt.Key.Key_Down: 1,
    Qt.Key.Key_Up: -1,
    Qt.Key.Key_PageDown: 10,
    Qt.Key.Key_PageUp: -10,
}


def score(letters: str, text: str) -> int | None:
    """How well a text fits typed letters, smaller is better; None if they do not occur in order.

    Examples
    --------
    >>> score("exme", "Export mesh…") is not None, score("xyz", "Undo")
    (True, None)
    """
    text, letters = text.lower(), letters.lower().replace(" ", "")
    if letters and letters in text.replace(" ", ""):
        return text.replace(" ", "").index(letters) - 1000
    total, place = 0, -1
    for letter in letters:
        found = text.find(letter, place + 1)
        if found < 0:
            return None
        total += 0 if found == 0 or text[found - 1] == " " else found - place
        place = found
    return total


class Palette(QDialog):
    """A line to type in over the list of enabled actions; Enter carries out the marked one."""

    def __init__(self, actions: Iterable[tuple[str, QAction]], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Command palette")
        self._actions = list(actions)
        self.chosen: QAction | None = None
        self.line = QLineEdit()
        self.line.setPlaceholderText("Type a few letters of a command")
        self.line.setClearButtonEnabled(True)
        self.line.setAccessibleName("Command")
        self.list = QTreeWidget()
        self.list.setRootIsDecorated(False)
        self.list.setHeaderHidden(True)
        self.list.setColumnCount(2)
        self.list.header().setStretchLastSection(False)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        layout = QVBoxLayout(self)
        layout.addWidget(self.line)
        layout.addWidget(self.list)
        self.line.textChanged.connect(self._fill)
        self.line.returnPressed.connect(self._take)
        self.line.installEventFilter(self)
        self.list.itemClicked.connect(self._take)
        self._fill("")
        self.list.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.list.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.resize(min(560, parent.width() - 40), min(420, parent.height() - 80))

    def _fill(self, letters: str) -> None:
        fits = []
        for where, action in self._actions:
            label = f"{where}: {action.text()}".replace("&", "")
            found = score(letters, label)
            if found is not None and action.isEnabled():
                fits.append((found, label, action))
        self.list.clear()
        for _, label, action in sorted(fits, key=lambda fit: fit[0]):
            item = QTreeWidgetItem([label, action.shortcut().toString()])
            item.setIcon(0, action.icon())
            item.setToolTip(0, action.toolTip())
            item.setData(0, Qt.ItemDataRole.UserRole, action)
            item.setTextAlignment(1, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.list.addTopLevelItem(item)
        self._mark(0)

    def _take(self) -> None:
        item = self.list.currentItem()
        if item is not None:
            self.chosen = item.data(0, Qt.ItemDataRole.UserRole)
            self.accept()

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyPress:
            return False
        step = STEPS.get(Qt.Key(event.key()))
        item, count = self.list.currentItem(), self.list.topLevelItemCount()
        if step is None or item is None:
            return False
        self._mark(max(0, min(count - 1, self.list.indexOfTopLevelItem(item) + step)))
        return True

    def _mark(self, row: int) -> None:
        item = self.list.topLevelItem(row)
        if item is not None:
            self.list.setCurrentItem(item)
