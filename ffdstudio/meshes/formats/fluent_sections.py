"""The sections of a Fluent file: nodes, faces and the names of zones."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from ffdstudio.meshes.formats.source import Source

_BRACKET = re.compile(rb'[()"]')
_INDEX = re.compile(rb"\(\s*(\d+)")
_HEAD = re.compile(rb"\s*\(([^()]*)\)\s*(\()?")


class Zone(NamedTuple):
    """A section of nodes or faces: its head, and begin and end of its numbers."""

    head: list[int]
    begin: int
    end: int


@dataclass
class Sections:
    """What a file holds."""

    dimension: int = 3
    nodes: list[Zone] = field(default_factory=list)
    faces: list[Zone] = field(default_factory=list)
    names: dict[int, tuple[str, str]] = field(default_factory=dict)  # zone -> type, name


def sections_of(source: Source) -> Sections:
    """Find all sections of a file."""
    data, found = source.data, Sections()
    at = data.find(b"(")
    while at >= 0:
        match = _INDEX.match(data, at)
        number = match[1] if match else b""
        body = match.end() if match else at + 1
        if number in (b"10", b"12", b"13"):
            end = _numbers(source, found, int(number), body)
        else:
            end = _closing(source, at)
            _other(source, found, number, data[body : end - 1], at)
        at = data.find(b"(", end)
    return found


def _numbers(source: Source, found: Sections, number: int, place: int) -> int:
    """Take a section of nodes, cells or faces; return the place behind it."""
    match = _HEAD.match(source.data, place)
    if match is None:
        raise source.error(place, "expected the head of a section in brackets")
    try:
        head = [int(word, 16) for word in match[1].split()]
    except ValueError:
        raise source.error(place, "the head of a section holds hexadecimal numbers") from None
    if len(head) < 3 or min(head) < 0:
        raise source.error(place, "the head of a section needs zone, first and last")
    end = match.end()
    if match[2]:
        close = source.data.find(b")", end)
        if close < 0:
            raise source.error(place, "the file ends within this section")
        if number != 12:
            {10: found.nodes, 13: found.faces}[number].append(Zone(head, end, close))
        end = close + 1
    return source.data.find(b")", end) + 1 or len(source.data)


def _closing(source: Source, at: int) -> int:
    """Place behind the bracket that closes the one at `at`; brackets in strings do not count."""
    depth, quoted = 0, False
    for match in _BRACKET.finditer(source.data, at):
        if match[0] == b'"':
            quoted = not quoted
        elif not quoted:
            depth += 1 if match[0] == b"(" else -1
            if depth == 0:
                return match.end()
    raise source.error(at, "a section does not end")


def _other(source: Source, found: Sections, number: bytes, body: bytes, place: int) -> None:
    if number == b"2":
        found.dimension = source.integer(body.strip(), place, "the dimension")
        if found.dimension not in (2, 3):
            raise source.error(place, f"the dimension must be 2 or 3, not {found.dimension}")
    elif number in (b"39", b"45"):
        words = body.replace(b"(", b" ").replace(b")", b" ").split()
        if len(words) >= 3 and words[0].isdigit():
            kind, name = (word.decode("utf-8", "replace") for word in words[1:3])
            found.names[int(words[0])] = (kind, name)
    elif len(number) == 4 and number[:1] in b"23" and number[2:] in (b"10", b"12", b"13"):
        raise source.error(place, "binary Fluent meshes are not supported; save it as ASCII")
