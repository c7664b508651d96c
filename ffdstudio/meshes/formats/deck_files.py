"""Decks that include other files: read together, and written together beside each other.

1. An included file belongs to the deck and is written beside it under the same relative name.
2. An original is never overwritten unless the deck itself is.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_together
from ffdstudio.meshes.formats.source import Source


@dataclass(frozen=True, eq=False)
class DeckFile:
    """A file of a deck: its name as seen from the deck ("" for the deck itself)."""

    source: Source
    relative: str


@dataclass(frozen=True, eq=False)
class DeckTemplate:
    """A deck with its included files.

    Attributes
    ----------
    path : pathlib.Path
        Of the deck.
    original : numpy.ndarray
        (n, 3) coordinates, x y z.
    files : list of DeckFile
        The deck first.
    contents : callable
        Gives the content of every file for (n, 3) coordinates.
    warn : callable
        Called with the path written and the coordinates, to tell what they lose.
    """

    path: Path
    original: Array
    files: list[DeckFile]
    contents: Callable[[Array], list[bytes]]
    warn: Callable[[Path, Array], None]

    def patched(self, points: Array) -> bytes:
        """Content of the deck itself with these (n, 3) coordinates."""
        return self.contents(points)[0]

    def write(self, path: Path, points: Array) -> None:
        """Write the deck and, beside it, the files that it includes."""
        contents = self.contents(points)
        in_place = same(path, self.path)
        together: dict[Path, bytes] = {}
        for file, content in zip(self.files[1:], contents[1:], strict=True):
            own, relative = file.source, Path(file.relative)
            target = path.parent / relative
            outside = relative.is_absolute() or ".." in relative.parts
            if content != own.data and not in_place and (outside or same(target, own.path)):
                raise InputError(
                    f"nodes move in {own.path}, which the deck includes as {file.relative}: "
                    "write into another folder, or it would be overwritten"
                )
            target = own.path if outside else target
            if not in_place and same(target, own.path):
                continue  # an original in which nothing moves
            if not target.exists() or read_bytes(target, to_update=True) != content:
                _make(target.parent)
                together[target] = content
        write_together([*together.items(), (path, contents[0])])
        self.warn(path, points)


def same(one: Path, other: Path) -> bool:
    """Whether both paths lead to the same file."""
    return os.path.realpath(one) == os.path.realpath(other)


def located(deck: Path, own: Path, name: str) -> tuple[Path, str] | None:
    """An included file and its name as seen from the deck; names may be seen from `own`, too.

    None where there is no such file.
    """
    if (deck.parent / name).exists():
        return deck.parent / name, name
    beside = own.parent / name
    if beside.exists():
        return beside, os.path.relpath(beside, deck.parent)
    return None


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror}") from error
