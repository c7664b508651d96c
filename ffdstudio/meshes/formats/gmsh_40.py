"""MSH 4.0, ASCII and binary: as 4.1, but each node stands beside its tag.

The tag of an entity comes before its dimension in the head of a block, a point has a box like
all other entities, and tags are whole numbers of four bytes.
"""

from __future__ import annotations

import warnings

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats import gmsh_binary, gmsh_text
from ffdstudio.meshes.formats.gmsh import Elements, Nodes
from ffdstudio.meshes.formats.gmsh_periodic import Periodic
from ffdstudio.meshes.mesh import MeshWarning


class Text(gmsh_text.New):
    """MSH 4.0 as text."""

    COUNTS_MAP = False
    ENTITY = 0
    COUNTS = 2
    POINT = 6

    def nodes(self) -> Nodes:
        """Read the nodes."""
        rows = self.rows(np.float64, "Nodes")
        parts = [np.empty(0, dtype=np.int64)]
        for _, part in self._blocks(rows, 1, "nodes"):
            short = np.flatnonzero(rows.widths[part] < 4)
            if len(short):
                raise self.source.error(int(rows.places[part[short[0]]]), "not the line of a node")
            parts.append(rows.first[part])
        first = np.concatenate(parts)
        tags = rows.values[first].astype(np.int64)
        return Nodes(tags, self.template(rows, first[:, None] + np.arange(1, 4)))


class Binary(gmsh_binary.New):
    """MSH 4.0 with raw numbers."""

    def _count(self) -> int:
        return int(self.numbers(1, self.size)[0])

    def nodes(self) -> Nodes:
        """Read the nodes."""
        self.enter("Nodes")
        blocks, total = self._count(), self._count()
        tags, places = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
        for _ in range(blocks):
            _, dim, parametric, many = self._head()
            if not 0 <= dim <= 3:
                raise self.source.failure("section $Nodes has a damaged head of a block")
            width = 4 + 8 * (3 + (dim if parametric else 0))
            record = np.dtype([("tag", self.int), ("rest", f"V{width - 4}")])
            begin = self.place(many, width)
            found = np.frombuffer(self.source.data, record, many, begin)["tag"]
            tags.append(found.astype(np.int64))
            places.append(begin + 4 + width * np.arange(many))
        all_tags = np.concatenate(tags)
        if len(all_tags) != total:
            raise self.source.failure(f"{total} nodes are announced, found {len(all_tags)}")
        return Nodes(all_tags, self.template(np.concatenate(places), all_tags))

    def elements(self) -> list[Elements]:
        """Read the elements."""
        self.enter("Elements")
        blocks, total = self._count(), self._count()
        found = []
        for _ in range(blocks):
            entity, _, number, many = self._head()
            width = 1 + self.check_type(number)
            table = self.numbers(many * width, self.int).astype(np.int64).reshape(-1, width)
            found.append(Elements(number, table[:, 1:], np.zeros(many, dtype=np.int64), entity))
        if sum(len(part.nodes) for part in found) != total:
            raise self.source.failure(f"{total} elements are announced, not as many found")
        return found

    def entities(self) -> dict[tuple[int, int], list[int]]:
        """Read the physical tags of the entities."""
        found: dict[tuple[int, int], list[int]] = {}
        if "Entities" in self.sections:
            self.enter("Entities")
            counts: Indices = self.numbers(4, self.size)
            for dim, many in enumerate(counts.tolist()):
                for _ in range(many):
                    tag = int(self.numbers(1, self.int)[0])
                    self.place(6, 8)
                    found[dim, tag] = self._list()
                    if dim:
                        self._list()
        return found

    def periodic(self) -> list[Periodic]:
        """Say that they are not read from these files, which no writer makes any more."""
        if "Periodic" in self.sections:
            warnings.warn(
                f"{self.source.path.name}: the periodic pairs of a binary file of version 4.0 are "
                "kept but not known",
                MeshWarning,
                stacklevel=2,
            )
        return []
