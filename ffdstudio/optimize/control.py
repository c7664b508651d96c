"""Pause, step and stop of a run, from any thread."""

from __future__ import annotations

import threading


class Stopped(Exception):
    """The user stops the study."""


class Control:
    """What another thread, for example the window's, asks of a run."""

    def __init__(self) -> None:
        self._go, self._stop, self._one = threading.Event(), threading.Event(), threading.Event()
        self._go.set()

    def pause(self) -> None:
        """Wait at the next iterate."""
        self._go.clear()

    def proceed(self) -> None:
        """Go on after a pause."""
        self._go.set()

    def step(self) -> None:
        """Go on for one iterate."""
        self._one.set()
        self._go.set()

    def stop(self) -> None:
        """End at once if a program runs, else at the next evaluation; the study can be resumed."""
        self._stop.set()
        self._go.set()

    def ended(self) -> None:
        """Let the next run go; a stop that comes before a run has begun still ends it."""
        self._stop.clear()

    def wait(self) -> None:
        """Hold an iterate up during a pause, and end the run if it is stopped."""
        self.check()
        self._go.wait()
        if self._one.is_set():
            self._one.clear()
            self._go.clear()
        self.check()

    def stopping(self) -> bool:
        """Whether the run is to end; an objective that takes its time asks in between."""
        return self._stop.is_set()

    def check(self) -> None:
        """End the run if it is stopped."""
        if self.stopping():
            raise Stopped
