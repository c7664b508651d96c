"""The GRID cards of a Nastran deck, and what becomes of those that move."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.meshes.formats.card_deck import WIDTH, Deck, Letters
from ffdstudio.meshes.formats.nastran_reals import sixteen

COMMENT = re.compile(rb"\$([^\r\n]*)")


@dataclass(frozen=True, eq=False)
class Grids:
    """GRID cards of one file: identifiers, coordinates, lines and whether fields are large.

    `points` are (k, 3) as in the file, in the frames `frames`; a node has several cards where
    a deck repeats one. `section` tells sections of bulk data apart.
    """

    deck: Deck
    relative: str  # name of the file as seen from the deck, "" for the deck itself
    ids: Indices
    points: Array
    lines: Indices
    large: Mask
    frames: Indices
    section: Indices

    def patched(self, points: Array, moved: Mask) -> bytes:
        """File content with these (k, 3) coordinates where (k, 3) `moved` says so."""
        rows = np.flatnonzero(moved.any(axis=1))
        if not len(rows):
            return self.deck.raw
        cards = self._cards(rows, points, moved)
        last = self.deck.last_lines(self.lines, self.large)
        pieces, at = [], 0
        for begin, end, members in self._places(rows):
            pieces.append(self.deck.raw[at:begin])
            old = self.deck.raw[begin:end]
            ending = b"\r\n" if b"\r\n" in old else b"\n"
            pieces += [b"$" + part + ending for part in COMMENT.findall(old)]
            texts = [cards.get(row) or self._text(row, last[row]) for row in members]
            texts = [text.replace(b"\r\n", b"\n").replace(b"\n", ending) for text in texts]
            joined = ending.join(texts)
            pieces.append(joined + (ending if old.endswith(b"\n") else b""))
            at = end
        return b"".join([*pieces, self.deck.raw[at:]])

    def _text(self, row: int, last: int) -> bytes:
        """Card that does not move, in a group in which another one does."""
        begins = self.deck.begins
        return self.deck.source.data[begins[self.lines[row]] : begins[last + 1]].rstrip()

    def _places(self, rows: Indices) -> list[tuple[int, int, list[int]]]:
        """Begin and end in the file of what is replaced, and the cards that stand there."""
        last = self.deck.last_lines(self.lines, self.large)
        begins, ends = self.deck.spans[self.lines, 0], self.deck.spans[last, 1]
        found: dict[int, tuple[int, list[int]]] = {}
        for row in np.flatnonzero(np.isin(begins, begins[rows])).tolist():
            end, members = found.get(int(begins[row]), (0, []))
            found[int(begins[row])] = max(end, int(ends[row])), [*members, row]
        return [(begin, end, members) for begin, (end, members) in sorted(found.items())]

    def _cards(self, rows: Indices, points: Array, moved: Mask) -> dict[int, bytes]:
        """New cards of the rows that move."""
        fields = grid_fields(self.deck, self.lines[rows], self.large[rows])
        found = {}
        for row, old in zip(rows.tolist(), fields, strict=True):
            texts = [old[k].tobytes().strip() for k in range(8)]
            for axis in np.flatnonzero(moved[row]).tolist():
                texts[2 + axis] = sixteen(float(points[row, axis])).encode()
            found[row] = _card(texts)
        return found


def _card(texts: list[bytes]) -> bytes:
    """GRID* card in two lines from its eight fields."""
    first = b"GRID*   " + b"".join(text.ljust(WIDTH) for text in texts[:2])
    first += b"".join(text.rjust(WIDTH) for text in texts[2:4]) + b"*"
    second = b"*       " + b"".join(text.rjust(WIDTH) for text in texts[4:8])
    return first + b"\n" + second.rstrip()


def grid_fields(deck: Deck, lines: Indices, large: np.ndarray) -> Letters:
    """(lines, 8, 16) fields of GRID cards: ID CP X1 X2 X3 CD PS SEID."""
    found = deck.fields(lines)
    wide = np.flatnonzero(large)
    if len(wide):
        following = deck.continuation(lines[wide], large[wide])
        goes_on = following >= 0
        rest = np.full((len(wide), 4, WIDTH), 32, dtype=np.uint8)
        rest[goes_on] = deck.fields(following[goes_on], large=True)
        found[wide] = np.concatenate([deck.fields(lines[wide], large=True), rest], axis=1)
    return found
