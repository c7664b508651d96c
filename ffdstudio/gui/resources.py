"""Where icons, themes and samples lie: inside the installed package, or beside it in a checkout."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PySide6.QtGui import QIcon

PACKAGE = Path(__file__).parents[1]


def folder(name: str) -> Path:
    """Folder ``resources`` or ``sample_meshes``, wherever this installation keeps it."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name


def program_icon() -> QIcon:
    """Icon of the program."""
    from PySide6.QtGui import QIcon

    return QIcon(str(folder("resources") / "icons" / "ffdstudio.svg"))


@functools.cache
def icon(name: str, colour: str) -> QIcon:
    """Icon from the Material Design set, in a colour of the theme.

    qtawesome reads its fonts on the first call (0.2 s), so it is imported here.
    """
    import qtawesome

    result: QIcon = qtawesome.icon(f"mdi6.{name}", color=colour)
    return result
