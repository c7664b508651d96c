"""The window starts fast: what takes long to load is loaded when it is needed."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("PySide6")

HEAVY = ("numba", "pyqtgraph", "meshio", "scipy")
CODE = f"""
import sys
import ffdstudio.gui.window
print([name for name in {HEAVY} if name in sys.modules])
"""


def test_nothing_heavy_is_loaded_before_the_window_is_there():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
