"""Disks that fail or fill up at a chosen call, and processes that die at a chosen moment."""

from __future__ import annotations

import builtins
import contextlib
import errno
import io
import os
import select
import signal
import stat
import time
from collections.abc import Callable, Iterator
from pathlib import Path

DEATH = -1  # in place of an error number
NEEDING_SPACE = ("create", "write", "mkdir", "fsync")


class Disk:
    """Counts the calls that change the disk and lets the one of a number go wrong.

    A failing disk (EIO) does so once; a full one (ENOSPC) takes half of what is being written
    and from then on nothing that needs space; with DEATH the process is killed there.
    """

    def __init__(self, fault: int = 0, at: int = -1) -> None:
        self.fault, self.at = fault, at
        self.calls: list[str] = []

    def call(self, name: str) -> bool:
        """Whether this call goes wrong."""
        self.calls.append(name)
        number = len(self.calls) - 1
        if self.fault == errno.ENOSPC:
            return 0 <= self.at <= number and name in NEEDING_SPACE
        return number == self.at

    def fail(self) -> None:
        if self.fault == DEATH:
            os.kill(os.getpid(), signal.SIGKILL)
        raise OSError(self.fault, os.strerror(self.fault))

    @contextlib.contextmanager
    def in_place(self) -> Iterator[None]:
        """Put this disk under the functions through which Python writes."""
        originals = {n: getattr(os, n) for n in ("replace", "mkdir", "chmod", "fsync", "open")}
        plain = io.open

        def checked(name: str) -> Callable:
            def run(*args, **kwargs):
                reads = name == "open" and not args[1] & (os.O_WRONLY | os.O_RDWR)
                if not reads and self.call("create" if name == "open" else name):
                    self.fail()
                return originals[name](*args, **kwargs)

            return run

        def opened(file, mode="r", *args, **kwargs):
            if not set(mode) & set("wxa+") or _is_pipe(file):
                return plain(file, mode, *args, **kwargs)
            if self.call("create"):
                self.fail()
            stream = io.BufferedWriter(_File(self, file, mode.replace("b", "").replace("t", "")))
            return stream if "b" in mode else io.TextIOWrapper(stream, "utf-8")

        for name in originals:
            setattr(os, name, checked(name))
        io.open = builtins.open = opened
        try:
            yield
        finally:
            io.open = builtins.open = plain
            for name, original in originals.items():
                setattr(os, name, original)


def _is_pipe(file: object) -> bool:
    """Whether it is a pipe to another process, which is on no disk."""
    return isinstance(file, int) and stat.S_ISFIFO(os.fstat(file).st_mode)


class _File(io.FileIO):
    def __init__(self, disk: Disk, file, mode: str) -> None:
        super().__init__(file, mode)
        self.disk = disk

    def write(self, data) -> int:
        if self.disk.call("write"):
            super().write(bytes(data)[: len(data) // 2])
            self.disk.fail()
        return super().write(data)

    def close(self) -> None:
        wrong = not self.closed and self.disk.call("close")
        super().close()
        if wrong:
            self.disk.fail()


def die_in(work: Callable[[], None], after: float | None = None) -> None:
    """Run work in a child process until it dies of itself or is killed `after` seconds.

    The clock starts when the child does.
    """
    ready, started = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(started, b"x")
            work()
        finally:
            os._exit(1)
    select.select([ready], [], [])
    if after is not None:
        time.sleep(after)
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(ready), os.close(started)
    assert os.WIFSIGNALED(status), "the child ended before it was killed"


def tree(folder: Path) -> dict[str, bytes]:
    """Contents of all files below a folder."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def without_litter(found: dict[str, bytes]) -> dict[str, bytes]:
    """Leave out what a killed process cannot clear away: hidden files."""
    return {name: data for name, data in found.items() if not name.split("/")[-1].startswith(".")}


def assert_sentences(said: list[str], fault: int) -> None:
    """Check that a user was told of every failure in one line that names its cause."""
    assert said
    cause = os.strerror(fault).lower()
    assert all(cause in text.lower() and "\n" not in text for text in said), said
