"""Cells made of faces in CGNS: sections NGON_n list faces by nodes, NFACE_n cells by faces.

Since version 3.4 a list of where each element begins stands beside the numbers; before that each
element begins with how many follow. A face that looks into its cell has a negative number.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.cgns_boundaries import Parts
from ffdstudio.meshes.formats.cgns_nodes import Node
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import offsets_of, polygon_name
from ffdstudio.meshes.measures.recognise import ramps
from ffdstudio.meshes.polyhedra import Loops

NGON, NFACE = 22, 23


class Lists:
    """Elements of any size: numbers one element after the other, and where each begins."""

    def __init__(self, source: Source, node: Node, flat: Indices, many: int) -> None:
        begins = node.child("ElementStartOffset")
        if begins is not None:
            self.offsets, self.values = begins.values().astype(np.int64), flat
        else:
            self.offsets, self.values = _counted(source, node, flat)
        sizes = np.diff(self.offsets)
        bad = len(sizes) != many or (sizes < 1).any() or self.offsets[0] != 0
        if bad or self.offsets[-1] > len(self.values):
            raise source.failure(f"section {node.name} does not have {many} elements")


def _counted(source: Source, node: Node, flat: Indices) -> tuple[Indices, Indices]:
    numbers, places, at = flat.tolist(), [], 0
    while at < len(numbers):
        if numbers[at] < 1:
            raise source.failure(f"section {node.name} has an element without nodes")
        places.append(at)
        at += 1 + numbers[at]
    heads = np.array(places, dtype=np.int64)
    return offsets_of(flat[heads]), np.delete(flat, heads)


class Polyhedra:
    """Faces and cells of a zone, as sections bring them."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.faces: list[tuple[int, Lists]] = []
        self.cells: list[Lists] = []
        self.parts: list[Parts] = []

    def take_faces(self, node: Node, begin: int, found: Lists, count: int) -> Parts:
        """Add a section of faces; these by type, as a boundary condition asks for them."""
        nodes = found.values
        if nodes.size and not (nodes.min() >= 1 and nodes.max() <= count):
            raise self.source.failure(f"section {node.name} refers to a node not in 1 to {count}")
        self.faces.append((begin, found))
        sizes = np.diff(found.offsets)
        parts: Parts = {}
        for size in np.unique(sizes).tolist():
            chosen = np.flatnonzero(sizes == size)
            rows = nodes[found.offsets[chosen][:, None] + np.arange(size)] - 1
            parts[polygon_name(size)] = rows, begin + chosen
        self.parts.append(parts)
        return parts

    def loops(self) -> Loops | None:
        """Faces as seen from the cells; None without cells."""
        if not self.cells:
            return None
        none = np.empty(0, dtype=np.int64)
        numbers = np.concatenate(
            [none, *(b + np.arange(len(x.offsets) - 1) for b, x in self.faces)]
        )
        begins, sizes, nodes = self._joined()
        asked = np.abs(np.concatenate([cell.values[: cell.offsets[-1]] for cell in self.cells]))
        order = np.argsort(numbers)
        place = np.searchsorted(numbers, asked, sorter=order)
        if not len(numbers) or (numbers[order[np.minimum(place, len(order) - 1)]] != asked).any():
            raise self.source.failure("a cell refers to a face that is in no section NGON_n")
        face = order[place]
        count = np.concatenate([np.diff(cell.offsets) for cell in self.cells])
        size = sizes[face]
        at = np.repeat(begins[face], size) + ramps(size)
        return Loops(nodes[at] - 1, size, np.repeat(np.arange(len(count)), count))

    def _joined(self) -> tuple[Indices, Indices, Indices]:
        """Where the faces of all sections begin, their sizes, and all nodes."""
        first = offsets_of(np.array([len(x.values) for _, x in self.faces], dtype=np.int64))
        begins = [x.offsets[:-1] + f for (_, x), f in zip(self.faces, first, strict=False)]
        sizes = [np.diff(x.offsets) for _, x in self.faces]
        none = np.empty(0, dtype=np.int64)
        parts = (begins, sizes, [x.values for _, x in self.faces])
        joined = [np.concatenate([none, *part]) for part in parts]
        return joined[0], joined[1], joined[2]
