"""Reading and writing files so that a failure never damages what is there.

1. A file is written under a temporary name in its own folder and renamed: whoever looks
   sees the old file or the new one, never half of one.
2. The data is flushed to the disk before the rename, the folder after it (fsync).
3. Every failure becomes an `InputError` that names the file, and leaves no litter. What a
   killed process left is removed when the same file is written again: temporary names tell
   the machine and process they belong to.
4. A symbolic link stays one, its target is replaced. A device or a pipe (/dev/stdout)
   cannot be replaced, so it is written straight away. A file that its owner has made
   read-only is refused, though a rename would get past it.
5. Files that belong together (a deck and what it includes, all meshes of a morph) are all
   written before the first of them is renamed; should a rename fail, those before it are put
   back. Until then they have a second name, so that putting back needs neither memory nor room.
6. Within `sources_kept`, which the command line puts around every command, a file that was read
   is not written: neither under its own name nor through a link, as what file it ever was read.
"""

from __future__ import annotations

import contextlib
import errno
import os
import platform
import re
import secrets
import shutil
import stat
import time
import zlib
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from ffdstudio.errors import InputError

STALE = 3600.0  # seconds after which nobody writes on
Staged = list[tuple[Path, Path | None]]  # target, and the file to be renamed to it; None: removed
_waiting: ContextVar[Staged | None] = ContextVar("waiting", default=None)
_sources: ContextVar[set[tuple[int, int]] | None] = ContextVar("sources", default=None)


def read_bytes(path: str | os.PathLike[str], to_update: bool = False) -> bytes:
    """Return the content of a file.

    Parameters
    ----------
    path : path-like
    to_update : bool
        Whether the file is one that will be written, and so is no source (see `sources_kept`).

    Raises
    ------
    InputError
        If the file cannot be read, or is a pipe or device, which may never end; the message
        names it and the cause.
    """
    try:
        status = Path(path).stat()
        if not stat.S_ISREG(status.st_mode) and not stat.S_ISDIR(status.st_mode):
            raise OSError("it is neither a file nor a folder")
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read {os.fspath(path)!r}: {_cause(error)}") from error
    sources = _sources.get()
    if sources is not None and not to_update:
        sources.add((status.st_dev, status.st_ino))
    return data


@contextlib.contextmanager
def sources_kept() -> Iterator[None]:
    """Within it no file is overwritten or removed that was read within it.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> mesh = pathlib.Path(tempfile.mkdtemp()) / "a.su2"
    >>> write_bytes(mesh, b"abc")
    >>> with sources_kept():
    ...     data = read_bytes(mesh)
    ...     is_source(mesh)
    True
    >>> is_source(mesh)
    False
    """
    token = _sources.set(set())
    try:
        yield
    finally:
        _sources.reset(token)


def is_source(path: str | os.PathLike[str]) -> bool:
    """Whether a file, under whatever name, was read within `sources_kept`."""
    try:
        status = Path(path).stat()
    except (OSError, ValueError):
        return False
    return (status.st_dev, status.st_ino) in (_sources.get() or ())


Stamp = tuple[int, int, int]


def stamp(path: str | os.PathLike[str]) -> Stamp | None:
    """Return what changes whenever a file is replaced or written on; None without a file.

    Whoever read a file under one stamp and means to replace it under another one asks first:
    somebody else has been there.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "a.txt"
    >>> write_bytes(path, b"abc")
    >>> before = stamp(path)
    >>> write_bytes(path, b"abc")
    >>> stamp(path) == before
    False
    """
    try:
        status = Path(path).stat()
    except (OSError, ValueError):
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns


def refuse_source(path: str | os.PathLike[str]) -> None:
    """Raise `InputError` if a file was read within `sources_kept`: before the work, not after."""
    if is_source(path):
        raise InputError(f"{os.fspath(path)}: this would overwrite a file that is read")


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Replace a file by `data`, atomically and durably.

    Raises
    ------
    InputError
        If the file cannot be written (no such folder, no permission, disk full); an
        existing file is then left as it was.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> target = pathlib.Path(tempfile.mkdtemp()) / "a.txt"
    >>> write_bytes(target, b"abc")
    >>> target.read_bytes()
    b'abc'
    """
    with _failure_named(path):
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            target.write_bytes(data)
            return
    write_together([(path, data)])


def write_together(files: Iterable[tuple[str | os.PathLike[str], bytes]]) -> None:
    """Replace files that belong together: all of them or, should one fail, none.

    Only a process that dies between two of the renames, which follow each other at once,
    leaves some of them new.

    Raises
    ------
    InputError
        If one cannot be written; the message names it.
    """
    with together() as staged:
        for path, data in files:
            with _failure_named(path):
                _stage(Path(os.path.realpath(path)), data, staged)


def remove(path: str | os.PathLike[str]) -> None:
    """Remove a file, if it is there; within `together` when all others are in place.

    Raises
    ------
    InputError
        If it cannot be removed.
    """
    refuse_source(path)
    with together() as staged:
        staged.append((Path(path), None))


@contextlib.contextmanager
def together() -> Iterator[Staged]:
    """Hold back what is written inside: in the end all of it is put in place, or nothing.

    What is held back lies on the disk already, not in memory. A pipe or device is written at once.

    Raises
    ------
    InputError
        If one of the files cannot be put in place; the message names it.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> target = pathlib.Path(tempfile.mkdtemp()) / "a.txt"
    >>> with together():
    ...     write_bytes(target, b"abc")
    ...     print(target.exists())
    False
    >>> target.exists()
    True
    """
    outer = _waiting.get()
    if outer is not None:
        before = len(outer)
        try:
            yield outer
        except BaseException:
            _clear(temporary for _, temporary in outer[before:])
            del outer[before:]
            raise
        return
    staged: Staged = []
    token = _waiting.set(staged)
    try:
        yield staged
        _put(staged)
    finally:  # an interrupt leaves no litter either
        _waiting.reset(token)
        _clear(temporary for _, temporary in staged)
    for folder in {target.parent for target, _ in staged}:
        _flush_folder(folder)


@contextlib.contextmanager
def at_once() -> Iterator[None]:
    """Put in place what is written inside as soon as it is, whatever `together` holds back."""
    token = _waiting.set(None)
    try:
        yield
    finally:
        _waiting.reset(token)


def _stage(target: Path, data: bytes, staged: Staged) -> None:
    """Write the data beside its target, under a temporary name that `staged` remembers."""
    refuse_source(target)
    mode = _mode_to_keep(target)
    with contextlib.suppress(OSError, ValueError):
        _remove_litter(target)
    temporary = _name_beside(target)
    # what takes the place of another file is nobody else's until it has that one's mode
    temporary.touch(0o666 if mode is None else 0o600, exist_ok=False)
    staged.append((target, temporary))
    if mode is not None:
        temporary.chmod(mode)
    with temporary.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def _remove_litter(target: Path) -> None:
    """Remove temporary files of a target whose process is no more."""
    ours = re.compile(rf"\.{re.escape(target.name[:40])}\.([0-9a-f]{{8}})\.(\d+)\.[0-9a-f]{{8}}")
    with os.scandir(target.parent) as entries:
        found = [(entry, match) for entry in entries if (match := ours.fullmatch(entry.name))]
    for entry, match in found:
        with contextlib.suppress(OSError):
            is_dead = match[1] == _machine() and not _is_alive(int(match[2]))
            if is_dead or time.time() - entry.stat().st_mtime > STALE:
                Path(entry.path).unlink()


def _machine() -> str:
    """Mark of this machine: numbers of processes mean nothing on another one."""
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _is_alive(process: int) -> bool:
    if os.name == "nt":  # where asking would end it
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # of another user
        return True
    return True


def _name_beside(target: Path) -> Path:
    owner = f"{_machine()}.{os.getpid()}"
    return target.with_name(f".{target.name[:40]}.{owner}.{secrets.token_hex(4)}")


def _put(staged: Staged) -> None:
    """Rename all; a single file needs nothing kept to be put back."""
    if len(staged) == 1:
        with _failure_named(staged[0][0]):
            _replace(*staged[0])
        return
    kept: list[tuple[Path, Path | None]] = []
    try:
        for target, temporary in staged:
            with _failure_named(target):
                kept.append((target, _second_name(target)))
                _replace(target, temporary)
    except BaseException:
        for target, old in reversed(kept):
            with contextlib.suppress(OSError):
                _replace(target, old)
        raise
    finally:
        _clear(old for _, old in kept)


def _replace(target: Path, other: Path | None) -> None:
    if other is None:
        target.unlink(missing_ok=True)
    else:
        other.replace(target)


def _second_name(target: Path) -> Path | None:
    """Another name of a file that is to be replaced; a copy where a disk knows no second names."""
    if not target.exists():
        return None
    name = _name_beside(target)
    try:
        os.link(target, name)
    except OSError:
        try:
            name.touch(0o600, exist_ok=False)
            shutil.copy2(target, name)
        except BaseException:
            _clear([name])
            raise
    return name


def _clear(temporary: Iterable[Path | None]) -> None:
    for path in temporary:
        if path is not None:
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)


@contextlib.contextmanager
def _failure_named(path: str | os.PathLike[str]) -> Iterator[None]:
    try:
        yield
    except InputError:  # is a ValueError too
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"cannot write {os.fspath(path)!r}: {_cause(error)}") from error


def _mode_to_keep(target: Path) -> int | None:
    """Permissions of the file that is replaced; a new file takes what the umask gives."""
    if not target.exists():
        return None
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return target.stat().st_mode & 0o777


def _flush_folder(folder: Path) -> None:
    """Make the rename durable where the system can (not on Windows, not on every network disk).

    It has happened already, so that a failure here is no failure to write.
    """
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _cause(error: OSError | ValueError) -> str:
    return (getattr(error, "strerror", None) or str(error)).lower()
