"""What readers of plain-text lattice files share: words, numbers, the choice of one lattice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError


@contextmanager
def naming(name: str) -> Iterator[None]:
    """Put the file's name before the message of any `InputError` that lacks it.

    Examples
    --------
    >>> with naming("a.g2"):
    ...     raise InputError("degree 5 is too high")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: a.g2: degree 5 is too high
    """
    try:
        yield
    except InputError as error:
        message = str(error)
        raise InputError(message if message.startswith(name) else f"{name}: {message}") from None


def tokens(data: bytes, name: str) -> list[bytes]:
    """Words of a text file; raises `InputError` if it is empty or no text."""
    if b"\0" in data or not data.isascii():
        raise InputError(f"{name}: not a text file")
    words = data.split()
    if not words:
        raise InputError(f"{name}: the file is empty")
    return words


def integer(word: bytes, name: str, what: str) -> int:
    """Return a whole number written in digits."""
    if not word.lstrip(b"+-").isdigit() or len(word) > 18:
        raise InputError(f"{name}: {what} must be a whole number, got {shown(word)}")
    return int(word)


def real(word: bytes, name: str) -> float:
    """Return a finite number; Fortran's ``1.0D+00`` is understood.

    Examples
    --------
    >>> real(b"2.5D-01", "x.fmt")
    0.25
    """
    try:
        value = float(word.replace(b"D", b"E").replace(b"d", b"e"))
    except ValueError:
        raise InputError(f"{name}: {shown(word)} is no number") from None
    if not np.isfinite(value) or b"_" in word:
        raise InputError(f"{name}: {shown(word)} is no finite number")
    return value


def vector(words: Sequence[bytes], name: str) -> Array:
    """Return finite numbers, (n,)."""
    return np.array([real(word, name) for word in words], dtype=np.float64)


def chosen(names: Sequence[str], block: int | str | None, name: str, what: str) -> int:
    """Index of the lattice asked for: by index or name, the first by default.

    Examples
    --------
    >>> chosen(["WING", "TAIL"], "TAIL", "x.su2", "box")
    1
    """
    if block is None:
        return 0
    if isinstance(block, str) and block in names:
        return list(names).index(block)
    if str(block).isdecimal() and int(block) < len(names):
        return int(block)
    raise InputError(f"{name}: there is no {what} {block}; it has: {', '.join(names)}")


def shown(word: bytes) -> str:
    """Return a word as shown in a message: short and printable."""
    return repr(word[:30].decode("ascii", "replace"))
