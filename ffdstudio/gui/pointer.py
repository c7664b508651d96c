"""Mouse and keys over the picture: to the tools first, what they leave moves the camera.

An event filter, so that VTK never sees an event (see `viewport`, reason 3). It returns a real
bool: a NumPy one raises inside Qt.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent

from ffdstudio.aliases import Array
from ffdstudio.gui.navigation import AXIS_VIEWS, levelled, looking, orbit, pan, triad_ends, zoom
from ffdstudio.gui.state import WindowState
from ffdstudio.gui.viewport import Viewport
from ffdstudio.project.interaction import numeric_edits as typed
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.feedback import weight_handle
from ffdstudio.project.interaction.tools import RADIUS, STILL, Tools
from ffdstudio.project.interaction.typed_numbers import is_typing

BUTTONS = {
    Qt.MouseButton.LeftButton: "left",
    Qt.MouseButton.MiddleButton: "middle",
    Qt.MouseButton.RightButton: "right",
}
KEYS = {
    Qt.Key.Key_X: "X",
    Qt.Key.Key_Y: "Y",
    Qt.Key.Key_Z: "Z",
    Qt.Key.Key_Escape: "Escape",
    Qt.Key.Key_Return: "Return",
    Qt.Key.Key_Enter: "Return",
    Qt.Key.Key_Left: "Left",
    Qt.Key.Key_Right: "Right",
    Qt.Key.Key_Up: "Up",
    Qt.Key.Key_Down: "Down",
    Qt.Key.Key_Shift: "Shift",
    Qt.Key.Key_Control: "Control",
}
MODIFIERS = (Qt.Key.Key_Shift, Qt.Key.Key_Control)
TRIAD_GRAB = 9.0  # pixels around an end of the triad
ZOOM_PIXELS = 30.0  # right button: pixels for one step of the wheel


class PointerFilter(QObject):
    """Takes every mouse and key event of the viewport."""

    def __init__(self, viewport: Viewport, tools: Tools, state: WindowState) -> None:
        super().__init__(viewport)
        self._viewport, self._tools, self._state = viewport, tools, state
        self._moving: str = ""  # what a drag beside the points does to the camera
        self._pivot: Array | None = None
        self._begin = self._last = QPointF()
        viewport.installEventFilter(self)
        state.mode_changed.connect(self._set_cursor)

    def close(self) -> None:
        """Stop listening."""
        self._tools.cancel()
        self._viewport.removeEventFilter(self)
        self._state.mode_changed.disconnect(self._set_cursor)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if isinstance(event, QMouseEvent):
            return self._mouse(kind, event)
        if isinstance(event, QWheelEvent):
            self._wheel(event)
            return True
        if kind == QEvent.Type.ShortcutOverride and self._tools.busy:
            event.accept()  # digits are for the drag now, not for actions
            return True
        if isinstance(event, QKeyEvent) and kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease):
            return self._key(kind, event)
        if kind == QEvent.Type.Leave:
            self._state.hover(None)
        elif isinstance(event, QFocusEvent) and event.lostFocus():
            self._state.show(before=False)  # the key is let go of elsewhere
            if self._tools.busy:
                self._tools.handle(PointerEvent("lost", self._viewport.camera_now()))
        # VTK's handlers of these need not run either
        return kind in (QEvent.Type.Enter, QEvent.Type.Leave)

    # ---- mouse ------------------------------------------------------------------------------

    def _mouse(self, kind: QEvent.Type, event: QMouseEvent) -> bool:
        if kind == QEvent.Type.MouseMove:
            self._move(event)
        elif kind == QEvent.Type.MouseButtonPress:
            self._viewport.setFocus(Qt.FocusReason.MouseFocusReason)
            self._press(event)
        elif kind == QEvent.Type.MouseButtonRelease:
            self._release(event)
        elif kind == QEvent.Type.MouseButtonDblClick and not self._reset_weight(event):
            self._press(event)
        return True

    def _press(self, event: QMouseEvent) -> None:
        self._begin = self._last = event.position()
        if self._turn_to_axis(event):
            return
        if self._tools.handle(self._pointer("press", event)):
            self._state.hover(None)
            return
        modifiers = event.modifiers()
        shift = bool(modifiers & Qt.KeyboardModifier.ShiftModifier)
        if event.button() == Qt.MouseButton.RightButton:
            self._moving = "zoom"
        elif event.button() == Qt.MouseButton.MiddleButton or shift or self._viewport.view.flat:
            self._moving = "pan"
        else:
            self._begin_orbit(event.position())

    def _begin_orbit(self, place: QPointF) -> None:
        """Turn about what is under the cursor, else about the middle of the picture."""
        viewport = self._viewport
        self._moving = "orbit"
        camera = viewport.camera_now()
        self._pivot = self._tools.occluders.under(camera, place.x(), place.y())
        viewport.view = levelled(viewport.view)
        self._state.navigate(True)

    def _turn_to_axis(self, event: QMouseEvent) -> bool:
        """A click on an end of the triad: look from there, in parallel projection."""
        view, place = self._viewport.view, event.position()
        if event.button() != Qt.MouseButton.LeftButton or view.flat or self._tools.busy:
            return False
        for name, (x, y) in triad_ends(view, self._viewport.height()).items():
            if np.hypot(place.x() - x, place.y() - y) <= TRIAD_GRAB:
                side = looking(*AXIS_VIEWS[name], view)
                self._viewport.view = replace(side, parallel=True)
                return True
        return False

    def _move(self, event: QMouseEvent) -> None:
        if self._moving:
            self._navigate(event.position())
        elif self._tools.busy:
            self._tools.handle(self._pointer("move", event))
        else:
            self._state.hover(self._tools.hit(self._pointer("move", event)))
            self._set_cursor()

    def _release(self, event: QMouseEvent) -> None:
        if self._moving:
            moved = event.position() - self._begin
            still = np.hypot(moved.x(), moved.y()) <= STILL
            plain = event.button() == Qt.MouseButton.LeftButton and not event.modifiers()
            if still and plain:
                self._tools.document.select(())
            self._moving = ""
            self._state.navigate(False)
        else:
            self._tools.handle(self._pointer("release", event))

    def _navigate(self, place: QPointF) -> None:
        dx, dy = place.x() - self._last.x(), place.y() - self._last.y()
        self._last = place
        view, height = self._viewport.view, self._viewport.height()
        if self._moving == "orbit":
            self._viewport.view = orbit(view, dx, dy, self._pivot)
        elif self._moving == "pan":
            self._viewport.view = pan(view, dx, dy, height)
        else:
            self._viewport.view = zoom(view, -dy / ZOOM_PIXELS)

    def _wheel(self, event: QWheelEvent) -> None:
        steps = event.angleDelta().y() / 120
        at = event.position()
        pointer = PointerEvent("wheel", self._viewport.camera_now(), at.x(), at.y(), steps=steps)
        if self._tools.busy:
            self._tools.handle(pointer)
            return
        width, height = self._viewport.width(), self._viewport.height()
        x, y = at.x() - width / 2, height / 2 - at.y()
        self._viewport.view = zoom(self._viewport.view, steps, x, y, height)

    def _reset_weight(self, event: QMouseEvent) -> bool:
        """Double click on the handle of a weight: back to 1."""
        point, item = self._tools.handle_point(), self._tools.document.model.active_lattice
        if point is None or item is None:
            return False
        camera = self._viewport.camera_now()
        place, weight = item.current.control_points[point], float(item.current.weights[point])
        x, y = weight_handle(camera, place, weight)
        if np.hypot(event.position().x() - x, event.position().y() - y) > RADIUS:
            return False
        typed.set_weight(self._tools.document, 1.0)
        return True

    def _pointer(self, kind: str, event: QMouseEvent) -> PointerEvent:
        modifiers, at = event.modifiers(), event.position()
        return PointerEvent(
            kind,
            self._viewport.camera_now(),
            at.x(),
            at.y(),
            BUTTONS.get(event.button(), ""),
            shift=bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            ctrl=bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
        )

    # ---- keys -------------------------------------------------------------------------------

    def _key(self, kind: QEvent.Type, event: QKeyEvent) -> bool:
        """Tell the tools; Tab goes on to Qt, so that the keyboard can leave the picture."""
        key = Qt.Key(event.key())
        number = {Qt.Key.Key_Tab: "Tab", Qt.Key.Key_Backspace: "Backspace"}.get(key, event.text())
        if self._tools.busy and kind == QEvent.Type.KeyPress and is_typing(number):
            self._tools.handle(self._named(number))
            return True
        if key in (Qt.Key.Key_Tab, Qt.Key.Key_Backtab):
            return False
        if key == Qt.Key.Key_Space and not self._tools.busy:
            if not event.isAutoRepeat():
                self._state.show(before=kind == QEvent.Type.KeyPress)
            return True
        if key in KEYS and (kind == QEvent.Type.KeyPress or key in MODIFIERS):
            taken = self._tools.handle(self._key_event(kind, key, event.modifiers()))
            if not taken and key == Qt.Key.Key_Escape:
                self._escape()
        return True

    def _key_event(
        self, kind: QEvent.Type, key: Qt.Key, modifiers: Qt.KeyboardModifier
    ) -> PointerEvent:
        """Key event; Qt's modifiers are those from before the key was pressed or released."""
        down = kind == QEvent.Type.KeyPress
        shift = bool(modifiers & Qt.KeyboardModifier.ShiftModifier)
        ctrl = bool(modifiers & Qt.KeyboardModifier.ControlModifier)
        if key == Qt.Key.Key_Shift:
            shift = down
        if key == Qt.Key.Key_Control:
            ctrl = down
        return self._named(KEYS[key], shift, ctrl)

    def _named(self, name: str, shift: bool = False, ctrl: bool = False) -> PointerEvent:
        at = self._viewport.mapFromGlobal(self._viewport.cursor().pos())
        camera = self._viewport.camera_now()
        return PointerEvent("key", camera, at.x(), at.y(), shift=shift, ctrl=ctrl, key=name)

    def _escape(self) -> None:
        """Nothing under way: back to moving, then to nothing selected."""
        if self._state.mode != "move":
            self._state.set_mode("move")
        else:
            self._tools.document.select(())

    def _set_cursor(self) -> None:
        shape = Qt.CursorShape.ArrowCursor
        if self._state.mode in ("box", "skin"):
            shape = Qt.CursorShape.CrossCursor
        elif self._state.hovered is not None:
            shape = Qt.CursorShape.PointingHandCursor
        if self._viewport.cursor().shape() != shape:
            self._viewport.setCursor(shape)
