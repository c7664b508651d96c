"""The ASCII layouts of Gmsh meshes."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.gmsh import NAMES, Elements, Nodes
from ffdstudio.meshes.formats.gmsh_periodic import Periodic, in_text
from ffdstudio.meshes.formats.number_table import Rows, read_rows
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source


class _Text:
    """Sections of a file as tables of numbers."""

    COUNTS_MAP = False  # whether $Periodic counts the coefficients of its maps

    def __init__(self, source: Source, sections: dict[str, tuple[int, int]]) -> None:
        self.source, self.sections = source, sections

    def rows(self, dtype: type, *names: str) -> Rows:
        """Lines of numbers of the first of these sections that is there."""
        for name in names:
            if name in self.sections:
                begin, end = self.sections[name]
                rows = read_rows(self.source, begin, end, dtype, spans=dtype is np.float64)
                if not len(rows):
                    raise self.source.error(begin, f"section ${name} is empty")
                return rows
        raise self.source.failure(f"there is no section ${names[0]}")

    def template(self, rows: Rows, where: Indices) -> TextTemplate:
        """Template whose coordinates are these (n, 3) numbers of the table."""
        points = rows.values[where]
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            place = int(rows.starts[where[bad[0], 0]])
            raise self.source.error(place, "a coordinate is not a finite number")
        return TextTemplate(self.source.data, points, rows.starts[where], rows.ends[where])

    def periodic(self) -> list[Periodic]:
        """Read the pairs of entities whose nodes correspond."""
        if "Periodic" not in self.sections:
            return []
        return in_text(self.source, *self.sections["Periodic"], new=self.COUNTS_MAP)

    def check_type(self, number: int, place: int) -> None:
        """Raise if Gmsh's number of a type is not known."""
        if number not in NAMES:
            raise self.source.error(place, f"elements of Gmsh's type {number} are not supported")


class Old(_Text):
    """MSH 1.0 and 2.x: a line a node, a line an element."""

    def __init__(self, source: Source, sections: dict[str, tuple[int, int]], version: int) -> None:
        super().__init__(source, sections)
        self.version = version

    def _table(self, rows: Rows, width: int, what: str) -> Indices:
        """First number of every line behind the first one, which counts them."""
        if rows.values[0] != len(rows) - 1:
            raise self.source.error(
                int(rows.places[0]),
                f"{rows.values[0]:g} {what} are announced, but {len(rows) - 1} lines follow",
            )
        short = np.flatnonzero(rows.widths[1:] < width)
        if len(short):
            place = int(rows.places[1 + short[0]])
            raise self.source.error(place, f"a line of {what} needs {width} numbers or more")
        return rows.first[1:-1]

    def nodes(self) -> Nodes:
        """Read the nodes."""
        rows = self.rows(np.float64, "Nodes", "NOD", "ParametricNodes")
        first = self._table(rows, 4, "nodes")
        wide = np.flatnonzero(rows.widths[1:] > 4)
        if len(wide) and "ParametricNodes" not in self.sections:
            place = int(rows.places[1 + wide[0]])
            raise self.source.error(place, "a node has an index and three coordinates")
        template = self.template(rows, first[:, None] + np.arange(1, 4))
        return Nodes(rows.values[first].astype(np.int64), template)

    def entities(self) -> dict[tuple[int, int], list[int]]:
        """Read the physical tags of the entities."""
        return {}

    def elements(self) -> list[Elements]:
        """Read the elements."""
        rows = self.rows(np.int64, "Elements", "ELM")
        first = self._table(rows, 4, "elements")
        types = rows.values[first + 1]
        if self.version == 1:
            tags = np.full(len(first), 2)
            skipped, group = 5, first + 2
        else:
            tags = rows.values[first + 2]
            skipped, group = 3, first + 3
        found = []
        width = rows.widths[1:]
        for key in np.unique(np.stack([types, tags, width], axis=1), axis=0).tolist():
            chosen = np.flatnonzero((types == key[0]) & (tags == key[1]) & (width == key[2]))
            place = int(rows.places[1 + chosen[0]])
            self.check_type(key[0], place)
            begin = skipped if self.version == 1 else skipped + key[1]
            count = NAMES[key[0]][1]
            if key[1] < 0 or begin + count != key[2]:
                raise self.source.error(
                    place, f"a {NAMES[key[0]][0]} has {count} nodes, found {key[2] - begin}"
                )
            nodes = rows.values[first[chosen][:, None] + np.arange(begin, begin + count)]
            none = np.zeros(len(chosen), dtype=np.int64)
            groups = rows.values[group[chosen]] if key[1] else none
            owners = rows.values[group[chosen] + 1] if key[1] > 1 else none
            found.append(Elements(key[0], nodes, groups, owners=owners))
        return found


class New(_Text):
    """MSH 4.1: blocks by entity."""

    COUNTS_MAP = True
    ENTITY = 1  # where the head of a block has the tag of its entity
    COUNTS = 4  # numbers in the first line of a section
    POINT = 3  # numbers that tell where a point is

    def _blocks(self, rows: Rows, lines: int, what: str) -> list[tuple[Indices, Indices]]:
        """Header of every block and its rows; `lines` is the number of lines an item."""
        header = rows.values[: rows.first[1]]
        if len(header) != self.COUNTS:
            raise self.source.error(
                int(rows.places[0]), f"the {what} need a line of {self.COUNTS} counts"
            )
        found, at = [], 1
        while at < len(rows):
            head = rows.values[rows.first[at] : rows.first[at + 1]]
            if len(head) != 4 or not 0 <= head[3] <= len(rows):
                raise self.source.error(int(rows.places[at]), "expected the head of a block")
            count = int(head[3]) * lines
            if at + 1 + count > len(rows):
                raise self.source.error(int(rows.places[at]), "the section ends within this block")
            found.append((head, np.arange(at + 1, at + 1 + count)))
            at += 1 + count
        total = sum(int(head[3]) for head, _ in found)
        if header[0] != len(found) or header[1] != total:
            raise self.source.error(
                int(rows.places[0]),
                f"{header[0]:g} blocks with {header[1]:g} {what} are announced, "
                f"found {len(found)} with {total}",
            )
        return found

    def nodes(self) -> Nodes:
        """Read the nodes."""
        rows = self.rows(np.float64, "Nodes")
        tags, places = [np.empty(0, dtype=np.int64)], [np.empty((0, 3), dtype=np.int64)]
        for head, part in self._blocks(rows, 2, "nodes"):
            half = int(head[3])
            tag_rows, point_rows = part[:half], part[half:]
            odd = np.flatnonzero(rows.widths[tag_rows] != 1)
            short = np.flatnonzero(rows.widths[point_rows] < 3)
            if len(odd) or len(short):
                bad = tag_rows[odd[0]] if len(odd) else point_rows[short[0]]
                raise self.source.error(int(rows.places[bad]), "not the line of a node")
            tags.append(rows.values[rows.first[tag_rows]].astype(np.int64))
            places.append(rows.first[point_rows][:, None] + np.arange(3))
        return Nodes(np.concatenate(tags), self.template(rows, np.concatenate(places)))

    def elements(self) -> list[Elements]:
        """Read the elements."""
        rows = self.rows(np.int64, "Elements")
        found = []
        for head, part in self._blocks(rows, 1, "elements"):
            number = int(head[2])
            self.check_type(number, int(rows.places[part[0] - 1]) if len(part) else 0)
            width = 1 + NAMES[number][1]
            odd = np.flatnonzero(rows.widths[part] != width)
            if len(odd):
                raise self.source.error(
                    int(rows.places[part[odd[0]]]), f"a {NAMES[number][0]} has {width - 1} nodes"
                )
            nodes = rows.values[rows.first[part][:, None] + np.arange(1, width)]
            found.append(
                Elements(
                    number, nodes, np.zeros(len(nodes), dtype=np.int64), int(head[self.ENTITY])
                )
            )
        return found

    def entities(self) -> dict[tuple[int, int], list[int]]:
        """Read the physical tags of the entities."""
        found: dict[tuple[int, int], list[int]] = {}
        for name in ("Entities", "PartitionedEntities"):
            if name not in self.sections:
                continue
            rows = read_rows(self.source, *self.sections[name])
            at = 0
            if name == "PartitionedEntities" and len(rows) > 2:  # partitions, ghosts, then as above
                at = 2 + int(rows.values[rows.first[1]])
            if not 0 <= at < len(rows) or rows.widths[at] != 4:
                raise self.source.failure(f"section ${name} must begin with four counts")
            self._take_entities(rows, at, found, at > 0)
        return found

    def _take_entities(
        self, rows: Rows, at: int, found: dict[tuple[int, int], list[int]], divided: bool
    ) -> None:
        """Add the physical tags behind the counts in a row."""
        counts = rows.values[rows.first[at] : rows.first[at + 1]].astype(np.int64)
        at += 1
        for dim, count in enumerate(counts.tolist()):
            for row in range(at, min(at + count, len(rows))):
                words = rows.values[rows.first[row] : rows.first[row + 1]]
                skipped = 1 + (self.POINT if dim == 0 else 6)  # the tag and where it lies
                if divided and len(words) > 3:  # its parent and partitions
                    skipped += 3 + max(int(words[3]), 0)
                many = int(words[skipped]) if len(words) > skipped else 0
                groups = words[skipped + 1 : skipped + 1 + max(many, 0)]
                found[dim, int(words[0])] = groups.astype(np.int64).tolist()
            at += max(count, 0)
