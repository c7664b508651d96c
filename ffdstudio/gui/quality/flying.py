"""The camera's flight to a place, so that the viewer knows where he has come to."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from PySide6.QtCore import QEasingCurve, QObject, QVariantAnimation

from ffdstudio.gui.navigation import View, fitted
from ffdstudio.gui.viewport import Viewport

MILLISECONDS = 350


class Flight(QObject):
    """Moves a viewport's camera from where it is to a view of a box."""

    def __init__(self, viewport: Viewport) -> None:
        super().__init__(viewport)
        self._viewport = viewport
        self._begin = self.end = viewport.view
        self.animation = QVariantAnimation(self)
        self.animation.setStartValue(0.0)
        self.animation.setEndValue(1.0)
        self.animation.setDuration(MILLISECONDS)
        self.animation.setEasingCurve(QEasingCurve.Type.InOutCubic)
        self.animation.valueChanged.connect(self._step)

    def to(self, bounds: ArrayLike) -> None:
        """Fly to a box ``[[lower], [upper]]``, looking the same way."""
        view, viewport = self._viewport.view, self._viewport
        self._begin = view
        self.end = fitted(view, bounds, viewport.width() / max(1, viewport.height()))
        self.animation.stop()
        self.animation.start()

    def close(self) -> None:
        """Stay where we are."""
        self.animation.stop()

    def _step(self, share: float) -> None:
        view = self._viewport.view
        turned = (view.back != self.end.back).any() or (view.up != self.end.up).any()
        if turned or view.parallel != self.end.parallel:  # the user has taken the camera
            self.animation.stop()
            return
        self._viewport.view = between(self._begin, self.end, float(share))


def between(begin: View, end: View, share: float) -> View:
    """View on the way; the distance changes by equal factors."""
    if share >= 1:
        return end
    ratio = end.distance / begin.distance
    distance = begin.distance * ratio**share
    # the focal point keeps pace with the distance, else the end sweeps past
    part = share if abs(ratio - 1) < 1e-6 else (1 - ratio**share) / (1 - ratio)
    focal = begin.focal + part * (end.focal - begin.focal)
    return View(np.asarray(focal), end.back, end.up, float(distance), end.parallel, end.flat)
