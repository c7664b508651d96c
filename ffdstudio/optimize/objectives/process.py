"""A program with a time limit, that can be stopped, and leaves no process behind.

1. It leads a process group of its own: what it has started, a solver behind a shell script for
   example, ends with it when it takes too long or the study is stopped.
2. A group of its own hears no Ctrl-C from the terminal, so whatever interrupts the wait ends it.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from ffdstudio.optimize.control import Stopped

POLL = 0.1  # seconds between two looks at whether the study is stopped


def run_program(
    command: Sequence[str], place: Path, limit: float, stopped: Callable[[], bool]
) -> int:
    """Run a program in a folder, its output in ``output.txt``; returns its status.

    Raises
    ------
    TimeoutError
        If it takes longer than `limit` seconds.
    Stopped
        If `stopped` says so before it has ended.
    OSError
        If it cannot be started.
    """
    with (place / "output.txt").open("wb") as output:
        process = subprocess.Popen(
            list(command), cwd=place, stdin=subprocess.DEVNULL, stdout=output,
            stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
    try:
        return _waited(process, time.monotonic() + limit, stopped)
    except BaseException:  # see 2
        _end_group(process)
        raise


def _waited(process: subprocess.Popen[bytes], end: float, stopped: Callable[[], bool]) -> int:
    while True:
        left = end - time.monotonic()
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.wait(max(0.0, min(POLL, left)))
        if stopped():
            raise Stopped
        if left <= 0:
            raise TimeoutError


def _end_group(process: subprocess.Popen[bytes]) -> None:
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()
