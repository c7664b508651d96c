"""Compressed files (``.gz``): unpacked on reading within limits, compressed on writing.

A mesh whose file is ``wing.stl.gz`` is read as ``wing.stl`` would be. Written under a name that
ends in ``.gz`` it is compressed again; at rest with the very bytes it was read from.
"""

from __future__ import annotations

import gzip
import tempfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.files import at_once, read_bytes, write_bytes
from ffdstudio.meshes.mesh import Template

SUFFIX = ".gz"
MOST = 200  # times its size: no file of ours unpacks to more, save for small ones
SMALL = 1 << 20  # bytes to which even a small file may unpack


@dataclass(frozen=True, eq=False)
class Packed:
    """The template of a compressed file, with its bytes as they are on the disk."""

    template: Template
    raw: bytes
    content: bytes

    @property
    def original(self) -> Array:
        """(n, 3) coordinates as in the file."""
        return self.template.original

    def write(self, path: Path, points: Array) -> None:
        """Write the file unpacked; `write_packed` compresses it."""
        self.template.write(path, points)


def is_packed(path: Path) -> bool:
    """Whether a name is that of a compressed file."""
    return path.suffix.lower() == SUFFIX


def inner(path: Path) -> Path:
    """Name of a file without that it is compressed.

    Examples
    --------
    >>> inner(Path("wing.stl.gz")).name, inner(Path("wing.stl")).name
    ('wing.stl', 'wing.stl')
    """
    return path.with_suffix("") if is_packed(path) else path


def write_packed(template: Template | None, path: Path, write: Callable[[Path], None]) -> None:
    """Compress what `write` writes, to a path that ends in ``.gz``.

    Raises
    ------
    InputError
        If it writes more than one file: what a deck includes stays where it is.
    """
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / inner(path).name
        with at_once():
            write(plain)
        if len(list(Path(folder).iterdir())) != 1:
            raise InputError(f"{path}: a mesh of several files cannot be written compressed")
        data = read_bytes(plain, to_update=True)
    unchanged = isinstance(template, Packed) and template.content == data
    write_bytes(path, template.raw if unchanged else packed(data))  # type: ignore[union-attr]


def unpacked(path: Path, raw: bytes) -> bytes:
    """Content of a compressed file, of all its members if it is made of several.

    Raises
    ------
    InputError
        If it is damaged, or unpacks to more than any mesh does.
    """
    parts, left = [], raw
    most = max(MOST * len(raw), SMALL) + 1
    while left:
        unpacker = zlib.decompressobj(wbits=31)
        try:
            parts.append(unpacker.decompress(left, most))
        except zlib.error as error:
            raise InputError(f"{path}: damaged compression ({error})") from None
        if not unpacker.eof:
            left_over = bool(unpacker.unconsumed_tail)
            cause = "unpacks to an impossible size" if left_over else "ends too early"
            raise InputError(f"{path}: damaged compression (it {cause})")
        most -= len(parts[-1])
        left = unpacker.unused_data.lstrip(b"\0")  # some writers fill up with zeros
        if most <= 0:
            raise InputError(f"{path}: damaged compression (it unpacks to an impossible size)")
    return b"".join(parts)


def packed(data: bytes) -> bytes:
    """Compress without a time stamp, as OpenFOAM does."""
    return gzip.compress(data, mtime=0)
