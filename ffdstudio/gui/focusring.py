"""A ring around whatever has the keyboard, the same for every control in every theme.

1. The style draws none around lists, plots, tool buttons and the picture, and around others only
   after Tab. A style sheet would have to draw all controls anew, and they would change their size.
2. It lies over the window, outside the control where there is room, and is cut off where the
   control is: by scroll areas and docks. So it follows every move of the control's ancestors.
3. It is a mask of four strips. A whole widget over the picture would be painted with each frame.
4. Qt moves a dock behind another tab out of the window but leaves it in the chain of Tab: it is
   brought to the front when the keyboard comes to it.
5. The picture gets it by the keyboard only: who works there with the mouse knows where he is.
"""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QRect, Qt, Slot
from PySide6.QtGui import QPainter, QPaintEvent, QRegion
from PySide6.QtWidgets import QApplication, QDockWidget, QWidget
from shiboken6 import isValid

WIDTH = 2  # pixels
FOLLOWED = (QEvent.Type.Move, QEvent.Type.Resize, QEvent.Type.Show, QEvent.Type.Hide)


class FocusFrame(QWidget):
    """Four strips in the colour of what is highlighted."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def surround(self, place: QRect) -> None:
        """Be seen just inside a rectangle."""
        self.setGeometry(place)
        frame = QRect(0, 0, place.width(), place.height())
        hole = frame.adjusted(WIDTH, WIDTH, -WIDTH, -WIDTH)
        self.setMask(QRegion(frame).subtracted(QRegion(hole)))
        self.raise_()
        self.show()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), self.palette().highlight())
        painter.end()


class FocusRing(QObject):
    """The ring of one window, its dialogs, and its docks that float."""

    def __init__(self, app: QApplication, window: QWidget, picture: QWidget) -> None:
        super().__init__(window)
        self._app, self._window, self._picture = app, window, picture
        self._chain: list[QWidget] = []  # the control and what it lies in
        self.ring = FocusFrame(window)
        app.focusChanged.connect(self._on_focus)

    def close_ring(self) -> None:
        """Stop listening."""
        self._app.focusChanged.disconnect(self._on_focus)
        self._leave()
        self._hide()

    @Slot(QWidget, QWidget)
    def _on_focus(self, _old: QWidget | None, new: QWidget | None) -> None:
        self._leave()
        by_mouse = self._app.mouseButtons() != Qt.MouseButton.NoButton
        if new is None or (new is self._picture and by_mouse) or not self._is_ours(new):
            self._hide()
            return
        while new is not None:
            self._chain.append(new)
            new = None if new.isWindow() else new.parentWidget()
        for widget in self._chain:
            widget.installEventFilter(self)
        self._place()
        for widget in self._chain:
            if isinstance(widget, QDockWidget) and widget.visibleRegion().isEmpty():
                widget.raise_()

    def _is_ours(self, widget: QWidget) -> bool:
        top = widget.window()
        return top is self._window or top.parentWidget() is self._window

    def _leave(self) -> None:
        for widget in self._chain:
            if isValid(widget):
                widget.removeEventFilter(self)
        self._chain = []

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() in FOLLOWED:
            self._place()
        elif watched is self._picture and event.type() == QEvent.Type.MouseButtonPress:
            self._hide()
        return False

    def _hide(self) -> None:
        if isValid(self.ring):
            self.ring.hide()

    def _in(self, top: QWidget) -> FocusFrame:
        """The ring in a window: a dialog takes its own along when it goes."""
        if not isValid(self.ring):
            self.ring = FocusFrame(top)
        elif self.ring.parentWidget() is not top:
            self.ring.deleteLater()
            self.ring = FocusFrame(top)
        return self.ring

    def _place(self) -> None:
        control, top = self._chain[0], self._chain[-1]
        inner = QRect(control.mapTo(top, control.rect().topLeft()), control.size())
        seen = inner.adjusted(-WIDTH, -WIDTH, WIDTH, WIDTH)
        for holder in self._chain[1:]:
            seen &= QRect(holder.mapTo(top, holder.rect().topLeft()), holder.size())
        if not control.isVisible() or seen.isEmpty():
            self._hide()
        else:
            self._in(top).surround(seen)
