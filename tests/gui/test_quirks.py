"""Work-arounds do what they are for."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("PySide6")

SIGNALS = """
import ffdstudio.gui
from PySide6.QtCore import QCoreApplication, QObject, Signal
app = QCoreApplication([])
class Thing(QObject):
    happened = Signal()
thing = Thing()
for _ in range(20_000):
    thing.happened.emit()
    app.processEvents()
print("alive")
"""


def test_thousands_of_signals_do_not_end_the_interpreter() -> None:
    done = subprocess.run(
        [sys.executable, "-c", SIGNALS],
        capture_output=True,
        text=True,
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        timeout=60,
    )
    assert done.stdout == "alive\n", done.stderr
    assert done.returncode == 0


@pytest.mark.display
def test_a_closed_window_leaves_no_wrapper_of_its_surface(
    make_user: Any, cube: Path, qtbot: Any
) -> None:
    import gc

    import shiboken6
    from PySide6.QtGui import QSurface

    def wrappers() -> list[Any]:
        return [one for one in shiboken6.getAllValidWrappers() if isinstance(one, QSurface)]

    gc.collect()
    before = len(wrappers())
    user = make_user()
    user.open(cube)
    assert len(wrappers()) > before
    gc.disable()  # what only the garbage collector lets go may be let go too late
    try:
        user.script.answers = ["discard"]
        user.window.close()
        assert len(wrappers()) == before
    finally:
        gc.enable()
