"""Nastran decks (.bdf, .nas, .dat): small, large and free fields, INCLUDE files.

1. A coordinate has 8 characters in a small field: too few. A GRID that moves becomes a GRID*
   with 16; one that stays keeps its line. 16 characters hold 13 to 15 digits, which is said.
2. Included files belong to the deck and are written beside it under the same relative name.
   An original is never overwritten unless the deck itself is. One that is not there is told.
3. Coordinates in a local frame (CP) are put into x, y, z and back into the frame, which may be
   given by nodes that move.
4. Elements of one property are a marker. A card that repeats another one in all its fields
   counts once, and both follow. Each section BEGIN SUPER has numbers of its own.

Source: MSC Nastran quick reference guide, bulk data entries.
"""

from __future__ import annotations

import os
import re
import warnings
from collections import Counter
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.card_deck import BLANK, Deck, integers, reals
from ffdstudio.meshes.formats.deck_files import DeckFile, DeckTemplate, located
from ffdstudio.meshes.formats.frames import Frame
from ffdstudio.meshes.formats.grids import Grids, grid_fields
from ffdstudio.meshes.formats.nastran_elements import elements, unread
from ffdstudio.meshes.formats.nastran_frames import Cord, Key, Systems, cords_of
from ffdstudio.meshes.formats.nastran_reals import plain, sixteen
from ffdstudio.meshes.formats.patch import changed
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells

_INCLUDE = re.compile(  # a name in quotes may go on in the next lines
    rb"^[ \t]*INCLUDE[ \t]+(?:'([^'$]{0,500})'|\"([^\"$]{0,500})\"|([^\s'\"]+))", re.I | re.M
)
_END = re.compile(rb"^[ \t]*ENDDATA\b", re.I | re.M)
_SECTION = re.compile(rb"^[ \t]*BEGIN[ \t]+(?:SUPER|AUXMODEL|MODULE)", re.I | re.M)
SHIFT = 2**40  # identifiers of sections are told apart by so much


class File(NamedTuple):
    """A file of the deck: path, name as seen from the deck, content, section where it is read."""

    path: Path
    relative: str
    data: bytes
    section: int


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Nastran deck; see `read_mesh`."""
    files = _files(path, data)
    decks = [Deck.of(Source(file.path, file.data)) for file in files]
    sections = [_sections(deck, file.section) for deck, file in zip(decks, files, strict=True)]
    frame = max(map(_default_frame, decks))
    parts = zip(decks, files, sections, strict=True)
    nodes = _Nodes(path, [_grids(deck, file.relative, frame, part) for deck, file, part in parts])
    pairs = zip(decks, sections, strict=True)
    nodes.place([cord for deck, section in pairs for cord in cords_of(deck, section)])
    progress(0.5)
    cells: dict[str, list[Indices]] = {}
    markers: dict[str, dict[str, list[Indices]]] = {}
    for deck, section in zip(decks, sections, strict=True):
        for found in elements(deck, section):
            rows = nodes.index(deck, found.nodes, section[found.lines])
            cells.setdefault(found.kind, []).append(rows)
            for number in filter(None, np.unique(found.properties).tolist()):
                inside = markers.setdefault(f"property {number}", {})
                inside.setdefault(found.kind, []).append(rows[found.properties == number])
    counts = sum(map(unread, decks), Counter())
    named: Markers = {name: _joined(parts) for name, parts in markers.items()}
    deck_files = [DeckFile(Source(file.path, file.data), file.relative) for file in files]
    template = DeckTemplate(path, nodes.points, deck_files, nodes.contents, partial(_warn, nodes))
    return Mesh(nodes.points, _joined(cells), named, unread=dict(counts), template=template)


@dataclass
class _Nodes:
    """The nodes of all files: (rows,) cards, and the node of each."""

    path: Path
    grids: list[Grids]

    def __post_init__(self) -> None:
        ids = np.concatenate([part.ids + SHIFT * part.section for part in self.grids])
        if not len(ids):
            raise InputError(f"{self.path}: there is no GRID in this deck")
        self.local = np.concatenate([part.points for part in self.grids])
        self.frames = np.concatenate([part.frames for part in self.grids])
        self.section = np.concatenate([part.section for part in self.grids])
        self.ids, first, self.node = _distinct(ids)
        twin = first[self.node]
        differs = (self.local != self.local[twin]).any(axis=1) | (self.frames != self.frames[twin])
        if differs.any():
            number = ids[np.flatnonzero(differs)[0]] % SHIFT
            raise InputError(f"{self.path}: GRID {number} occurs twice, in different places")
        self.order = np.argsort(self.ids, kind="stable")
        self.first = first
        self.points = self.local[first]
        self.systems = Systems([], {})

    def place(self, cords: list[Cord]) -> None:
        """Put nodes that are given in local frames into x, y, z."""
        if not self.frames.any():
            return
        numbers = [node for cord in cords for node in cord.nodes]
        known = {int(n): k for k, n in enumerate(self.ids.tolist())} if numbers else {}
        index = {(s, n): known[n + SHIFT * s] for s, n in numbers if n + SHIFT * s in known}
        self.systems = Systems(cords, index)
        done = (self.frames[self.first] == 0).copy()
        while not done.all():
            frames = self.systems.at(self.points, done)
            new = [k for k in self._keys(~done) if self._frame(frames, k) is not None]
            if not new:
                self._refuse(int(np.flatnonzero(~done)[0]))
            for key in new:
                rows = self._in(key) & ~done
                frame = self._frame(frames, key)
                assert frame is not None
                self.points[rows] = frame.to_global(self.local[self.first][rows])
                done |= rows

    def _keys(self, chosen: Mask) -> set[Key]:
        """Systems that nodes are given in."""
        rows = self.first[chosen]
        return set(zip(self.section[rows].tolist(), self.frames[rows].tolist(), strict=True))

    def _in(self, key: Key) -> Mask:
        own: Mask = (self.section[self.first] == key[0]) & (self.frames[self.first] == key[1])
        return own

    def _frame(self, frames: dict[Key, Frame], key: Key) -> Frame | None:
        """A system of the section, or of the main one."""
        return frames.get(key) or frames.get((0, key[1]))

    def _refuse(self, node: int) -> None:
        row = int(self.first[node])
        number, frame = self.ids[node] % SHIFT, self.frames[row]
        for grids in self.grids:
            if row < len(grids.ids):
                raise grids.deck.error(
                    int(grids.lines[row]),
                    f"GRID {number} is given in the local frame {frame} (CP), which is not there",
                )
            row -= len(grids.ids)

    def index(self, deck: Deck, nodes: Indices, section: Indices) -> Indices:
        """Indices of nodes by their identifiers; those of another section are the main one's."""
        found, there = self._find(nodes + SHIFT * section[:, None])
        if not there.all():
            other, main = self._find(nodes)
            found, there = np.where(there, found, other), there | main
        if not there.all():
            raise deck.source.failure(f"an element refers to GRID {nodes[~there][0]}, not there")
        return found

    def _find(self, ids: Indices) -> tuple[Indices, Mask]:
        place = np.searchsorted(self.ids[self.order], ids)
        found = self.order[np.minimum(place, len(self.ids) - 1)]
        return found, self.ids[found] == ids

    def contents(self, points: Array) -> list[bytes]:
        """Content of every file with these (n, 3) coordinates."""
        local, moved = self.changes(points)
        first, found = 0, []
        for grids in self.grids:
            rows = slice(first, first + len(grids.ids))
            found.append(grids.patched(local[rows], moved[rows]))
            first += len(grids.ids)
        return found

    def changes(self, points: Array) -> tuple[Array, Mask]:
        """(rows, 3) coordinates of the cards in their frames, and which of them change."""
        wanted = points[self.node]
        moved = changed(self.points, points)[self.node]
        local = np.where(moved, wanted, self.local)
        if not self.frames.any():
            return local, moved
        everything = np.ones(len(points), dtype=bool)
        old, new = self.systems.at(self.points, everything), self.systems.at(points, everything)
        for key in self._keys(everything):
            if key[1] == 0:
                continue
            was, now = self._frame(old, key), self._frame(new, key)
            assert was is not None
            assert now is not None
            rows = np.flatnonzero(self._in(key)[self.node])
            if np.array_equal(was.axes, now.axes) and np.array_equal(was.origin, now.origin):
                rows = rows[moved[rows].any(axis=1)]
            own = self.local[rows]
            local[rows] = now.to_local(wanted[rows], own)
            slack = 1e-14 * (1 + np.abs(own).max(axis=1, initial=0.0, keepdims=True))
            moved[rows] = np.abs(local[rows] - own) > slack
        return local, moved


def _distinct(ids: Indices) -> tuple[Indices, Indices, Indices]:
    """Identifiers in the order of their first card, that card, and the node of every card."""
    values, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return values[order], first[order].astype(np.int64), rank[inverse.ravel()]


def _warn(nodes: _Nodes, path: Path, points: Array) -> None:
    local, moved = nodes.changes(points)
    if any(float(plain(sixteen(value))) != value for value in local[moved].tolist()):
        warnings.warn(
            f"{path.name}: moved nodes are rounded to the 16 characters of Nastran's fields",
            MeshWarning,
            stacklevel=5,
        )


def _joined(parts: dict[str, list[Indices]]) -> Cells:
    return {kind: np.concatenate(nodes) for kind, nodes in parts.items()}


def _files(path: Path, data: bytes) -> list[File]:
    """The deck and all files that it includes."""
    found: list[File] = []
    waiting, seen = [File(path, "", data, 0)], {os.path.realpath(path)}
    while waiting:
        own = waiting.pop(0)
        found.append(own)
        if len(found) > 10_000:
            raise InputError(f"{path}: includes too many files")
        end = _END.search(own.data)
        for match in _INCLUDE.finditer(own.data, 0, end.start() if end else len(own.data)):
            quoted = match[1] or match[2] or match[3] or b""
            name = "".join(line.strip() for line in decoded(quoted).splitlines())
            there = located(path, own.path, name.replace("\\", "/"))
            if there is None:
                _warn_of_missing(own.path, name)
                continue
            if os.path.realpath(there[0]) in seen:
                raise InputError(f"{own.path}: includes {there[1]}, which is included already")
            seen.add(os.path.realpath(there[0]))
            section = own.section + len(_SECTION.findall(own.data, 0, match.start()))
            waiting.append(File(*there, read_bytes(there[0]), section))
    return found


def _warn_of_missing(own: Path, name: str) -> None:
    warnings.warn(
        f"{own.name}: {name}, which it includes, is not there; what it holds is not known",
        MeshWarning,
        stacklevel=2,
    )


def _sections(deck: Deck, first: int) -> Indices:
    """(lines,) section of bulk data that each line belongs to: 0, then one a BEGIN SUPER."""
    begins = [match.start() for match in _SECTION.finditer(deck.source.data)]
    return first + np.searchsorted(np.array(begins, dtype=np.int64), deck.begins[:-1], side="right")


def _default_frame(deck: Deck) -> int:
    """Frame (CP) of the GRIDs that name none, from a GRDSET card."""
    lines = deck.cards("GRDSET")[:1]
    return int(integers(deck, lines, deck.fields(lines)[:, 1]).sum())


def _grids(deck: Deck, relative: str, frame: int, section: Indices) -> Grids:
    small, large = deck.cards("GRID"), deck.cards("GRID", star=True)
    lines = np.sort(np.concatenate([small, large]))
    is_large = np.isin(lines, large)
    fields = grid_fields(deck, lines, is_large)
    ids = integers(deck, lines, fields[:, 0])
    frames = integers(deck, lines, fields[:, 1])
    frames = np.where((fields[:, 1] == BLANK).all(axis=1), frame, frames)
    points = np.stack([reals(deck, lines, fields[:, 2 + axis]) for axis in range(3)], axis=1)
    return Grids(deck, relative, ids, points, lines, is_large, frames, section[lines])
