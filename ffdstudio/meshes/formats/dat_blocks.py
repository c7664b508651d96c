"""Lines of an airfoil file: which hold points, and what the others are.

1. People add to these files: text before and after the points, commas, a column of zeros, the
   domain of MSES (four or five numbers before the points), 999 between the elements of a
   section. What stands before the first point and behind the last one is not read.
2. A line in the midst of the points that is none is damage: the file is refused there, for to
   cut it off would leave half a section.
3. Decimal commas become points in the template as well (as many bytes), for numbers that
   change are written with a point.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.formats.source import Source

SEPARATOR = 999.0  # both numbers of a line between two elements, as MSES has it
LINE = re.compile(rb"[^\r\n]*(?:\r\n|\r|\n|$)")
WORD = re.compile(rb"[^\s,;]+")
NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?|[-+]?(?:nan|inf)", re.IGNORECASE)
WITH_COMMA = re.compile(rb"\s*[-+]?\d*,\d+\s+[-+]?\d*,\d+\s*")
MOST = 5  # numbers in a line that is not text

Places = list[tuple[int, int]]


class DatLine(NamedTuple):
    """A line: where it begins, the places of its words, and their values where all are numbers."""

    place: int
    words: Places
    values: list[float] | None

    @property
    def separates(self) -> bool:
        """Whether it stands between two elements."""
        values = self.values
        return values is not None and len(values) == 2 and min(map(abs, values)) >= SEPARATOR


@dataclass
class PointBlock:
    """Points one after the other: their values, and where each number begins and ends.

    `before` is the text that stands between this block and the one before, `parted` whether a
    line of 999 does.
    """

    before: DatLine | None = None
    parted: bool = False
    values: list[list[float]] = field(default_factory=list)
    places: list[Places] = field(default_factory=list)

    @property
    def xy(self) -> Array:
        """(n, 2) points."""
        return np.array(self.values, dtype=np.float64).reshape(-1, 2)


def without_decimal_commas(data: bytes) -> bytes:
    r"""The same bytes, with points for commas if lines of points hold one in each number.

    Examples
    --------
    >>> without_decimal_commas(b"name\n1,0 0,01\n0,5 ,1\n0,0 -0,0\n")
    b'name\n1.0 0.01\n0.5 .1\n0.0 -0.0\n'
    """
    lines = [line for line in LINE.findall(data) if line.strip()]
    if 2 * sum(WITH_COMMA.fullmatch(line) is not None for line in lines) < len(lines):
        return data
    return LINE.sub(
        lambda m: m[0].replace(b",", b".") if WITH_COMMA.fullmatch(m[0]) else m[0], data
    )


def blocks_of(source: Source) -> list[PointBlock]:
    """Points of a file, in blocks that blank lines, text or lines of 999 part.

    Raises
    ------
    InputError
        If a line among the points is damaged; the message names it.
    """
    lines = [_line(source.data, match) for match in LINE.finditer(source.data)]
    pick = _columns(lines)
    blocks: list[PointBlock] = []
    following: PointBlock | None = PointBlock()
    for line in lines:
        if not line.words:
            following = following or PointBlock()
        elif line.separates and blocks:
            following = PointBlock(parted=True)
        elif (point := pick(line)) is not None:
            if following is not None:
                blocks.append(following)
            following = None
            blocks[-1].values.append(point[0])
            blocks[-1].places.append(point[1])
        elif blocks:
            _refuse_damaged(source, line)
            following = following or PointBlock()
            following.before = following.before or line
    return blocks


def _line(data: bytes, match: re.Match[bytes]) -> DatLine:
    words = [m.span() for m in WORD.finditer(data, match.start(), match.end())]
    if not 1 <= len(words) <= MOST:
        return DatLine(match.start(), words, None)
    texts = [data[a:b] for a, b in words]
    values = [_value(text) for text in texts] if all(map(NUMBER.fullmatch, texts)) else None
    return DatLine(match.start(), words, values)


def _value(text: bytes) -> float:
    return float(text.lower().replace(b"d", b"e"))


def _columns(lines: list[DatLine]) -> Callable[[DatLine], tuple[list[float], Places] | None]:
    """What takes the two coordinates from a line; None from a line that has none."""
    widths = [len(line.values) for line in lines if line.values is not None]
    width, first = 2, 0
    if widths.count(3) > max(2, len(widths) // 2):
        width = 3
        ends = np.array([x for x in (line.values for line in lines) if x and len(x) == 3])
        first = 0 if np.ptp(ends[:, 2]) == 0 else int((np.diff(ends[:, 0]) == 1).all())
        width = 3 if first or np.ptp(ends[:, 2]) == 0 else 2

    def pick(line: DatLine) -> tuple[list[float], Places] | None:
        if line.values is None or len(line.values) != width:
            return None
        return line.values[first : first + 2], line.words[first : first + 2]

    return pick


def _refuse_damaged(source: Source, line: DatLine) -> None:
    """Raise where a line behind the first point looks like a point that is damaged.

    Two words of which one is a number and the other at least begins as one, or comes second:
    ``cm0 -0.02`` is text.
    """
    if line.values is not None:
        raise source.error(line.place, "an airfoil has two coordinates a line")
    words = [source.data[a:b] for a, b in line.words]
    wrong = [word for word in words if not NUMBER.fullmatch(word)]
    if len(words) == 2 and len(wrong) == 1 and (NUMBER.match(wrong[0]) or words[1] is wrong[0]):
        shown = wrong[0][:20].decode("latin-1")
        raise source.error(line.place, f"expected a number, found {shown!r}")
