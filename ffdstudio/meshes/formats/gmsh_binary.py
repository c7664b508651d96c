"""The binary layouts of Gmsh meshes."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.meshes.formats.gmsh import NAMES, Elements, Nodes, finite
from ffdstudio.meshes.formats.gmsh_periodic import Periodic, in_text
from ffdstudio.meshes.formats.patch import BinaryTemplate
from ffdstudio.meshes.formats.source import Source


class _Binary:
    """Goes through the bytes of a section."""

    def __init__(self, source: Source, sections: dict[str, tuple[int, int]], order: str) -> None:
        self.source, self.sections, self.order = source, sections, order
        self.int, self.real = np.dtype(order + "i4"), np.dtype(order + "f8")
        self.at = self.end = 0
        self.name = ""

    def enter(self, name: str) -> None:
        """Go to the begin of a section."""
        if name not in self.sections:
            raise self.source.failure(f"there is no section ${name}")
        self.name = name
        self.at, self.end = self.sections[name]

    def place(self, count: int, size: int) -> int:
        """Place of the next `count` records of `size` bytes; moves on behind them."""
        begin, self.at = self.at, self.at + count * size
        if count < 0 or self.at > self.end:
            raise self.source.failure(f"section ${self.name} ends too early")
        return begin

    def numbers(self, count: int, dtype: np.dtype) -> AnyArray:
        """Next numbers of a type."""
        return np.frombuffer(
            self.source.data, dtype, count, self.place(count, dtype.itemsize) if count else 0
        )

    def count_line(self) -> int:
        """Count in a line of text."""
        begin, self.at = self.at, self.source.line_end(self.at)
        return self.source.integer(self.source.data[begin : self.at].strip(), begin, "a count")

    def periodic(self) -> list[Periodic]:
        """Read the pairs of entities whose nodes correspond; text in these files."""
        if "Periodic" not in self.sections:
            return []
        return in_text(self.source, *self.sections["Periodic"], new=False)

    def check_type(self, number: int) -> int:
        """Number of nodes of Gmsh's type of element."""
        if number not in NAMES:
            raise self.source.failure(f"elements of Gmsh's type {number} are not supported")
        return NAMES[number][1]

    def template(self, places: Indices, tags: Indices) -> BinaryTemplate:
        """Template whose x, y, z follow each other from these places on."""
        columns = places[:, None] + 8 * np.arange(3)
        raw = np.frombuffer(self.source.data, dtype=np.uint8)
        points = raw[columns[:, :, None] + np.arange(8)].view(self.real)[:, :, 0]
        points = finite(self.source, points.astype(np.float64), tags)
        return BinaryTemplate(self.source.data, points, self.real, columns)


class Old(_Binary):
    """MSH 2.x."""

    def nodes(self) -> Nodes:
        """Read the nodes."""
        self.enter("Nodes")
        count = self.count_line()
        record = np.dtype([("tag", self.int), ("xyz", self.real, 3)])
        begin = self.place(count, record.itemsize)
        tags = np.frombuffer(self.source.data, record, count, begin)["tag"].astype(np.int64)
        places = begin + 4 + record.itemsize * np.arange(count)
        return Nodes(tags, self.template(places, tags))

    def entities(self) -> dict[tuple[int, int], list[int]]:
        """Read the physical tags of the entities."""
        return {}

    def elements(self) -> list[Elements]:
        """Read the elements."""
        self.enter("Elements")
        left, found = self.count_line(), []
        while left > 0:
            number, count, tags = (int(n) for n in self.numbers(3, self.int))
            nodes = self.check_type(number)
            if not 0 < count <= left or not 0 <= tags <= 1000:
                raise self.source.failure("section $Elements has a damaged head of a block")
            if count == 1:
                table = self._single(1 + tags + nodes, left)
                count = len(table)
            else:
                table = self.numbers(count * (1 + tags + nodes), self.int).reshape(count, -1)
            table = table.astype(np.int64)
            groups, owners = (
                table[:, k] if tags >= k else np.zeros(count, dtype=np.int64) for k in (1, 2)
            )
            found.append(Elements(number, table[:, 1 + tags :], groups, owners=owners))
            left -= count
        return _merged(found)

    def _single(self, width: int, most: int) -> AnyArray:
        """Run of blocks of one element that have the head just read: most writers make these."""
        begin = self.at - 12
        size = 4 * (3 + width)
        most = min(most, (self.end - begin) // size)
        if most < 1:
            self.place(1, 4 * width)
        table = np.frombuffer(self.source.data, self.int, most * (3 + width), begin)
        table = table.reshape(most, -1)
        other = np.flatnonzero((table[:, :3] != table[0, :3]).any(axis=1))
        count = int(other[0]) if len(other) else most
        self.at = begin + count * size
        return table[:count, 3:]


class New(_Binary):
    """MSH 4.1."""

    def __init__(
        self, source: Source, sections: dict[str, tuple[int, int]], order: str, size: int
    ) -> None:
        super().__init__(source, sections, order)
        self.size = np.dtype(f"{order}u{size}")

    def periodic(self) -> list[Periodic]:
        """Read the pairs of entities whose nodes correspond."""
        if "Periodic" not in self.sections:
            return []
        self.enter("Periodic")
        found = []
        for _ in range(int(self.numbers(1, self.size)[0])):
            dim, entity, master = (int(n) for n in self.numbers(3, self.int))
            self.place(int(self.numbers(1, self.size)[0]), 8)
            many = int(self.numbers(1, self.size)[0])
            nodes = self.numbers(2 * many, self.size).astype(np.int64).reshape(many, 2)
            if 0 <= dim <= 3:
                found.append(Periodic(dim, entity, master, nodes))
        return found

    def _head(self) -> tuple[int, int, int, int]:
        first, second, third = (int(n) for n in self.numbers(3, self.int))
        return first, second, third, int(self.numbers(1, self.size)[0])

    def nodes(self) -> Nodes:
        """Read the nodes."""
        self.enter("Nodes")
        blocks, total, *_ = (int(n) for n in self.numbers(4, self.size))
        tags, places = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
        for _ in range(blocks):
            dim, _, parametric, count = self._head()
            if not 0 <= dim <= 3:
                raise self.source.failure("section $Nodes has a damaged head of a block")
            tags.append(self.numbers(count, self.size).astype(np.int64))
            width = 8 * (3 + (dim if parametric else 0))
            begin = self.place(count, width)
            places.append(begin + width * np.arange(count))
        all_tags = np.concatenate(tags)
        if len(all_tags) != total:
            raise self.source.failure(f"{total} nodes are announced, found {len(all_tags)}")
        return Nodes(all_tags, self.template(np.concatenate(places), all_tags))

    def elements(self) -> list[Elements]:
        """Read the elements."""
        self.enter("Elements")
        blocks, total, *_ = (int(n) for n in self.numbers(4, self.size))
        found = []
        for _ in range(blocks):
            _, entity, number, count = self._head()
            width = 1 + self.check_type(number)
            table = self.numbers(count * width, self.size).astype(np.int64).reshape(-1, width)
            found.append(Elements(number, table[:, 1:], np.zeros(count, dtype=np.int64), entity))
        if sum(len(part.nodes) for part in found) != total:
            raise self.source.failure(f"{total} elements are announced, not as many found")
        return found

    def entities(self) -> dict[tuple[int, int], list[int]]:
        """Read the physical tags of the entities."""
        found: dict[tuple[int, int], list[int]] = {}
        if "Entities" in self.sections:
            self.enter("Entities")
            self._take_entities(found, False)
        if "PartitionedEntities" in self.sections:
            self.enter("PartitionedEntities")
            _, ghosts = (int(n) for n in self.numbers(2, self.size))
            self.numbers(2 * ghosts, self.int)
            self._take_entities(found, True)
        return found

    def _take_entities(self, found: dict[tuple[int, int], list[int]], divided: bool) -> None:
        """Add the physical tags of what follows."""
        for dim, count in enumerate([int(n) for n in self.numbers(4, self.size)]):
            for _ in range(count):
                tag = int(self.numbers(1, self.int)[0])
                if divided:  # its parent and partitions
                    self.numbers(2, self.int)
                    self._list()
                self.place(3 if dim == 0 else 6, 8)
                found[dim, tag] = self._list()
                if dim:
                    self._list()

    def _list(self) -> list[int]:
        """Count and as many numbers."""
        return [int(n) for n in self.numbers(int(self.numbers(1, self.size)[0]), self.int)]


def _merged(parts: list[Elements]) -> list[Elements]:
    """Blocks of the same type joined: a writer may give each element a block of its own."""
    by_type: dict[int, list[Elements]] = {}
    for part in parts:
        by_type.setdefault(part.type, []).append(part)
    return [
        Elements(
            number,
            np.concatenate([part.nodes for part in same]),
            np.concatenate([part.groups for part in same]),
            owners=np.concatenate([part.owners for part in same if part.owners is not None]),
        )
        for number, same in by_type.items()
    ]
