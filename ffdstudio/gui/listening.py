"""Subscriptions that end together."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from psygnal import SignalInstance


class Listening:
    """What a view listens to; `stop` when the view is closed."""

    def __init__(self, *pairs: tuple[SignalInstance, Callable[..., Any]]) -> None:
        self._pairs = list(pairs)
        for signal, slot in self._pairs:
            signal.connect(slot)

    def stop(self) -> None:
        """End all subscriptions."""
        for signal, slot in self._pairs:
            signal.disconnect(slot)
        self._pairs = []
