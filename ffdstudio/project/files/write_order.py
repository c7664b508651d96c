"""Writing in turn: workers may overtake one another, what they write must not."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path


class Turns:
    """Gives numbers to writes and keeps an older one from replacing a newer one.

    Examples
    --------
    >>> turns, done = Turns(), []
    >>> first, second = turns.take(), turns.take()
    >>> turns.wait(second, Path("a"), lambda: done.append("second"))
    >>> turns.wait(first, Path("a"), lambda: done.append("first"))
    >>> done
    ['second']
    """

    def __init__(self) -> None:
        self._taken = 0
        self._written: dict[Path, int] = {}
        self._lock = threading.Lock()

    def take(self) -> int:
        """Return the number of a write that begins now."""
        self._taken += 1
        return self._taken

    def latest(self, turn: int) -> bool:
        """Whether no write has begun since."""
        return turn == self._taken

    def wait(self, turn: int, path: Path, write: Callable[[], None]) -> None:
        """Write when nobody else does, unless something newer is in the file already."""
        with self._lock:
            if self._written.get(path, 0) < turn:
                write()
                self._written[path] = turn
