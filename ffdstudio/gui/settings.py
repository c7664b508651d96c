"""What the window remembers between two runs: layout, theme, recent files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from PySide6.QtCore import QByteArray, QSettings

LAYOUT_VERSION = 3  # raise it when docks or toolbars change: old layouts are then dropped
RECENT = 10


def settings_path() -> Path:
    """INI file of the settings, in the user's folder for configuration."""
    import platformdirs

    return Path(platformdirs.user_config_dir("ffdstudio", appauthor=False)) / "window.ini"


class Settings:
    """Remembered choices; damaged or missing ones fall back to the defaults."""

    def __init__(self, path: Path | None = None) -> None:
        self._store = QSettings(str(path or settings_path()), QSettings.Format.IniFormat)

    def text(self, key: str, default: str) -> str:
        """Remembered text."""
        value = self._store.value(key, default)
        return value if isinstance(value, str) else default

    def flag(self, key: str, default: bool) -> bool:
        """Remembered yes or no."""
        return self.text(key, str(default).lower()) == "true"

    def put(self, key: str, value: str | bool) -> None:
        """Remember a text or a yes/no."""
        self._store.setValue(key, str(value).lower() if isinstance(value, bool) else value)

    # ---- recent files -------------------------------------------------------------------

    def recent(self) -> list[Path]:
        """Files opened last, newest first, that still exist."""
        stored: Any = self._store.value("recent", [])
        names = [stored] if isinstance(stored, str) else list(stored or [])
        return [Path(name) for name in names if Path(name).exists()]

    def remember(self, path: Path) -> None:
        """Put a file at the head of the recent ones."""
        path = path.resolve()
        others = [p for p in self.recent() if p != path]
        self._store.setValue("recent", [str(p) for p in [path, *others][:RECENT]])

    def forget_recent(self) -> None:
        """Empty the list of recent files."""
        self._store.remove("recent")

    # ---- layout -------------------------------------------------------------------------

    def layout(self) -> tuple[QByteArray, QByteArray] | None:
        """Geometry and state of the window at its last closing."""
        geometry, state = self._store.value("geometry"), self._store.value("state")
        if isinstance(geometry, QByteArray) and isinstance(state, QByteArray):
            return geometry, state
        return None

    def put_layout(self, geometry: QByteArray, state: QByteArray) -> None:
        """Remember geometry and state of the window."""
        self._store.setValue("geometry", geometry)
        self._store.setValue("state", state)

    def save(self) -> None:
        """Write to the disk now."""
        self._store.sync()
