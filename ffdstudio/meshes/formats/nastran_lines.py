"""Lines of a Nastran deck as its cards mean them: tabs as blanks, repeated cards written out.

1. A tab goes on to the next multiple of eight columns.
2. A line that begins with ``=`` repeats the card before it: ``=`` in a field is that field,
   ``==`` all that are left, ``*n`` the field and n more. ``=(n)`` repeats such a line n times.
3. Each line knows the place in the file that it stands for. A card that is repeated, and all
   that repeat it, have one place: none of them can change alone.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.nastran_reals import sixteen
from ffdstudio.meshes.formats.source import Source

_REPEATS = re.compile(rb"^[ \t]*=", re.M)
_LINE = re.compile(rb"[^\n]*\n|[^\n]+")
_MANY = re.compile(rb"=\(?(\d+)\)?$")
_STEP = re.compile(rb"\*\(?([^()]+)\)?$")
MOST = 10_000_000  # lines that repeated cards may make


class Lines(NamedTuple):
    """Text with a line a card or continuation, and (lines, 2) where each stands in the file."""

    text: bytes
    spans: Indices


def lines_of(source: Source) -> Lines:
    """Lines of a file, written out.

    Raises
    ------
    InputError
        If a line repeats a card that it cannot.
    """
    data = source.data
    text = data.expandtabs(8) if b"\t" in data else data
    ends = np.flatnonzero(np.frombuffer(data, np.uint8) == 10) + 1
    begins = np.concatenate([[0], ends]).astype(np.int64)
    if begins[-1] < len(data) or not len(data):
        begins = np.append(begins, len(data))
    spans = np.stack([begins[:-1], begins[1:]], axis=1)
    if not _REPEATS.search(text):
        return Lines(text, spans)
    return _written_out(source, _LINE.findall(text), spans.tolist())


def _written_out(source: Source, rows: list[bytes], spans: list[list[int]]) -> Lines:
    found: list[bytes] = []
    places: list[list[int]] = []
    last, step = -1, b""  # the card before, and the line that repeated it
    for row, span in zip(rows, spans, strict=True):
        bare = row.split(b"$")[0].strip()
        if not bare.startswith(b"="):
            last = len(found) if bare else last
            step = b"" if bare else step
            found.append(row)
            places.append(span)
            continue
        match = _MANY.match(bare)
        many, step = (int(match[1]), step) if match else (1, bare)
        if last < 0 or not step or many > MOST - len(found):
            raise source.error(span[0], "a line that repeats a card, where there is none")
        if found[last].lstrip()[:1] in (b"+", b"*"):
            raise source.error(span[0], "'=' repeats cards of one line only")
        begin = places[last][0]
        for _ in range(many):
            found.append(_repeated(source, span[0], found[last], step))
            places.append([begin, span[1]])
            last = len(found) - 1
        _widen(places, begin, span[1])
    return Lines(b"".join(found), np.array(places, dtype=np.int64).reshape(-1, 2))


def _widen(places: list[list[int]], begin: int, end: int) -> None:
    """Let all lines of a group have its whole place."""
    for k in range(len(places) - 1, -1, -1):
        if places[k][0] < begin:
            return
        places[k] = [begin, end]


def _words(line: bytes) -> list[bytes]:
    """Fields of a line, free or of eight columns."""
    bare = line.split(b"$")[0].rstrip()
    if b"," in bare:
        return [word.strip() for word in bare.split(b",")]
    return [bare[k : k + 8].strip() for k in range(0, max(len(bare), 1), 8)]


def _repeated(source: Source, place: int, before: bytes, step: bytes) -> bytes:
    """Free-field card that a line of repeats stands for."""
    old = _words(before)
    if old[0].endswith(b"*"):
        raise source.error(place, "cards of large fields repeated by '=' are not supported")
    new: list[bytes] = []
    for k, word in enumerate(_words(step)):
        own = old[k] if k < len(old) else b""
        if word == b"==":
            new += old[k:]
            break
        new.append(own if word == b"=" else _stepped(source, place, own, word))
    return b",".join(new) + b"\n"


def _stepped(source: Source, place: int, own: bytes, word: bytes) -> bytes:
    match = _STEP.match(word)
    if match is None:
        return word
    try:
        return str(int(own or b"0") + int(match[1])).encode()
    except ValueError:
        pass
    try:
        return sixteen(_real(own or b"0") + _real(match[1])).encode()
    except ValueError:
        shown = word[:20].decode("latin-1")
        raise source.error(place, f"a field cannot grow by {shown!r}") from None


def _real(text: bytes) -> float:
    return float(re.sub(rb"(?<=[\d.])([-+])", rb"E\1", text.upper().replace(b"D", b"E")))
