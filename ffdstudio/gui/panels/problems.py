"""What has gone wrong or was remarked, newest first, to be read again later."""

from __future__ import annotations

from datetime import datetime

from PySide6.QtWidgets import QListWidget, QListWidgetItem

from ffdstudio.gui.resources import icon
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme


class ProblemsPanel(QListWidget):
    """Time and title, and the cause below."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.setAccessibleName("Problems")
        self.setWordWrap(True)
        self.setAlternatingRowColors(True)
        self._listening = Listening((studio.document.problem, self.add))

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Draw the icons anew."""
        for number in range(self.count()):
            self.item(number).setIcon(icon("alert-outline", theme["warning"]))

    def add(self, title: str, cause: str) -> None:
        """Put a problem at the head of the list."""
        text = f"{datetime.now():%H:%M}  {title}\n{cause}"
        item = QListWidgetItem(icon("alert-outline", self._studio.theme["warning"]), text)
        item.setToolTip(f"{title}\n{cause}")
        self.insertItem(0, item)
