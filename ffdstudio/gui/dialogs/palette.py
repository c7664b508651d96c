"""The command palette: find any action by a few letters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

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

from ffdstudio.gui.panels.fields import note

STEPS = {
    Qt.Key.Key_Down: 1,
    Qt.Key.Key_Up: -1,
    Qt.Key.Key_PageDown: 10,
    Qt.Key.Key_PageUp: -10,
}


@dataclass(frozen=True)
class Offer:
    """Something that can be done: where it is found, what it says, what it is for."""

    where: str
    action: QAction
    tip: str = ""

    @property
    def label(self) -> str:
        """Place and text, without the marks of mnemonics."""
        return (
            f"{self.where}: {self.action.text()}".replace("&&", "\0")
            .replace("&", "")
            .replace("\0", "&")
        )


def score(letters: str, text: str, tip: str = "") -> int | None:
    """How well a text fits what is typed, smaller is better; None if it does not.

    All words in the text are best, all words in text or tip come next, then letters that occur
    in the text in their order.

    Examples
    --------
    >>> score("exme", "Export mesh…") is not None, score("xyz", "Undo")
    (True, None)
    >>> score("theme dark", "View: Theme: Dark") is not None
    True
    >>> score("ghost", "View: Undeformed shape", "Show the meshes as a ghost") is not None
    True
    """
    text, tip, words = text.lower(), tip.lower(), letters.lower().split()
    if all(word in text for word in words):
        return sum(text.index(word) for word in words) - 2000
    if all(word in text or word in tip for word in words):
        return len(text) - 1000
    return _scattered("".join(words), text)


def _scattered(letters: str, text: str) -> int | None:
    """Sum of the gaps between letters that occur in their order; None if they do not."""
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

    def __init__(self, offers: Iterable[Offer], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Command palette")
        self._offers = list(offers)
        self.chosen: QAction | None = None
        self.line = QLineEdit()
        self.line.setPlaceholderText("Type a few letters of a command")
        self.line.setClearButtonEnabled(True)
        self.line.setAccessibleName("Command")
        self.nothing = note("Nothing found. Try other words, such as those of a menu.")
        self.list = QTreeWidget()
        self.list.setRootIsDecorated(False)
        self.list.setHeaderHidden(True)
        self.list.setColumnCount(2)
        self.list.header().setStretchLastSection(False)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        layout = QVBoxLayout(self)
        layout.addWidget(self.line)
        layout.addWidget(self.nothing)
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
        for offer in self._offers:
            found = score(letters, offer.label, offer.tip)
            if found is not None and offer.action.isEnabled():
                fits.append((found, offer))
        self.list.clear()
        for _, offer in sorted(fits, key=lambda fit: fit[0]):
            self.list.addTopLevelItem(_row(offer))
        self.nothing.setVisible(not fits)
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


def _row(offer: Offer) -> QTreeWidgetItem:
    action = offer.action
    item = QTreeWidgetItem([offer.label, action.shortcut().toString()])
    item.setIcon(0, action.icon())
    item.setToolTip(0, offer.tip)
    item.setData(0, Qt.ItemDataRole.UserRole, action)
    item.setTextAlignment(1, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return item
