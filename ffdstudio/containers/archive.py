"""A zip of named entries, read with suspicion.

1. A name must be a plain relative path: nothing is ever written outside the place it is for.
2. The sizes an archive declares are bounded before anything is unpacked (zip bombs);
   zipfile never yields more than an entry declares, and checks its CRC.
3. The same entries give the same bytes: no clock, no user, no order by chance.
"""

from __future__ import annotations

import io
import stat
import zipfile
import zlib

from ffdstudio.errors import InputError

MAX_ENTRIES = 100_000
MAX_BYTES = 64 * 2**30
# deflate reaches 1030 : 1 on constant data; an honest array of zeros must pass while small
MAX_RATIO, ALWAYS_FINE = 200, 2**30


def pack(entries: dict[str, bytes]) -> bytes:
    """Return the zip of the entries.

    Examples
    --------
    >>> unpack(pack({"a/b.txt": b"hello"}), "x.zip")
    {'a/b.txt': b'hello'}
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for name, data in entries.items():
            archive.writestr(_info(name), data)
    return stream.getvalue()


def _info(name: str) -> zipfile.ZipInfo:
    info = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
    info.compress_type = zipfile.ZIP_DEFLATED
    info.external_attr = 0o644 << 16
    info.create_system = 3
    return info


def unpack(data: bytes, name: str) -> dict[str, bytes]:
    """Return all entries of a zip; `name` is what the file is called in messages.

    Raises
    ------
    InputError
        If it is no zip, is damaged, names paths outside itself or would unpack to
        absurd sizes.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = [info for info in archive.infolist() if not info.filename.endswith("/")]
            _check(infos, len(data), name)
            return {info.filename: archive.read(info) for info in infos}
    except InputError:  # is a ValueError too
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError) as error:
        raise InputError(f"{name}: damaged or no project file ({error})") from None
    except (NotImplementedError, RuntimeError):  # encrypted, or an exotic compression
        raise InputError(f"{name}: packed in a way that a project file never is") from None
    except (OSError, ValueError, OverflowError, MemoryError):  # offsets that point nowhere
        raise InputError(f"{name}: damaged or no project file") from None


def _check(infos: list[zipfile.ZipInfo], packed: int, name: str) -> None:
    if len(infos) > MAX_ENTRIES:
        raise InputError(f"{name}: holds {len(infos)} entries, more than a project ever has")
    names = [info.filename for info in infos]
    if len(set(names)) < len(names):
        raise InputError(f"{name}: holds an entry twice")
    for entry in names:
        if not is_plain(entry):
            raise InputError(f"{name}: holds an entry that leaves its folder: {entry!r}")
    if any(stat.S_ISLNK(info.external_attr >> 16) for info in infos):
        raise InputError(f"{name}: holds a symbolic link, which no project does")
    total = sum(info.file_size for info in infos)
    if total > max(ALWAYS_FINE, min(MAX_BYTES, MAX_RATIO * packed)):
        raise InputError(f"{name}: would unpack to {total} bytes, which no project does")


def is_plain(path: str) -> bool:
    """Whether a name stays below the folder it is put into, on every system.

    Every part between two slashes has to be a name: an empty one would make the rest absolute
    as soon as someone cuts the front off.

    Examples
    --------
    >>> [is_plain(p) for p in ("a/b", "../b", "/b", "c:b", "a|b".replace("|", chr(92)), "")]
    [True, False, False, False, False, False]
    >>> is_plain("meshes/0//etc/passwd"), is_plain("a/./b"), is_plain("a/ /b")
    (False, False, False)
    """
    parts = path.split("/")
    odd = any(letter in path for letter in "\\:") or not path.isprintable()
    return not odd and not any(part.strip(" .") == "" for part in parts)
