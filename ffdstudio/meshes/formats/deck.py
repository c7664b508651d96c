"""Nastran's cards: lines of small (8), large (16) and free fields, read many at a time.

1. Every line becomes a row of fields, padded with blanks; free fields are cut at commas. Lines
   are told apart by their first eight characters, without a loop over them.
2. Nastran's reals may drop the E of the exponent: ``6.22-15`` is 6.22e-15. A blank is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.table import first_wrong, numbers
from ffdstudio.meshes.topology import Array, Indices

Letters = NDArray[np.uint8]
BLANK = 32
WIDTH = 16


@dataclass(frozen=True, eq=False)
class Deck:
    """The lines of one file."""

    source: Source

    @cached_property
    def letters(self) -> Letters:
        """Bytes of the file with a margin to read lines that are too short."""
        return np.frombuffer(self.source.data + b"\n" * 100, dtype=np.uint8)

    @cached_property
    def begins(self) -> Indices:
        """Where the lines begin, and the end of the file."""
        size = len(self.source.data)
        ends = np.flatnonzero(self.letters[:size] == 10) + 1
        last = [] if len(ends) and ends[-1] == size else [size]
        return np.concatenate([[0], ends, last]).astype(np.int64)

    @cached_property
    def heads(self) -> Letters:
        """(lines, 8) first characters in capitals, blanks from the line's end or a comma on."""
        text = self.columns(np.arange(len(self.begins) - 1), 0, 8)
        text = np.where((text >= 97) & (text <= 122), text - 32, text)
        cut = np.logical_or.accumulate((text == ord(",")) | (text == 9), axis=1)
        return np.where(cut, BLANK, text).astype(np.uint8)

    @cached_property
    def codes(self) -> NDArray[np.uint64]:
        """(lines,) heads as one number each, quick to compare."""
        return np.ascontiguousarray(self.heads).view(np.uint64)[:, 0]

    @cached_property
    def is_free(self) -> NDArray[np.bool_]:
        """Lines with a comma among their first fields."""
        found = np.zeros(len(self.begins) - 1, dtype=bool)
        commas = np.flatnonzero(self.letters == ord(","))
        lines = np.searchsorted(self.begins, commas, side="right") - 1
        found[lines[commas - self.begins[lines] < 24]] = True
        return found

    def columns(self, lines: Indices, begin: int, end: int) -> Letters:
        """(lines, columns) characters, blanks behind the end of a line."""
        place = self.begins[lines][:, None] + np.arange(begin, end)
        found = self.letters[np.minimum(place, len(self.letters) - 1)]
        over = np.logical_or.accumulate((found == 10) | (found == 13) | (found == ord("$")), axis=1)
        outside = place >= self.begins[lines + 1][:, None]
        return np.where(over | outside, BLANK, found).astype(np.uint8)

    def cards(self, name: str, star: bool = False) -> Indices:
        """Lines that begin with this name, or with it and a star for large fields."""
        wanted = np.frombuffer((name + "*" * star).ljust(8).encode(), dtype=np.uint64)
        return np.flatnonzero(self.codes == wanted)

    def is_continuation(self, lines: Indices) -> NDArray[np.bool_]:
        """Whether lines go on with the card before them."""
        inside = lines < len(self.begins) - 1
        head = self.heads[np.minimum(lines, len(self.begins) - 2)]
        begins = np.isin(head[:, 0], [ord("+"), ord("*")]) | (head == BLANK).all(axis=1)
        return inside & begins

    def fields(self, lines: Indices, large: bool = False) -> Letters:
        """(lines, fields, 16) characters of the fields behind the name: 8 small or 4 large."""
        width = 16 if large else 8
        many = 64 // width
        text = self.columns(lines, 8, 72).reshape(len(lines), many, width)
        if np.any((text == 9) & ~self.is_free[lines][:, None, None]):
            bad = np.flatnonzero((text == 9).any(axis=(1, 2)) & ~self.is_free[lines])[0]
            raise self.source.error(int(self.begins[lines[bad]]), "tabs between fields")
        padded = np.full((len(lines), many, WIDTH), BLANK, dtype=np.uint8)
        padded[:, :, :width] = text
        for row in np.flatnonzero(self.is_free[lines]):
            padded[row] = self._free(int(lines[row]), many)
        return padded

    def _free(self, line: int, many: int) -> Letters:
        text = self.source.data[self.begins[line] : self.begins[line + 1]].split(b"$")[0]
        words = [word.strip() for word in text.split(b",")[1 : many + 1]]
        long = [word for word in words if len(word) > WIDTH]
        if long:
            raise self.source.error(int(self.begins[line]), f"field {long[0][:20]!r} is too long")
        joined = b"".join(word.ljust(WIDTH) for word in words).ljust(many * WIDTH)
        return np.frombuffer(joined, dtype=np.uint8).reshape(many, WIDTH)


def integers(deck: Deck, lines: Indices, fields: Letters) -> Indices:
    """Whole numbers of fields (k, 16), 0 for a blank; `lines` says where errors are."""
    return _parsed(deck, lines, _filled(fields), np.int64)


def reals(deck: Deck, lines: Indices, fields: Letters) -> Array:
    """Reals of fields (k, 16), 0 for a blank."""
    text = _filled(fields)
    before = np.concatenate([np.full((len(text), 1), BLANK), text[:, :-1]], axis=1)
    sign = (text == ord("+")) | (text == ord("-"))
    digit = ((before >= 48) & (before <= 57)) | (before == ord("."))
    wide = np.zeros((*text.shape, 2), dtype=np.uint8)
    wide[:, :, 0] = np.where(sign & digit, ord("e"), 0)
    wide[:, :, 1] = text
    return _parsed(deck, lines, wide.reshape(len(text), 2 * text.shape[1]), np.float64)


def _filled(fields: Letters) -> Letters:
    """Fields with a zero where they are blank."""
    text = fields.copy()
    text[text == 0] = ord("?")  # no byte of a text, and a gap further below
    text[(text == BLANK).all(axis=1), 0] = ord("0")
    return text


def _parsed(deck: Deck, lines: Indices, text: Letters, dtype: type) -> NDArray:
    if not len(text):
        return np.empty(0, dtype=dtype)
    rows = np.concatenate([text, np.full((len(text), 1), 10, dtype=np.uint8)], axis=1)
    values = numbers(rows[rows != 0].tobytes(), dtype)
    if values is None or len(values) != len(text) or not np.isfinite(values).all():
        bad = first_wrong(len(rows), lambda i, j: rows[i:j][rows[i:j] != 0].tobytes(), dtype)
        shown = text[bad][text[bad] != 0].tobytes().decode("latin-1").strip()
        place = int(deck.begins[lines[bad]])
        raise deck.source.error(place, f"expected a number in a field, found {shown!r}")
    return values
