"""Makes the README's pictures: a window with the sample, and a drag in it.

    xvfb-run -a -s "-screen 0 1600x1200x24" python resources/pictures/make.py

A mouse drags a control point in a real window; Pillow (it comes with pyvista) puts the
pictures of the drag together.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

from PIL import Image
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from ffdstudio.gui.settings import Settings
from ffdstudio.gui.window import MainWindow
from ffdstudio.project.commands import CreateBox
from ffdstudio.samples import sample

HERE = Path(__file__).parent
BOX = CreateBox("Lattice", (-0.12, -0.2, 0.0), (1.12, 0.2, 0.0), (7, 5), (3, 3), frozen=1)
BENT = {(5, 2): (0, -0.05), (4, 1): (0, -0.03), (2, 3): (0, 0.02)}
STEPS, THERE = 12, QPoint(-14, -46)  # of the drag, in all, and where it goes in pixels
LEFT = Qt.MouseButton.LeftButton


def settle(window: MainWindow, seconds: float = 0.2) -> None:
    """Let the window do all that is due."""
    end = time.monotonic() + seconds
    while time.monotonic() < end or window.jobs.running:
        QApplication.processEvents()
        time.sleep(0.005)


def prepared(folder: Path) -> MainWindow:
    """Window with the sample and a lattice that is bent a little."""
    window = MainWindow(Settings(folder / "settings.ini"), None, folder / "recovery")
    window.resize(1280, 800)
    window.show()
    window.files.open_paths([sample("naca0012.su2")])
    settle(window)
    window.view.switch("ghost", True)
    document = window.document
    document.do(BOX)
    for point, step in BENT.items():
        edit = document.edit([point])
        edit.translate([*step, 0])
        edit.commit()
    settle(window)
    return window


def mouse(window: MainWindow, kind: QEvent.Type, place: QPoint) -> None:
    """Send a mouse event with the left button."""
    view, button = window.viewport, LEFT
    event = QMouseEvent(
        kind, QPointF(place), QPointF(view.mapToGlobal(place)), button, button,
        Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    QApplication.sendEvent(view, event)


def picture(window: MainWindow, path: Path) -> Image.Image:
    """Take a picture of the window."""
    settle(window, 0.3)
    window.grab().save(str(path))
    return Image.open(path).convert("RGB")


def drag(window: MainWindow, folder: Path) -> list[Image.Image]:
    """Drag a control point with the mouse; the pictures on the way."""
    item: Any = window.document.model.active_lattice
    x, y = window.viewport.camera_now().project(item.current.control_points[3, 3])[0]
    start = QPoint(round(x), round(y))
    QTest.mouseClick(window.viewport, LEFT, pos=start)
    mouse(window, QEvent.Type.MouseButtonPress, start)
    frames = []
    for step in range(1, STEPS + 1):
        mouse(window, QEvent.Type.MouseMove, start + THERE * step / STEPS)
        frames.append(picture(window, folder / "frame.png"))
    mouse(window, QEvent.Type.MouseButtonRelease, start + THERE)
    settle(window, 0.5)
    return [*frames, picture(window, folder / "frame.png")]


def main() -> None:
    """Make both pictures."""
    _app = QApplication([])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        window = prepared(folder)
        frames = drag(window, folder)
        frames[-2].save(HERE / "window.png", optimize=True)
        small = [frame.resize((960, 600), Image.Resampling.LANCZOS) for frame in frames]
        back = small[-2::-1]
        small[0].save(
            HERE / "drag.webp", save_all=True, append_images=[*small[1:], *back], quality=60,
            duration=[90] * (len(small) - 1) + [900] + [60] * len(back), loop=0, method=6,
        )  # fmt: skip
        window.files.may_discard = lambda: True  # type: ignore[method-assign]
        window.close()


if __name__ == "__main__":
    main()
