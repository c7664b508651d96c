"""The bytes of a file together with its name: places in it become line numbers in messages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ffdstudio.errors import InputError


@dataclass(frozen=True, eq=False)
class Source:
    """A file that is being read."""

    path: Path
    data: bytes

    def line(self, offset: int) -> int:
        """Line number, from 1, of the byte at `offset`."""
        return self.data.count(b"\n", 0, offset) + 1

    def error(self, offset: int, message: str) -> InputError:
        """Make the error to raise for the text at `offset`."""
        return InputError(f"{self.path}, line {self.line(offset)}: {printable(message)}")

    def failure(self, message: str) -> InputError:
        """Make the error to raise for the file as a whole."""
        return InputError(f"{self.path}: {printable(message)}")

    def line_end(self, offset: int) -> int:
        """Offset behind the line break of the line at `offset`."""
        found = self.data.find(b"\n", offset)
        return len(self.data) if found < 0 else found + 1

    def integer(self, token: bytes, offset: int, what: str, least: int = 0) -> int:
        """Return a count or index from the text, at least `least`."""
        try:
            value = int(token)
        except ValueError:
            shown = token[:20].decode("latin-1")
            raise self.error(offset, f"{what} must be a whole number, not {shown!r}") from None
        if not least <= value < 2**62:
            raise self.error(offset, f"{what} must be at least {least}, not {value}")
        return value


def printable(text: str) -> str:
    r"""Text from a damaged file without what would break a line or a terminal.

    Examples
    --------
    >>> printable("two\nlines \x07")
    'two lines ?'
    """
    return "".join(letter if letter.isprintable() else "?" for letter in " ".join(text.split()))


def decoded(text: bytes) -> str:
    """Name from a file: UTF-8 or, where it is not, the western letters of one byte.

    Examples
    --------
    >>> decoded("Flügel".encode()), decoded("Flügel".encode("latin-1"))
    ('Flügel', 'Flügel')
    """
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("cp1252", "replace")
