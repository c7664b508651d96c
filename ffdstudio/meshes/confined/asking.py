"""Asking a process of its own to read or write through meshio, and ending it in time.

1. A reader that hangs, prints, takes all memory or calls ``sys.exit`` does so in there. The
   process has a limit of processor time and one of memory by the size of the file, and one of
   wall time; whoever waits may cancel by an exception of `progress`.
2. It ends with us: it holds the other end of a pipe that the system closes when we die, by
   whatever signal, and on Linux the kernel ends it too.
3. It is started by ``python -P -c``: no module beside the mesh is taken for one of ours, the
   user's own script is not run again, and no module that is loaded here is forked. A frozen
   program starts itself with a word that `__main__` knows.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ffdstudio.aliases import AnyArray
from ffdstudio.errors import InputError
from ffdstudio.meshes.confined import wire

WORD = "--read-in-a-process-of-its-own"
SECONDS, SECONDS_A_MEGABYTE = 2.0, 4.0  # of processor time
PATIENCE = 4.0  # times as long by the clock: others want the processor as well
STARTING = 60.0  # seconds for the imports, on a busy machine
POLL = 0.02
READY = b"ready\n"

Answer = tuple[dict[str, Any], list[AnyArray]]


def ask(
    path: Path,
    head: dict[str, Any],
    arrays: list[AnyArray],
    size: int,
    progress: Callable[[float], None],
) -> Answer:
    """Return what the process answers.

    Parameters
    ----------
    path : pathlib.Path
        The file it is about, for messages.
    head, arrays
        The message; see `child`.
    size : int
        Bytes of the file: what time and memory it may take.
    progress : callable
        Called while we wait, in this thread; an exception of it ends the process.

    Raises
    ------
    InputError
        If it cannot be started, takes too long or too much memory, or says what is wrong.
    """
    limit = SECONDS + SECONDS_A_MEGABYTE * size / 1e6
    process = _started(path)
    try:
        head = {**head, "seconds": limit, "size": size, "parent": os.getpid()}
        answer = _exchanged(process, path, wire.packed(head, arrays), limit, progress)
    finally:
        _ended(process)
    try:
        said, found = wire.unpacked(answer)
    except (ValueError, MemoryError):
        raise InputError(f"{path}: {_cause(process.returncode, limit)}") from None
    if "error" in said:
        raise InputError(f"{path}: {said['error']}")
    return said, found


def command() -> list[str]:
    """How the process is started."""
    if getattr(sys, "frozen", False):
        return [sys.executable, WORD]
    home = os.fspath(Path(__file__).resolve().parents[3])
    code = (
        f"import sys; sys.path.insert(0, {home!r}); "
        "from ffdstudio.meshes.confined.child import main; main()"
    )
    return [sys.executable, "-P", "-c", code]


def _started(path: Path) -> subprocess.Popen[bytes]:
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    try:
        return subprocess.Popen(
            command(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            cwd=Path(path.anchor or os.sep), env=os.environ | one, start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )  # fmt: skip
    except OSError as error:
        raise InputError(
            f"{path}: cannot start the process that reads it: {(error.strerror or '').lower()}"
        ) from error


def _exchanged(
    process: subprocess.Popen[bytes],
    path: Path,
    message: bytes,
    limit: float,
    progress: Callable[[float], None],
) -> bytes:
    """Send the message and wait for the answer; threads of ours feed and drain the pipes."""
    assert process.stdin is not None
    assert process.stdout is not None
    out, feed = process.stdout, process.stdin
    ready, parts = threading.Event(), []

    def send() -> None:
        with contextlib.suppress(OSError, ValueError):  # it has died, or was ended
            feed.write(len(message).to_bytes(8, "big") + message)
            feed.flush()  # and left open: its end tells the process of ours

    def receive() -> None:
        with contextlib.suppress(OSError, ValueError):
            if out.readline(len(READY)) == READY:
                ready.set()
                while part := out.read(1 << 20):
                    parts.append(part)

    threads = [threading.Thread(target=work, daemon=True) for work in (send, receive)]
    for thread in threads:
        thread.start()
    began, waiting = time.monotonic(), STARTING
    while threads[1].is_alive():
        progress(0.1)
        if waiting == STARTING and ready.is_set():
            began, waiting = time.monotonic(), PATIENCE * limit
        if time.monotonic() - began > waiting:
            raise InputError(f"{path}: {_slow(limit)}")
        threads[1].join(POLL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(1.0)
    return b"".join(parts)


def _ended(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        with contextlib.suppress(OSError, ValueError):
            if stream is not None:
                stream.close()


def _cause(status: int | None, limit: float) -> str:
    if status in (-9, -24):  # killed, at the limit of processor time
        return _slow(limit)
    return f"reading this file failed (the process that reads it ended with status {status})"


def _slow(limit: float) -> str:
    return f"reading this file takes more than {limit:.0f} s, which a file of its size never does"
