"""Work-arounds do what they are for."""

from __future__ import annotations

import os
import subprocess
import sys

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
