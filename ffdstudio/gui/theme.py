"""The light and the dark look.

`setColorScheme` does nothing on a bare X server and native styles ignore palettes, so the
program brings both: the Fusion style and its own colours, which the viewport shares.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication

from ffdstudio.gui.resources import folder

THEMES = ("light", "dark")
ROLES = {
    "Window": "window",
    "WindowText": "text",
    "Base": "base",
    "AlternateBase": "alternate",
    "Text": "text",
    "Button": "button",
    "ButtonText": "text",
    "BrightText": "danger",
    "Highlight": "highlight",
    "Accent": "highlight",
    "HighlightedText": "highlighted_text",
    "Link": "link",
    "LinkVisited": "link",
    "ToolTipBase": "base",
    "ToolTipText": "text",
    "PlaceholderText": "muted",
}
FADED = ("WindowText", "Text", "ButtonText", "HighlightedText")


class Theme(Mapping[str, str]):
    """Colours by name, ``#rrggbb``; see ``resources/theme/*.json`` for the names."""

    def __init__(self, name: str) -> None:
        self.name = name
        path = folder("resources") / "theme" / f"{name}.json"
        self._colours: dict[str, str] = json.loads(path.read_text(encoding="utf-8"))

    def __getitem__(self, name: str) -> str:
        return self._colours[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._colours)

    def __len__(self) -> int:
        return len(self._colours)

    def rgb(self, name: str) -> tuple[float, float, float]:
        """Red, green and blue in [0, 1], as VTK wants them."""
        colour = QColor(self[name])
        return colour.redF(), colour.greenF(), colour.blueF()

    def palette(self) -> QPalette:
        """Palette for the Fusion style."""
        palette = QPalette()
        for role, name in ROLES.items():
            palette.setColor(getattr(QPalette.ColorRole, role), QColor(self[name]))
        for role in FADED:
            faded = QColor(self["muted"])
            faded.setAlpha(140)
            palette.setColor(QPalette.ColorGroup.Disabled, getattr(QPalette.ColorRole, role), faded)
        return palette

    def stylesheet(self) -> str:
        """Style sheet with its ``@names`` replaced by this theme's colours and check mark."""
        home = folder("resources") / "theme"
        names = {**self, "check": (home / f"check-{self.name}.svg").as_posix()}
        text = (home / "style.qss").read_text(encoding="utf-8")
        return re.sub(r"@(\w+)", lambda m: names[m[1]], text)


def preferred(app: QGuiApplication) -> str:
    """Theme the desktop asks for; light where it says nothing."""
    dark = app.styleHints().colorScheme() == Qt.ColorScheme.Dark
    return "dark" if dark else "light"


def apply(app: QApplication, name: str) -> Theme:
    """Give the whole program one of the `THEMES`; returns its colours."""
    theme = Theme(name)
    if app.style().objectName() != "fusion":
        app.setStyle("Fusion")
    app.setPalette(theme.palette())
    app.setStyleSheet(theme.stylesheet())
    return theme
