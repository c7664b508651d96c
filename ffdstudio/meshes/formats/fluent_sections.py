"""The sections of a Fluent file: nodes, faces and the names of zones.

Sections of four digits are binary: 20xx hold singles, 30xx doubles, both whole numbers of four
bytes (some writers of 30xx: eight). They end with ``End of Binary Section`` and their number.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from ffdstudio.meshes.formats.source import Source, decoded

_BRACKET = re.compile(rb'"(?:[^"\\]|\\.)*"|#\\.|[()]', re.S)
_BARE = re.compile(rb"[()]")
_INDEX = re.compile(rb"\(\s*(\d+)")
_HEAD = re.compile(rb"\s*\(([^()]*)\)\s*(\()?")
_END = re.compile(rb"\)?\s*End of Binary Section\s+(\d+)\s*\)")
NODES, CELLS, FACES, PAIRS = 10, 12, 13, 18


class Zone(NamedTuple):
    """A section of nodes or faces: its head, and begin and end of its numbers.

    `real` is the number of bytes of its coordinates if it is binary, else 0.
    """

    head: list[int]
    begin: int
    end: int
    real: int = 0

    def word(self, index: int) -> int:
        """Number in the head, 0 where it is left out."""
        return self.head[index] if len(self.head) > index else 0


@dataclass
class FluentSections:
    """What a file holds."""

    dimension: int = 3
    nodes: list[Zone] = field(default_factory=list)
    faces: list[Zone] = field(default_factory=list)
    names: dict[int, tuple[str, str]] = field(default_factory=dict)  # zone -> type, name
    pairs: list[Zone] = field(default_factory=list)  # faces of a periodic zone and of its shadow


def sections_of(source: Source) -> FluentSections:
    """Find all sections of a file."""
    data, found = source.data, FluentSections()
    at = data.find(b"(")
    while at >= 0:
        match = _INDEX.match(data, at)
        number = int(match[1][:9]) if match else -1
        body = match.end() if match else at + 1
        if number in (NODES, CELLS, FACES, PAIRS):
            end = _numbers(source, found, number, body)
        elif number // 1000 in (2, 3):
            end = _binary(source, found, number, body)
        else:
            end = _closing(source, at)
            _other(source, found, number, data[body : end - 1], at)
        at = data.find(b"(", end)
    return found


def _head(source: Source, place: int) -> tuple[list[int], re.Match[bytes]]:
    match = _HEAD.match(source.data, place)
    if match is None:
        raise source.error(place, "expected the head of a section in brackets")
    try:
        head = [int(word, 16) for word in match[1].split()]
    except ValueError:
        raise source.error(place, "the head of a section holds hexadecimal numbers") from None
    if len(head) < 3 or min(head) < 0:
        raise source.error(place, "the head of a section needs zone, first and last")
    return head, match


def _numbers(source: Source, found: FluentSections, number: int, place: int) -> int:
    """Take a section of nodes, cells or faces; return the place behind it."""
    head, match = _head(source, place)
    end = match.end()
    if match[2]:
        close = source.data.find(b")", end)
        if close < 0:
            raise source.error(place, "the file ends within this section")
        _keep(found, number, Zone(head, end, close))
        end = close + 1
    return source.data.find(b")", end) + 1 or len(source.data)


def _keep(found: FluentSections, number: int, zone: Zone) -> None:
    lists = {NODES: found.nodes, FACES: found.faces, PAIRS: found.pairs}
    if number in lists:
        lists[number].append(zone)


def _binary(source: Source, found: FluentSections, number: int, place: int) -> int:
    """Take a binary section; return the place behind it."""
    begin = _HEAD.match(source.data, place)
    kind = number % 100
    least = place
    real = 4 if number < 3000 else 8
    if kind in (NODES, FACES) and begin is not None and begin[2]:
        head, match = _head(source, place)
        axes = head[4] if len(head) > 4 else found.dimension
        size = real * axes if kind == NODES else 4 * (2 + max(head[4:5] or [0]))
        least = match.end() + max(head[2] - head[1] + 1, 0) * (size if size else 8)
    end = _end_of(source, number, place, least)
    if kind in (NODES, FACES) and begin is not None and begin[2]:
        _keep(found, kind, Zone(head, match.end(), end.start(), real))
    return end.end()


def _end_of(source: Source, number: int, place: int, least: int) -> re.Match[bytes]:
    """Mark that ends a binary section, at `least` or behind it."""
    at = least
    while match := _END.search(source.data, at):
        if int(match[1][:9]) == number:
            return match
        at = match.end()
    raise source.error(place, "a binary section does not end")


def _closing(source: Source, at: int) -> int:
    """Place behind the bracket that closes the one at `at`; brackets in strings do not count."""
    for token in (_BRACKET, _BARE):  # a comment may hold a single quotation mark
        depth = 0
        for match in token.finditer(source.data, at):
            depth += {b"(": 1, b")": -1}.get(match[0], 0)
            if depth == 0 and match[0] == b")":
                return match.end()
    raise source.error(at, "a section does not end")


def _other(source: Source, found: FluentSections, number: int, body: bytes, place: int) -> None:
    if number == 2:
        found.dimension = source.integer(body.strip(), place, "the dimension")
        if found.dimension not in (2, 3):
            raise source.error(place, f"the dimension must be 2 or 3, not {found.dimension}")
    elif number in (39, 45):
        words = body.replace(b"(", b" ").replace(b")", b" ").split()
        if len(words) >= 3 and words[0].isdigit():
            kind, name = (decoded(word) for word in words[1:3])
            found.names[int(words[0])] = (kind, name)
