"""Nastran's coordinate systems: cards CORD1R/C/S by nodes and CORD2R/C/S by points.

A system may be given in another one, and one by nodes moves with them: all are put together
anew from the nodes' coordinates, in any order that leads from what is known to what is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.meshes.formats.card_deck import WIDTH, Deck, Letters, integers, reals
from ffdstudio.meshes.formats.frames import Frame

Key = tuple[int, int]  # section of bulk data, number


class Cord(NamedTuple):
    """A card: its system, the one it is given in, and its points or nodes."""

    key: Key
    kind: str
    base: Key
    points: Array | None
    nodes: tuple[Key, ...]
    deck: Deck
    line: int


def cords_of(deck: Deck, section: Indices) -> list[Cord]:
    """All coordinate systems of a file; `section` (lines,) tells the section of each line."""
    found: list[Cord] = []
    for kind in "RCS":
        for star in (False, True):
            found += _by_points(deck, section, kind, star)
            found += _by_nodes(deck, section, kind, star)
    return found


def _fields(deck: Deck, line: int, star: bool, many: int) -> Letters:
    """(many, 16) letters of the fields of a card over its lines."""
    at, parts = np.array([line]), [deck.fields(np.array([line]), star)[0]]
    while sum(map(len, parts)) < many:
        at = deck.continuation(at, np.array([star]))
        if at[0] < 0:
            parts.append(np.full((many, WIDTH), 32, dtype=np.uint8))
            break
        parts.append(deck.fields(at, star)[0])
    return np.concatenate(parts)[:many]


def _by_points(deck: Deck, section: Indices, kind: str, star: bool) -> list[Cord]:
    found = []
    for line in deck.cards(f"CORD2{kind}", star).tolist():
        fields = _fields(deck, line, star, 11)
        own = np.full(11, line)
        number, base = integers(deck, own[:2], fields[:2]).tolist()
        points = reals(deck, own[2:], fields[2:]).reshape(3, 3)
        part = int(section[line])
        found.append(Cord((part, number), kind, (part, base), points, (), deck, line))
    return found


def _by_nodes(deck: Deck, section: Indices, kind: str, star: bool) -> list[Cord]:
    found = []
    for line in deck.cards(f"CORD1{kind}", star).tolist():
        many = 4 if star else 8
        numbers = integers(deck, np.full(many, line), _fields(deck, line, star, many)).tolist()
        part = int(section[line])
        for k in range(0, many, 4):
            if numbers[k]:
                nodes = tuple((part, node) for node in numbers[k + 1 : k + 4])
                found.append(Cord((part, numbers[k]), kind, (part, 0), None, nodes, deck, line))
    return found


@dataclass(frozen=True, eq=False)
class Systems:
    """The coordinate systems of a deck, with the index of each node that one is given by."""

    cords: list[Cord]
    index: dict[Key, int]

    def at(self, points: Array, known: Mask) -> dict[Key, Frame]:
        """Frames that can be made, given (n, 3) global coordinates of the nodes known."""
        found: dict[Key, Frame] = {}
        waiting = list(self.cords)
        while waiting:
            ready = [cord for cord in waiting if self._is_ready(cord, found, known)]
            if not ready:
                break
            found |= {cord.key: self._frame(cord, found, points) for cord in ready}
            waiting = [cord for cord in waiting if cord.key not in found]
        return found

    def _is_ready(self, cord: Cord, found: dict[Key, Frame], known: Mask) -> bool:
        if cord.points is not None:
            return cord.base[1] == 0 or cord.base in found
        rows = [self.index.get(node) for node in cord.nodes]
        return all(row is not None and known[row] for row in rows)

    def _frame(self, cord: Cord, found: dict[Key, Frame], points: Array) -> Frame:
        if cord.points is None:
            through = points[[self.index[node] for node in cord.nodes]]
        else:
            base = found.get(cord.base)
            through = cord.points if base is None else base.to_global(cord.points)
        try:
            return Frame.through(cord.kind, *through)
        except ValueError as error:
            raise cord.deck.error(cord.line, str(error)) from None
