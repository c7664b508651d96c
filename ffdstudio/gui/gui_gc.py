"""Garbage is collected in the GUI thread alone.

1. Python collects cycles in whichever thread happens to allocate. In a worker that ends what
   belongs to Qt there: PySide disconnects a collected callable with a mutex of Qt held, then
   waits for the interpreter, which the GUI thread holds while it waits for the mutex. Seen: a
   window that stood still for ever, with the worker in an import. So the automatic collector
   is switched off, and a timer does its work.
2. Young garbage is collected when there is as much as the automatic collector would allow. All
   generations take longer; they wait until no work is under way, but not for ever.
"""

from __future__ import annotations

import gc
from typing import Any
from weakref import WeakSet

from PySide6.QtCore import QCoreApplication, QObject, QTimer

INTERVAL_MS = 500
PATIENCE = 120  # intervals that a full collection waits for the end of all work


class Collector(QObject):
    """Collects garbage on a timer; there is one for an application."""

    def __init__(self, application: QCoreApplication) -> None:
        super().__init__(application)
        self.workers: WeakSet[Any] = WeakSet()  # what has `running` work, see 2
        self._waited = 0
        gc.disable()
        self._timer = QTimer(self)
        self._timer.setInterval(INTERVAL_MS)
        self._timer.timeout.connect(self.collect)
        self._timer.start()

    def collect(self) -> None:
        """Collect the generations that are full."""
        young, middle, old = (
            have > most for have, most in zip(gc.get_count(), gc.get_threshold(), strict=True)
        )
        working = any(one.running for one in self.workers)
        if old and (not working or self._waited >= PATIENCE):
            self._waited = 0
            gc.collect()
            return
        self._waited += int(old)
        if middle:
            gc.collect(1)
        elif young:
            gc.collect(0)


def collector() -> Collector:
    """Return the collector of this application, made when it is first asked for."""
    application = QCoreApplication.instance()
    assert application is not None
    found = application.findChild(Collector)
    return Collector(application) if found is None else found
