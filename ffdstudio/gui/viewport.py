"""The picture: the one file that touches pyvistaqt.

1. The widget is built before the window is shown, is never re-parented, and is closed in the
   window's `closeEvent`: its OpenGL context lives and dies with the window.
2. `auto_update=False`; a change asks for a repaint by `update()`, never by VTK's `Render()`.
   Qt gathers the requests, so that fifty changes cost one picture.
3. VTK never sees a mouse or key event: its styles render by themselves and react to single
   letters. `PointerFilter` takes them all; `navigation` moves the camera.
4. The display is shifted by `origin`, the centre of the scene: float32 on the graphics card
   loses large coordinates. `matrix` takes world coordinates all the same.
5. No depth peeling: together with multi-sampling it is broken on Mesa.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from PySide6.QtCore import Signal
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QImage, QResizeEvent
from PySide6.QtWidgets import QWidget
from pyvistaqt import QtInteractor

from ffdstudio.aliases import Array
from ffdstudio.gui.lights import add_lights
from ffdstudio.gui.navigation import ANGLE, AXIS_VIEWS, View, fitted, looking
from ffdstudio.gui.overlay import Overlay
from ffdstudio.gui.quirks import let_go_of_surface
from ffdstudio.gui.theme import Theme
from ffdstudio.project.view.camera import Camera


class Viewport(QtInteractor):
    """Shows actors from a `View`; knows nothing of documents."""

    about_to_paint = Signal()
    painted = Signal()
    view_changed = Signal()

    def __init__(self, parent: QWidget, theme: Theme) -> None:
        super().__init__(
            parent, off_screen=False, auto_update=False, multi_samples=4, lighting=None
        )
        add_lights(self.renderer)
        self.setAccessibleName("Picture of meshes and lattices")
        self.setAcceptDrops(False)  # the window takes dropped files
        self.frames = 0
        self._fit_wanted: Array | None = None
        self.origin = np.zeros(3)
        self._bounds = np.array([[-1.0] * 3, [1.0] * 3])
        self._view = looking(*AXIS_VIEWS["corner"])
        self.overlay = Overlay(self, theme)
        self.paint_with(theme)
        self.view = fitted(self._view, self._bounds, 1.5)

    # ---- the camera -----------------------------------------------------------------------

    @property
    def view(self) -> View:
        """Where the viewer stands; set it to move him."""
        return self._view

    @view.setter
    def view(self, view: View) -> None:
        self._view = view
        self._place_camera()
        self.view_changed.emit()
        self.update()

    def set_scene(self, bounds: ArrayLike) -> None:
        """Tell the box ``[[lower], [upper]]`` that everything shown lies in."""
        self._bounds = np.array(bounds, dtype=float)
        self._place_camera()

    def fit(self, bounds: ArrayLike | None = None) -> None:
        """Show a box, or everything, from the present side; once the size is known."""
        box = np.array(self._bounds if bounds is None else bounds, dtype=float)
        self._fit_wanted = None if self.isVisible() else box
        self.view = fitted(self._view, box, self.width() / max(1, self.height()))

    def _place_camera(self) -> None:
        view, camera = self._view, self.renderer.GetActiveCamera()
        radius = float(np.linalg.norm(self._bounds[1] - self._bounds[0])) / 2
        reach = radius + float(np.linalg.norm(view.focal - self._bounds.mean(axis=0)))
        # in parallel projection the eye may stand anywhere on its line: behind everything
        distance = max(view.distance, 2 * reach) if view.parallel else view.distance
        focal = view.focal - self.origin
        camera.SetFocalPoint(*focal)
        camera.SetPosition(*(focal + distance * view.back))
        camera.SetViewUp(*view.up)
        camera.SetParallelProjection(view.parallel)
        camera.SetParallelScale(view.half_height)
        camera.SetViewAngle(ANGLE)
        far = distance + 1.05 * reach
        camera.SetClippingRange(max(distance - 1.05 * reach, far * 1e-3), far)

    def matrix(self) -> Array:
        """(4, 4) matrix from homogeneous world coordinates to normalised device coordinates."""
        aspect = self.width() / max(1, self.height())
        projection = self.renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(
            aspect, -1.0, 1.0
        )
        flat = [projection.GetElement(i, j) for i in range(4) for j in range(4)]
        shift = np.eye(4)
        shift[:3, 3] = -self.origin
        return np.array(flat).reshape(4, 4) @ shift

    def camera_now(self) -> Camera:
        """The camera as the tools want it: world coordinates to pixels of this widget."""
        return Camera(self.matrix(), self.width(), self.height())

    # ---- looks ----------------------------------------------------------------------------

    def paint_with(self, theme: Theme) -> None:
        """Take the background from a theme."""
        self.overlay.theme = theme
        self.renderer.SetBackground(*theme.rgb("view_bottom"))
        self.renderer.SetBackground2(*theme.rgb("view_top"))
        self.renderer.GradientBackgroundOn()
        self.update()

    def picture(self) -> QImage:
        """What is seen now, with everything drawn over it."""
        return self.grab().toImage()

    # ---- Qt -------------------------------------------------------------------------------

    def close(self) -> bool:  # type: ignore[override]
        """Release what was drawn and the OpenGL context; the widget shows nothing any more."""
        closed = bool(super().close())
        let_go_of_surface(self)
        return closed

    def paintGL(self) -> None:
        if self._fit_wanted is not None:
            self.fit(self._fit_wanted)
        self.about_to_paint.emit()
        super().paintGL()  # type: ignore[no-untyped-call]
        self.frames += 1
        self.painted.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.overlay.setGeometry(self.rect())
        self.view_changed.emit()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        event.ignore()

    def dropEvent(self, event: QDropEvent) -> None:
        event.ignore()


def save_picture(image: QImage, path: Path) -> None:
    """Write a picture; the format comes from the suffix (PNG, JPEG, WebP)."""
    from PySide6.QtCore import QBuffer, QIODevice

    from ffdstudio.errors import InputError
    from ffdstudio.files import write_bytes

    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not image.save(buffer, path.suffix.lstrip(".").upper() or "PNG"):  # type: ignore[call-overload]
        raise InputError(f"pictures can be saved as .png, .jpg or .webp, not as {path.suffix}")
    write_bytes(path, bytes(buffer.data().data()))
