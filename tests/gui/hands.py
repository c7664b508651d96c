"""A real mouse and keyboard: X events made by xdotool.

Qt's own test events would bypass the X server; these take the way of a user's. On a busy
machine they take their time, so every move waits until its event has come.
"""

from __future__ import annotations

import shutil
import subprocess
import time

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPoint
from PySide6.QtGui import QCursor, QWindow
from PySide6.QtWidgets import QApplication, QWidget

from tests.gui.conftest import User

XDOTOOL = shutil.which("xdotool")


class Arrivals(QObject):
    """Types of the events that have come from the X server."""

    def __init__(self) -> None:
        super().__init__()
        self.types: set[QEvent.Type] = set()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.spontaneous() and isinstance(watched, QWindow):
            self.types.add(event.type())
        return False


class Hands:
    """Moves the X server's pointer and presses its keys."""

    def __init__(self, user: User) -> None:
        window = self.window = user.window
        self.script = user.script
        self.arrivals = Arrivals()
        QApplication.instance().installEventFilter(self.arrivals)
        window.move(0, 0)
        self.wait(lambda: window.isVisible() and window.windowHandle().isExposed())
        self.focus()
        self.wait(lambda: QApplication.activeWindow() is window)

    def focus(self) -> None:
        """Give the window the keyboard unless one of ours has it.

        Without a window manager nobody does so when a progress dialog has come and gone.
        """
        assert XDOTOOL is not None
        words = [XDOTOOL, "getwindowfocus", "-f"]  # fails where no window has it
        found = subprocess.run(words, timeout=20, capture_output=True, text=True)
        shown = [one for one in QApplication.topLevelWindows() if one.isVisible()]
        if found.stdout.strip() not in {str(int(one.winId())) for one in shown}:
            self._xdotool("windowfocus", "--sync", str(int(self.window.winId())))

    def _xdotool(self, *words: str, until: QEvent.Type | None = None) -> None:
        assert XDOTOOL is not None
        self.arrivals.types.clear()
        subprocess.run([XDOTOOL, *words], check=True, timeout=20)
        self.wait(lambda: until is None or until in self.arrivals.types)
        self.settle()

    def settle(self, seconds: float = 0.05) -> None:
        """Let the window take what has come."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            QApplication.processEvents()
            time.sleep(0.002)

    def wait(self, condition, seconds: float = 30.0) -> None:  # type: ignore[no-untyped-def]
        """Let the window work until something is so."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "it did not come to that"
            self.settle(0.02)

    def idle(self) -> None:
        """Wait until no work is under way and nothing is left to paint."""
        self.wait(lambda: not self.window.jobs.running)
        self.settle(0.1)

    # ---- pointer --------------------------------------------------------------------------

    def place(self, pixel: np.ndarray | tuple[float, float], widget: QWidget | None = None) -> None:
        """Move the pointer to a pixel of the picture, or of a widget."""
        widget = self.window.viewport if widget is None else widget
        x, y = (round(float(value)) for value in pixel)
        self.wait(lambda: not widget.visibleRegion().isEmpty())
        self.wait(lambda: self._is_at(widget, QPoint(x, y)))

    def _is_at(self, widget: QWidget, pixel: QPoint) -> bool:
        """Whether the pointer is there; else move it and let the caller look again.

        A panel that opens may push the widget away while the pointer is on its way.
        """
        spot = widget.mapToGlobal(pixel) * widget.devicePixelRatioF()
        there = spot == QCursor.pos()
        if not there:
            self._travel(spot.x(), spot.y())
        return there

    def _travel(self, x: int, y: int) -> None:
        """Move the pointer until the window hears of it.

        A busy server may drop a motion that another one overtakes, and a pointer that is there
        already makes none: then a step aside and back brings it.
        """
        inside = self.window.frameGeometry().contains(QPoint(x, y))
        for aside in (0, 1, 0, 1, 0):
            self._xdotool("mousemove", str(x + aside), str(y))
            if not inside:
                return
            end = time.monotonic() + 3.0
            while time.monotonic() < end and not aside:
                if QEvent.Type.MouseMove in self.arrivals.types:
                    return
                self.settle(0.02)

    def down(self, button: int = 1) -> None:
        self._xdotool("mousedown", str(button), until=QEvent.Type.MouseButtonPress)

    def up(self, button: int = 1) -> None:
        self._xdotool("mouseup", str(button), until=QEvent.Type.MouseButtonRelease)

    def click(self, pixel: np.ndarray | tuple[float, float]) -> None:
        self.place(pixel)
        self.down()
        self.up()

    def press(self, widget: QWidget) -> None:
        """Click the middle of a widget."""
        centre = widget.rect().center()
        self.place((centre.x(), centre.y()), widget)
        self.down()
        self.up()

    def drag(self, *pixels: np.ndarray | tuple[float, float]) -> None:
        """Press at the first pixel, pass the others, release at the last."""
        self.place(pixels[0])
        self.down()
        for pixel in pixels[1:]:
            self.place(pixel)
        self.up()

    # ---- keys -----------------------------------------------------------------------------

    def key(self, *keys: str) -> None:
        """Press and release keys: ``ctrl+z``, ``x``, ``Escape``."""
        self.focus()
        self._xdotool("key", *keys, until=QEvent.Type.KeyRelease)

    def type(self, text: str) -> None:
        self._xdotool("type", text)

    # ---- the picture ----------------------------------------------------------------------

    def pixel(self, point: tuple[int, ...]) -> np.ndarray:
        """Pixel of a control point of the active lattice."""
        item = self.window.document.model.active_lattice
        assert item is not None
        return self.window.viewport.camera_now().project(item.current.control_points[point])[0]
