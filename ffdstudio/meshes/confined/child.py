"""What the process does that reads and writes through meshio.

1. Limits first: processor time, and memory beyond what the imports take.
2. From then on it may read below the folder of its file, and Python's own modules; nothing is
   written but a draft in a folder of its own, nothing started, nobody called.
3. What meshio prints goes nowhere; standard output belongs to the answer.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import threading
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

from ffdstudio.aliases import AnyArray
from ffdstudio.meshes.confined import wire

MEMORY, MEMORY_A_BYTE = 200_000_000, 20
FORBIDDEN = ("subprocess.", "os.exec", "os.posix_spawn", "os.spawn", "os.system", "socket.")
CHANGING = ("os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink", "os.mkdir", "os.chmod")


class Forbidden(Exception):
    """The file wants something that reading a mesh never takes."""


def main() -> NoReturn:
    """Answer one message, then end."""
    out, feed = _streams()
    _end_with_parent_of_linux()
    import meshio

    _ = meshio.Mesh
    out.write(b"ready\n")
    out.flush()
    message = feed.read(int.from_bytes(feed.read(8), "big"))
    threading.Thread(target=_end_with, args=(feed,), daemon=True).start()
    with contextlib.suppress(BrokenPipeError):
        out.write(_answer(message))
        out.flush()
    os._exit(0)


def _streams() -> tuple[BinaryIO, BinaryIO]:
    """Pipes to the parent; whatever is printed from now on goes nowhere."""
    out, feed = os.fdopen(os.dup(1), "wb"), os.fdopen(os.dup(0), "rb")
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nothing, descriptor)
    sys.stdin = open(0, closefd=False)  # noqa: SIM115 - for good
    sys.stdout = sys.stderr = open(1, "w", closefd=False)  # noqa: SIM115
    return out, feed


def _end_with(feed: BinaryIO) -> None:
    feed.read()  # returns when nobody holds the other end any more
    os._exit(1)


def _end_with_parent_of_linux() -> None:
    """Let the kernel end us with the parent, even while a loop in C runs."""
    if sys.platform.startswith("linux"):
        import ctypes

        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(1, 9)  # PR_SET_PDEATHSIG, SIGKILL


def _answer(message: bytes) -> bytes:
    try:
        head, arrays = wire.unpacked(message)
        if sys.platform.startswith("linux") and os.getppid() != head["parent"]:
            os._exit(1)
        _limit(float(head["seconds"]), int(head["size"]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            done = {"read": read, "write": written}[head["do"]]
            return done(head, arrays)
    except MemoryError:
        return wire.packed({"error": "this file takes more memory than one of its size should"})
    except Forbidden as error:
        return wire.packed({"error": str(error)})
    except SystemExit:
        return wire.packed({"error": "no mesh format is known that reads this file"})
    except BaseException as error:
        return wire.packed({"error": _cause(error, Path(str(head.get("path", ""))))})


def _cause(error: BaseException, path: Path) -> str:
    """What meshio's reader stumbled over, in words for who does not know it."""
    words = str(error).strip().splitlines() or [type(error).__name__]
    if isinstance(error, UnicodeDecodeError) or "Could not deduce" in words[0]:
        return "no mesh format is known that reads this file"
    if isinstance(error, RecursionError):
        return "what is in this file is nested too deeply"
    return f"this file cannot be read as a {path.suffix or 'mesh'} file: {words[0][:200]}"


def _limit(seconds: float, size: int) -> None:
    """Processor time and memory, where the system can (not on Windows)."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        time = int(seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (time, time + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 40, 1 << 40))
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * os.sysconf("SC_PAGE_SIZE") + MEMORY + MEMORY_A_BYTE * size
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


# ---- reading -----------------------------------------------------------------------------------


def read(head: Mapping[str, Any], arrays: list[AnyArray]) -> bytes:
    """Mesh of a file as a message: arrays, and in JSON what each of them is."""
    import meshio

    path = Path(head["path"])
    if not arrays:
        _confine(path.parent)
        return described(meshio.read(path))
    with tempfile.TemporaryDirectory(prefix="ffdstudio-") as folder:  # unpacked for us
        path = Path(folder) / path.name
        path.write_bytes(arrays[0].tobytes())
        found = meshio.read(path)
    return described(found)


def described(found: Any) -> bytes:
    """A mesh of meshio as a message."""
    import numpy as np

    arrays: list[AnyArray] = [np.asarray(found.points, dtype=np.float64)]

    def put(values: Any) -> int:
        arrays.append(np.asarray(values, dtype=np.int64))
        return len(arrays) - 1

    blocks = [(str(block.type), put(block.data)) for block in found.cells]
    sets = {
        str(name): [None if chosen is None else put(chosen) for chosen in by_block]
        for name, by_block in found.cell_sets.items()
    }
    return wire.packed({"blocks": blocks, "sets": sets}, arrays)


def _confine(folder: Path) -> None:
    """Allow nothing from now on but to read what lies in a folder, and Python's own files."""
    home = os.path.realpath(folder)
    own = [os.path.realpath(place) for place in {sys.prefix, sys.base_prefix, *sys.path} if place]
    _guard_hdf5(home)

    def watch(event: str, args: tuple[Any, ...]) -> None:
        if event.startswith(FORBIDDEN) or event.startswith(CHANGING):
            raise Forbidden(f"reading this file would {event}, which no mesh needs")
        if event == "open" and isinstance(args[0], str | bytes | os.PathLike):
            _check_open(os.fsdecode(args[0]), args[1], args[2], home, own)

    sys.addaudithook(watch)


def _check_open(name: str, mode: Any, flags: Any, home: str, own: list[str]) -> None:
    writes = set(str(mode or "")) & set("wax+") or (
        isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR)
    )
    real = os.path.realpath(name)
    if writes and real != os.path.realpath(os.devnull):
        raise Forbidden(f"reading this file would write {name}")
    if not any(_is_below(real, place) for place in (home, *own)):
        raise Forbidden(f"this file refers to {name}, outside its folder, which is not opened")


def _is_below(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder.rstrip(os.sep) + os.sep)


def _guard_hdf5(home: str) -> None:
    """HDF5 opens files past Python: look at their names, and at where their data lies."""
    try:
        import h5py
    except ImportError:
        return
    plain = h5py.File.__init__

    def checked(self: Any, name: Any, *args: Any, **options: Any) -> None:
        if not isinstance(name, str | bytes | os.PathLike):  # one that is open already
            plain(self, name, *args, **options)
            return
        shown = os.fsdecode(name)
        if not _is_below(os.path.realpath(shown), home):
            raise Forbidden(f"this file refers to {shown}, outside its folder")
        plain(self, name, *args, **options)
        if self.id.links.visit(_leads_out, info=True) or self.visititems(_lies_outside):
            raise Forbidden("data of this file lies in another file, which is not opened")

    h5py.File.__init__ = checked


def _leads_out(name: Any, link: Any) -> bool | None:
    """Whether a link leads into another file; None goes on looking."""
    import h5py

    return True if link.type == h5py.h5l.TYPE_EXTERNAL else None


def _lies_outside(name: Any, item: Any) -> bool | None:
    """Whether the data of a dataset lies in another file."""
    outside = getattr(item, "external", None) or getattr(item, "is_virtual", False)
    return True if outside else None


# ---- writing -----------------------------------------------------------------------------------


def written(head: Mapping[str, Any], arrays: list[AnyArray]) -> bytes:
    """Content of a new file of a mesh: one array of bytes."""
    import meshio
    import numpy as np

    cells = [(str(kind), arrays[number]) for kind, number in head["blocks"]]
    mesh = meshio.Mesh(arrays[0], cells)
    with tempfile.TemporaryDirectory(prefix="ffdstudio-") as folder:
        draft = Path(folder) / "draft"
        mesh.write(draft, file_format=head["format"])
        data = draft.read_bytes()
    return wire.packed({}, [np.frombuffer(data, dtype=np.uint8)])
