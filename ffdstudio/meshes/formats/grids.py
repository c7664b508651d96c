"""The GRID cards of a Nastran deck, and what becomes of those that move."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats.card_deck import WIDTH, Deck, Letters
from ffdstudio.meshes.formats.patch import changed

COMMENT = re.compile(rb"\$([^\r\n]*)")


@dataclass(frozen=True, eq=False)
class Grids:
    """GRID cards of one file: identifiers, coordinates, lines and whether fields are large."""

    deck: Deck
    relative: str  # name of the file as seen from the deck, "" for the deck itself
    ids: Indices
    points: Array
    lines: Indices
    large: np.ndarray

    def patched(self, points: Array) -> bytes:
        """File content with these coordinates."""
        data, begins = self.deck.source.data, self.deck.begins
        moved = changed(self.points, points)
        rows = np.flatnonzero(moved.any(axis=1))
        if not len(rows):
            return data
        lines, large = self.lines[rows], self.large[rows]
        fields = grid_fields(self.deck, lines, large)
        last = np.where(large, self.deck.continuation(lines, large), lines)
        last = np.maximum(last, lines)  # a GRID* without z has one line
        pieces, at = [], 0
        for row, begin, end, old in zip(
            rows.tolist(),
            begins[lines].tolist(),
            begins[last + 1].tolist(),
            fields,
            strict=True,
        ):
            texts = [old[k].tobytes().strip() for k in range(8)]
            for axis in np.flatnonzero(moved[row]).tolist():
                texts[2 + axis] = sixteen(float(points[row, axis])).encode()
            pieces += [data[at:begin], _card(texts, data[begin:end])]
            at = end
        return b"".join([*pieces, data[at:]])


def _card(texts: list[bytes], old: bytes) -> bytes:
    """GRID* card in two lines from its eight fields; comments of the old lines stand before it."""
    first = b"GRID*   " + b"".join(text.ljust(WIDTH) for text in texts[:2])
    first += b"".join(text.rjust(WIDTH) for text in texts[2:4]) + b"*"
    second = b"*       " + b"".join(text.rjust(WIDTH) for text in texts[4:8])
    ending = b"\r\n" if b"\r\n" in old else b"\n"
    comments = [b"$" + part for part in COMMENT.findall(old)]
    text = ending.join([*comments, first, second.rstrip()])
    return text + (ending if old.endswith(b"\n") else b"")


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


def sixteen(value: float) -> str:
    """Real number in at most 16 characters, the closest that Nastran's notation allows.

    Examples
    --------
    >>> sixteen(-1 / 3), sixteen(1e-5 / 3), sixteen(2.0)
    ('-.33333333333333', '3.333333333333-6', '2.')
    """
    short = _compact(repr(value))
    if len(short) <= WIDTH:
        return short
    fits = [text for form in "fe" if (text := _longest(value, form))]
    return min(fits, key=lambda text: abs(float(plain(text)) - value))


def _longest(value: float, form: str) -> str:
    """Text with as many digits as fit, fixed (f) or with an exponent (e); empty if none does."""
    for digits in range(15, 3, -1):
        text = _compact(f"{value:.{digits}{form}}")
        if len(text) <= WIDTH:
            return text
    return ""


def _compact(text: str) -> str:
    """Drop the zero before the point and the E of the exponent, as Nastran allows."""
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += "."
    mantissa = re.sub(r"^(-?)0\.(?=\d)", r"\1.", mantissa)
    mantissa = re.sub(r"(?<=\d)0+$", "", mantissa) if "." in mantissa else mantissa
    if mantissa.endswith(".0"):
        mantissa = mantissa[:-1]
    if mantissa.strip("-") == ".":
        mantissa = "0."
    return mantissa + (f"{int(exponent):+d}" if exponent else "")


def plain(text: str) -> str:
    """Nastran's real as others write it."""
    return re.sub(r"(?<=[\d.])([+-])", r"e\1", text)
