"""Tables of numbers in text: parsed in bulk, with the place of every number.

1. Tokens and lines are found by comparing bytes, the numbers are parsed by NumPy; no line of
   the bulk passes through Python. Both counts must agree, so nothing is skipped unseen.
2. It goes through the text in blocks of whole lines: that keeps the intermediate arrays small
   and gives progress, and a place to cancel.
3. Comments are blanked out with spaces, so that places stay those of the file.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import DTypeLike

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.meshes.formats.source import Source

BLOCK = 1 << 22
_LONE_SIGN = re.compile(rb"[-+](?!\d)")
_FORTRAN = bytes.maketrans(b"dD", b"ee")


class Rows(NamedTuple):
    """Lines of white-space separated numbers.

    `values` has one entry a number, and so have `starts` and `ends`, its place in the file, where
    they were asked for. ``first[i]`` is the first number of line i and ``places[i]`` where it
    stands; ``first[-1]`` is the count of numbers. Lines without numbers do not count.
    """

    values: AnyArray
    first: Indices
    places: Indices
    starts: Indices
    ends: Indices

    def __len__(self) -> int:
        return len(self.first) - 1

    @property
    def widths(self) -> Indices:
        """Numbers in each line."""
        return np.diff(self.first)

    def columns(self, count: int, rows: Indices | slice = slice(None)) -> Indices:
        """(rows, count) places in `values` of the first numbers of lines."""
        return self.first[:-1][rows][:, None] + np.arange(count)

    def table(self) -> AnyArray | None:
        """All numbers as one (rows, width) array if every line has as many, else None."""
        widths = self.widths
        if len(widths) == 0 or (widths != widths[0]).any():
            return None
        return self.values.reshape(len(self), -1)


def read_rows(
    source: Source,
    begin: int,
    end: int,
    dtype: DTypeLike = np.float64,
    comment: bytes = b"",
    spans: bool = False,
    tick: Callable[[int], None] | None = None,
) -> Rows:
    """Parse the lines of numbers between two places of a text.

    Parameters
    ----------
    source : Source
    begin, end : int
        Places of whole lines.
    dtype : numpy.float64 or numpy.int64
    comment : bytes
        What follows this character in a line is skipped.
    spans : bool
        Whether to keep the place of every number.
    tick : callable, optional
        Called with the place reached.

    Raises
    ------
    InputError
        If something there is not a number of that type; the message names the line.
    """
    place = np.int32 if end < 2**31 else np.int64  # half the memory where it is enough
    parts: list[tuple[AnyArray, ...]] = []
    total = 0
    for at, block in _blocks(source.data, begin, end):
        values, starts, ends, first = _parse(source, at, _blanked(block, comment), dtype)
        kept = slice(None if spans else 0)
        where = [starts[first] + at, starts[kept] + at, ends[kept] + at]
        parts.append((values, first + total, *(w.astype(place) for w in where)))
        total += len(values)
        if tick:
            tick(at + len(block))
    if not parts:
        none = np.empty(0, dtype=np.int64)
        parts = [(none.astype(dtype), none, none, none, none)]
    parts.append((parts[0][0][:0], np.array([total]), *(part[:0] for part in parts[0][2:])))
    return Rows(*(np.concatenate([part[k] for part in parts]) for k in range(5)))


def split_tokens(data: bytes, separators: bytes = b"") -> tuple[Indices, Indices]:
    """Begin and end of everything between white space and `separators`."""
    solid = np.zeros(len(data) + 2, dtype=np.int8)
    text = np.frombuffer(data, dtype=np.uint8)
    np.greater(text, 32, out=solid[1:-1].view(bool))
    for separator in separators:
        solid[1:-1][text == separator] = 0
    return np.flatnonzero(solid[1:] > solid[:-1]), np.flatnonzero(solid[1:] < solid[:-1])


def _blocks(data: bytes, begin: int, end: int) -> Iterator[tuple[int, bytes]]:
    while begin < end:
        stop = end
        if end - begin > BLOCK:
            stop = data.find(b"\n", begin + BLOCK, end) + 1 or end
        yield begin, data[begin:stop]
        begin = stop


def _blanked(block: bytes, comment: bytes) -> bytes:
    if not comment or comment not in block:
        return block
    return re.sub(re.escape(comment) + rb"[^\n]*", lambda match: b" " * len(match[0]), block)


def _parse(
    source: Source, at: int, block: bytes, dtype: DTypeLike
) -> tuple[AnyArray, Indices, Indices, Indices]:
    starts, ends = split_tokens(block)
    first = line_firsts(block, starts)
    values = numbers(block, dtype) if len(starts) else np.empty(0, dtype=dtype)
    if values is None or len(values) != len(starts):
        _refuse(source, at, block, starts, ends, dtype)
    return values, starts, ends, first


def line_firsts(block: bytes, starts: Indices) -> Indices:
    """Index of the first token of every line that has one."""
    breaks = np.flatnonzero(np.frombuffer(block, dtype=np.uint8) == 10)
    first = np.searchsorted(starts, np.concatenate([[0], breaks]))
    return first[np.diff(np.append(first, len(starts))) > 0]


def pick_numbers(
    source: Source, starts: Indices, ends: Indices, dtype: DTypeLike = np.float64
) -> AnyArray:
    """Parse the numbers between the given places of a text, in the order of the file.

    Raises
    ------
    InputError
        If one of them is not a number of that type, or not finite.
    """
    if len(starts) == 0:
        return np.empty(0, dtype=dtype)
    low, high = int(starts[0]), int(ends[-1])
    inside = np.zeros(high - low + 1, dtype=np.int8)
    inside[starts - low] = 1
    inside[ends - low] -= 1
    np.cumsum(inside, out=inside)
    text = np.frombuffer(source.data, dtype=np.uint8, count=high - low, offset=low)
    block = np.where(inside[:-1], text, np.uint8(32)).tobytes()
    values = numbers(block, dtype)
    if values is None or len(values) != len(starts):
        _refuse(source, low, block, starts - low, ends - low, dtype)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise source.error(int(starts[bad[0]]), "a number is not finite")
    return values


def pick_anywhere(
    source: Source, starts: Indices, ends: Indices, dtype: DTypeLike = np.float64
) -> AnyArray:
    """As `pick_numbers`, for places of any shape in any order."""
    order = np.argsort(starts, axis=None, kind="stable")
    values = np.empty(starts.size, dtype=dtype)
    values[order] = pick_numbers(source, starts.ravel()[order], ends.ravel()[order], dtype)
    return values.reshape(starts.shape)


def _refuse(
    source: Source, at: int, block: bytes, starts: Indices, ends: Indices, dtype: DTypeLike
) -> NoReturn:
    bad = first_wrong(len(starts), lambda i, j: block[starts[i] : ends[j - 1]], dtype)
    shown = block[starts[bad] : ends[bad]][:20].decode("latin-1")
    kind = "number" if dtype == np.float64 else "whole number"
    raise source.error(at + int(starts[bad]), f"expected a {kind}, found {shown!r}")


def numbers(block: bytes, dtype: DTypeLike) -> AnyArray | None:
    """All numbers of a text, or None if there is anything else; 1.0D+00 is a number, too."""
    if not block.strip():  # NumPy finds a -1 in blanks
        return np.empty(0, dtype=dtype)
    if dtype != np.float64 and _has_lone_sign(block):  # and a number in "- 1"
        return None
    for change in (None, _FORTRAN):
        try:
            with warnings.catch_warnings():  # NumPy before 2.4 only warns
                warnings.simplefilter("error", DeprecationWarning)
                text = block.translate(change) if change else block
                return np.fromstring(text, dtype=dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            continue
    return None


def _has_lone_sign(block: bytes) -> bool:
    return (b"-" in block or b"+" in block) and _LONE_SIGN.search(block) is not None


def first_wrong(count: int, text: Callable[[int, int], bytes], dtype: DTypeLike) -> int:
    """First of `count` tokens that is no finite number, by halving; ``text(i, j)`` joins some."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        found = numbers(text(low, middle), dtype)
        good = found is not None and len(found) == middle - low and np.isfinite(found).all()
        low, high = (middle, high) if good else (low, middle)
    return low
