"""The lines of an Abaqus deck, by keyword, and the words in them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.number_table import line_firsts, split_tokens
from ffdstudio.meshes.formats.source import Source, decoded

_BLANK = re.compile(rb"^[ \t]*,|,[ \t]*,", re.M)


@dataclass
class DeckBlock:
    """A keyword with its parameters and the places of its data lines."""

    keyword: str
    parameters: dict[str, str]
    place: int
    source: Source
    spans: list[tuple[int, int]] = field(default_factory=list)


def blocks_of(source: Source) -> list[DeckBlock]:
    """All keywords of a deck with their data lines."""
    data, found = source.data, []
    at = 0
    while at < len(data):
        end = source.line_end(at)
        line = data[at:end].strip()
        if line.startswith(b"*") and not line.startswith(b"**"):
            while line.endswith(b",") and end < len(data):
                begin, end = end, source.line_end(end)
                line += data[begin:end].strip()
            found.append(_block(source, line, at))
        stop = _next_star(data, end if line.startswith(b"*") else at)
        if found and data[end:stop].strip():
            found[-1].spans.append((end, stop))
        at = stop
    return found


def _next_star(data: bytes, at: int) -> int:
    """Begin of the next line that begins with a star, from the begin of a line on."""
    if data[at : at + 1] == b"*":
        return at
    found = data.find(b"\n*", at)
    return len(data) if found < 0 else found + 1


def _block(source: Source, line: bytes, place: int) -> DeckBlock:
    words = decoded(line[1:]).split(",")
    parameters = {}
    for word in words[1:]:
        key, _, value = word.partition("=")
        parameters[key.strip().upper()] = value.strip().strip('"')
    return DeckBlock(words[0].strip().upper(), parameters, place, source)


def first_blank(block: DeckBlock) -> int | None:
    """Place of the first field that is left blank between commas, which stands for zero."""
    for begin, end in block.spans:
        found = _BLANK.search(block.source.data[begin:end])
        if found:
            return begin + found.start()
    return None


def tokens(block: DeckBlock) -> tuple[Indices, Indices, Indices]:
    """Begin and end of all words of a block, and the first one of each line."""
    parts = []
    total = 0
    for begin, end in block.spans:
        text = block.source.data[begin:end]
        starts, ends = split_tokens(text, b",")
        parts.append((starts + begin, ends + begin, line_firsts(text, starts) + total))
        total += len(starts)
    return _joined(parts)


def fields(block: DeckBlock) -> tuple[Indices, Indices, Indices]:
    """As `tokens`, with blank fields: words without a letter, where a number can be put in."""
    parts, total = [], 0
    for begin, end in block.spans:
        starts: list[int] = []
        ends: list[int] = []
        first: list[int] = []
        at = begin
        while at < end:
            stop = min(block.source.line_end(at), end)
            if block.source.data[at:stop].strip():
                first.append(total + len(starts))
                for word in block.source.data[at:stop].rstrip().split(b","):
                    solid = word.strip()
                    starts.append(at + word.find(solid))
                    ends.append(starts[-1] + len(solid))
                    at += len(word) + 1
            at = stop
        total += len(starts)
        parts.append([np.array(found, dtype=np.int64) for found in (starts, ends, first)])
    return _joined(parts)


def _joined(parts: Sequence[Sequence[Indices]]) -> tuple[Indices, Indices, Indices]:
    if not parts:
        none = np.empty(0, dtype=np.int64)
        return none, none, none
    starts, ends, first = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return starts, ends, first
