"""Long work: who runs it, and the runner for scripts and tests, which runs it at once.

1. Work is a function of a `Progress` that returns values; it never touches the document.
2. Its result comes back through `done`, on the thread that owns the document.
3. Starting work with the `key` of other work makes that one out of date: its result is
   dropped.
4. Work of one `line` arrives in the order in which it was started, whichever is done first.

The window has a runner of the same form with worker threads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

Progress = Callable[[float, str], None]
"""Called with a fraction in [0, 1] and a text; raises if the user has cancelled."""


class Runner(Protocol):
    """Something that runs work and delivers what comes of it."""

    def start(
        self,
        label: str,
        work: Callable[[Any], Any],
        done: Callable[[Any], None],
        failed: Callable[[Exception], None] | None = None,
        key: str = "",
        cancelled: Callable[[], None] | None = None,
        line: str = "",
    ) -> Any:
        """Run `work(progress)`, then `done(result)`, `failed(error)`, or `cancelled()`.

        The last one is called if the user has cancelled it, not if it went out of date.
        """


class RunNow:
    """Runs work before `start` returns; errors nobody takes are raised."""

    def start(
        self,
        label: str,
        work: Callable[[Any], Any],
        done: Callable[[Any], None],
        failed: Callable[[Exception], None] | None = None,
        key: str = "",
        cancelled: Callable[[], None] | None = None,
        line: str = "",
    ) -> None:
        """See `Runner`."""
        try:
            result = work(no_progress)
        except Exception as error:
            if failed is None:
                raise
            failed(error)
        else:
            done(result)


def no_progress(fraction: float, text: str = "") -> None:
    """Take no notice."""
