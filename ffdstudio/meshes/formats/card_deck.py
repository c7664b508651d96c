"""Nastran's cards: lines of small (8), large (16) and free fields, read many at a time.

1. Every line becomes a row of fields, padded with blanks; free fields are cut at commas. Lines
   are told apart by their first eight characters, without a loop over them.
2. Comments and empty lines may stand between a card and its continuation. Nastran finds a
   continuation by its name wherever it stands; here it must be the next line, or is refused.
3. Nastran's reals may drop the E of the exponent: ``6.22-15`` is 6.22e-15. A blank is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import AnyArray, Array, Indices, Mask
from ffdstudio.errors import InputError
from ffdstudio.meshes.formats.nastran_lines import lines_of
from ffdstudio.meshes.formats.number_table import first_wrong, numbers
from ffdstudio.meshes.formats.source import Source

Letters = NDArray[np.uint8]
BLANK = 32
PLUS_OR_STAR = (43, 42)
WIDTH = 16


@dataclass(frozen=True, eq=False)
class Deck:
    """The lines of one file.

    `source` holds them with tabs expanded and repeated cards written out, `raw` is the file;
    ``spans[i]`` is where line i stands in it.
    """

    source: Source
    raw: bytes
    spans: Indices

    @classmethod
    def of(cls, source: Source) -> Deck:
        """Deck of a file."""
        text, spans = lines_of(source)
        return cls(Source(source.path, text), source.data, spans)

    def error(self, line: int, message: str) -> InputError:
        """Make the error to raise for a line."""
        return Source(self.source.path, self.raw).error(int(self.spans[line, 0]), message)

    def last_lines(self, lines: Indices, large: Mask) -> Indices:
        """(lines,) the last line of each GRID card; a GRID* without z has one line."""
        last = lines.copy()
        wide = np.flatnonzero(large)
        last[wide] = np.maximum(self.continuation(lines[wide], large[wide]), lines[wide])
        return last

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
        """(lines, 8) names in capitals: what stands before a comma, shifted to the left."""
        text = _capitals(self.columns(np.arange(len(self.begins) - 1), 0, 8))
        cut = np.logical_or.accumulate((text == ord(",")) | (text == 9), axis=1)
        heads = np.where(cut, BLANK, text).astype(np.uint8)
        late = np.flatnonzero((heads[:, 0] == BLANK) & (heads != BLANK).any(axis=1))
        if len(late):
            wide = np.concatenate([heads[late], np.full((len(late), 8), BLANK, np.uint8)], axis=1)
            places = np.argmax(heads[late] != BLANK, axis=1)[:, None] + np.arange(8)
            heads[late] = np.take_along_axis(wide, places, axis=1)
        return heads

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

    @cached_property
    def count(self) -> int:
        """Number of lines up to ENDDATA."""
        last = np.flatnonzero(self.codes == _code("ENDDATA"))
        return int(last[0]) if len(last) else len(self.codes)

    @cached_property
    def following(self) -> Indices:
        """(lines,) the next line that is no comment and not empty, `count` behind the last."""
        rows = np.arange(self.count)
        nameless = np.flatnonzero(self.codes[: self.count] == _code(""))
        rows[nameless[(self.columns(nameless, 0, 80) == BLANK).all(axis=1)]] = self.count
        after = np.minimum.accumulate(rows[::-1])[::-1]
        return np.append(after[1:], self.count)

    def cards(self, name: str, star: bool = False) -> Indices:
        """Lines that begin with this name, or with it and a star for large fields."""
        return np.flatnonzero(self.codes[: self.count] == _code(name + "*" * star))

    def continuation(self, lines: Indices, large: NDArray[np.bool_]) -> Indices:
        """(lines,) the lines that go on with these, -1 where none does.

        Raises
        ------
        InputError
            If a line names its continuation and another line follows it.
        """
        rows = self.following[lines]
        head = self.heads[np.minimum(rows, len(self.heads) - 1)]
        nameless = (head == BLANK).all(axis=1)
        goes_on = (np.isin(head[:, 0], PLUS_OR_STAR) | nameless) & (rows < self.count)
        names = self._names(lines, large)
        odd = (names != head).any(axis=1) & (names != BLANK).any(axis=1) & ~(goes_on & nameless)
        for row in np.flatnonzero(odd).tolist():
            wanted, found = names[row].tobytes(), head[row].tobytes()
            name, other = wanted.strip(b"+* "), found.strip(b"+* ")
            if goes_on[row] and (not name or other in (b"", name)):
                continue
            if goes_on[row] or wanted[0] in PLUS_OR_STAR or name in self._continued:
                shown = wanted.decode("latin-1").strip()
                raise self.error(
                    int(lines[row]),
                    f"the next line is not the continuation of this card, {shown}",
                )
        return np.where(goes_on, rows, -1)

    @cached_property
    def _continued(self) -> set[bytes]:
        """Names of all continuations."""
        found = self.heads[np.isin(self.heads[:, 0], PLUS_OR_STAR)]
        return {row.tobytes().strip(b"+* ") for row in np.unique(found, axis=0)}

    def _names(self, lines: Indices, large: NDArray[np.bool_]) -> Letters:
        """(lines, 8) names that lines give to their continuations, in capitals."""
        found = self.columns(lines, 72, 80)
        for row in np.flatnonzero(self.is_free[lines]).tolist():
            words = self._words(int(lines[row]))[5 if large[row] else 9 :]
            found[row] = np.frombuffer(words[0][:8].ljust(8) if words else b" " * 8, np.uint8)
        return _capitals(found)

    def _words(self, line: int) -> list[bytes]:
        """Words between the commas of a line, its name first."""
        text = self.source.data[self.begins[line] : self.begins[line + 1]].split(b"$")[0]
        return [word.strip() for word in text.split(b",")]

    def fields(self, lines: Indices, large: bool = False) -> Letters:
        """(lines, fields, 16) characters of the fields behind the name: 8 small or 4 large."""
        width = 16 if large else 8
        many = 64 // width
        text = self.columns(lines, 8, 72).reshape(len(lines), many, width)
        padded = np.full((len(lines), many, WIDTH), BLANK, dtype=np.uint8)
        padded[:, :, :width] = text
        for row in np.flatnonzero(self.is_free[lines]):
            padded[row] = self._free(int(lines[row]), many)
        return padded

    def _free(self, line: int, many: int) -> Letters:
        words = self._words(line)[1 : many + 1]
        long = [word for word in words if len(word) > WIDTH]
        if long:
            raise self.error(line, f"field {long[0][:20]!r} is too long")
        joined = b"".join(word.ljust(WIDTH) for word in words).ljust(many * WIDTH)
        return np.frombuffer(joined, dtype=np.uint8).reshape(many, WIDTH)


def _code(name: str) -> np.uint64:
    result: np.uint64 = np.frombuffer(name.ljust(8).encode(), dtype=np.uint64)[0]
    return result


def _capitals(text: Letters) -> Letters:
    return np.where((text >= 97) & (text <= 122), text - 32, text).astype(np.uint8)


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


def _parsed(deck: Deck, lines: Indices, text: Letters, dtype: type) -> AnyArray:
    if not len(text):
        return np.empty(0, dtype=dtype)
    rows = np.concatenate([text, np.full((len(text), 1), 10, dtype=np.uint8)], axis=1)
    values = numbers(rows[rows != 0].tobytes(), dtype)
    if values is None or len(values) != len(text) or not np.isfinite(values).all():
        bad = first_wrong(len(rows), lambda i, j: rows[i:j][rows[i:j] != 0].tobytes(), dtype)
        shown = text[bad][text[bad] != 0].tobytes().decode("latin-1").strip()
        raise deck.error(int(lines[bad]), f"expected a number in a field, found {shown!r}")
    return values
