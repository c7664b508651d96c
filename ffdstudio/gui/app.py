"""Starting the window."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path


def run(paths: Sequence[str | os.PathLike[str]] = ()) -> int:
    """Open the window with these files and return its exit code when it is closed."""
    from PySide6.QtWidgets import QApplication

    from ffdstudio.gui.errors import log_to_file

    app = QApplication(sys.argv[:1])
    app.setApplicationName("ffdstudio")
    app.setApplicationDisplayName("FFD Studio")
    log_to_file()
    from ffdstudio.gui.window import MainWindow

    window = MainWindow()
    window.show()
    window.keeper.offer()
    window.files.open_paths([Path(path) for path in paths])
    return app.exec()
