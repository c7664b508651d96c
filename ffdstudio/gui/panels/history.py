"""The history as a list to jump in."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QListWidget, QListWidgetItem

from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme

START = "Beginning"


class HistoryPanel(QListWidget):
    """Entries in order; what is undone is greyed, the present one is marked."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.setAccessibleName("History")
        self.setUniformItemSizes(True)
        self.itemClicked.connect(self._jump)
        self.itemActivated.connect(self._jump)
        self._listening = Listening((studio.document.history_changed, self.fill))
        self.fill()

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, _theme: Theme) -> None:
        """Take the colours of a theme."""
        self.fill()

    def fill(self) -> None:
        """Show the history."""
        history = self._studio.document.history
        self.blockSignals(True)
        self.clear()
        for number, label in enumerate([START, *history.labels]):
            item = QListWidgetItem(label)
            item.setToolTip(label)
            if number > history.position:
                item.setForeground(QColor(self._studio.theme["muted"]))
                font = item.font()
                font.setItalic(True)
                item.setFont(font)
            self.addItem(item)
        self.setCurrentRow(history.position)
        self.scrollToItem(self.currentItem())
        self.blockSignals(False)

    def _jump(self, item: QListWidgetItem) -> None:
        self._studio.document.jump(self.row(item))
        self.setFocus(Qt.FocusReason.OtherFocusReason)
