"""Section $Periodic of Gmsh meshes: which nodes of one entity correspond to those of another.

1. A link names the dimension, an entity and its master, maybe an affine map, then pairs of
   nodes. Before 4.1 the section is text in binary files, too, but for 4.0.
2. Entities of fewer dimensions are listed as well; those whose nodes are in links of more
   dimensions are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.links import Link

Find = Callable[[Indices], Indices]
_KINDS = ("point", "curve", "surface", "volume")


class Periodic(NamedTuple):
    """An entity, its master, and (k, 2) tags of nodes and of their masters."""

    dimension: int
    entity: int
    master: int
    nodes: Indices


def links_of(
    periodic: list[Periodic], find: Find, titles: dict[tuple[int, int], str]
) -> Iterator[Link]:
    """Links by node index, master first; `titles` has names of entities."""
    covered = np.empty(0, dtype=np.int64)
    for row in sorted(periodic, key=lambda row: -row.dimension):
        slaves = row.nodes[:, 0]
        if not len(slaves) or np.isin(slaves, covered).all():
            continue
        covered = np.union1d(covered, slaves)
        names = [
            titles.get((row.dimension, tag), f"{_KINDS[row.dimension]} {tag}")
            for tag in (row.master, row.entity)
        ]
        yield Link(tuple(dict.fromkeys(names)), find(row.nodes[:, 1]), find(slaves))


def in_text(source: Source, begin: int, end: int, new: bool) -> list[Periodic]:
    """Links of a section in text; the `new` form of 4.1 counts the map's coefficients."""
    words = source.data[begin:end].split()
    walk = _Words(source, begin, words)
    found = []
    for _ in range(walk.count()):
        dim, entity, master = (walk.integer() for _ in range(3))
        if walk.peek() == b"Affine":
            walk.skip(17)
        elif new:
            walk.skip(walk.count())
        many = walk.count()
        nodes = np.array(walk.integers(2 * many), dtype=np.int64).reshape(many, 2)
        if 0 <= dim < len(_KINDS):
            found.append(Periodic(dim, entity, master, nodes))
    return found


class _Words:
    """Words of a section one after the other."""

    def __init__(self, source: Source, place: int, words: list[bytes]) -> None:
        self.source, self.place, self.words, self.at = source, place, words, 0

    def peek(self) -> bytes:
        return self.words[self.at] if self.at < len(self.words) else b""

    def skip(self, count: int) -> None:
        self.at += count

    def integer(self) -> int:
        return self.integers(1)[0]

    def integers(self, count: int) -> list[int]:
        words = self.words[self.at : self.at + count]
        self.at += count
        try:
            found = [int(word) for word in words]
        except ValueError:
            found = []
        if len(found) != count or any(abs(number) >= 2**62 for number in found):
            raise self.source.error(self.place, "section $Periodic is damaged")
        return found

    def count(self) -> int:
        value = self.integer()
        if not 0 <= value <= len(self.source.data):
            raise self.source.error(self.place, "section $Periodic is damaged")
        return value
