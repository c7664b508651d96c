"""Which files a piece of work opens, and what else it does to the disk or starts."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHANGES = ("os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink", "os.mkdir", "os.truncate")
STARTS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "socket.connect")
_seen: list[tuple[str, str]] | None = None
_installed = False


def _watch(event: str, args: tuple[Any, ...]) -> None:
    """An audit hook: it can never be taken away again, so it is one for the whole process."""
    if _seen is None:
        return
    if event == "open" and isinstance(args[0], str | bytes | os.PathLike):
        _seen.append(("open", os.fsdecode(args[0])))
    elif event.startswith(CHANGES):
        relative = any(isinstance(a, int) and a >= 0 for a in args)  # to a folder that is open
        names = [os.fsdecode(a) for a in args if isinstance(a, str | bytes)]
        _seen.extend(("change", name) for name in names if not relative or name[:1] == os.sep)
    elif event.startswith(STARTS):
        _seen.append(("start", repr(args)[:500]))


@contextmanager
def watched() -> Iterator[list[tuple[str, str]]]:
    """Collect what is opened, changed and started within."""
    global _seen, _installed
    if not _installed:
        sys.addaudithook(_watch)
        _installed = True
    outer, _seen = _seen, []
    try:
        yield _seen
    finally:
        _seen = outer


def strayed(seen: list[tuple[str, str]], *folders: Path) -> list[tuple[str, str]]:
    """What of it lies outside some folders, Python's own files and its temporary ones aside."""
    home = [os.path.realpath(folder) for folder in folders]
    programs = os.environ.get("PATH", "").split(os.pathsep)  # one that a case names is hashed
    python = {sys.prefix, sys.base_prefix, *filter(None, [*sys.path, *programs])}
    python.add(os.fspath(Path(__file__).parents[2]))
    reading = [os.path.realpath(place) for place in python]
    odd = []
    for what, name in seen:
        if "__pycache__" in name or name == "/proc/cpuinfo":  # kernels that are compiled now
            continue
        if what == "start":
            if "meshes.confined.child" not in name:
                odd.append((what, name))
            continue
        real = os.path.realpath(name)
        drafts = os.path.join(os.path.realpath(tempfile.gettempdir()), "ffdstudio-")  # noqa: PTH118
        allowed = [*home, *(reading if what == "open" else [])]
        fine = real.startswith((drafts, "/proc/self/", "/sys/devices/system/cpu", os.devnull))
        if not fine and not any(real == f or real.startswith(f + os.sep) for f in allowed):
            odd.append((what, name))
    return odd
