"""Subscriptions that end together, each on its own when something goes wrong.

A signal ends its round at the first listener that raises: one view with a fault would leave
all after it, and the command that was carried out, half done. So what a listener raises goes
where the exceptions of slots go, to `sys.excepthook`, and the others hear the signal all the same.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from typing import Any

from psygnal import SignalInstance


class Listening:
    """What a view listens to; `stop` when the view is closed."""

    def __init__(self, *pairs: tuple[SignalInstance, Callable[..., Any]]) -> None:
        self._pairs = [(signal, _guarded(slot)) for signal, slot in pairs]
        for signal, slot in self._pairs:
            signal.connect(slot)

    def stop(self) -> None:
        """End all subscriptions."""
        for signal, slot in self._pairs:
            signal.disconnect(slot)
        self._pairs = []


def _guarded(slot: Callable[..., Any]) -> Callable[..., None]:
    """Slot whose exceptions are reported instead of raised."""

    @wraps(slot)  # a signal hands over as many values as the slot takes
    def call(*values: Any) -> None:
        try:
            slot(*values)
        except Exception as error:
            sys.excepthook(type(error), error, error.__traceback__)

    return call
