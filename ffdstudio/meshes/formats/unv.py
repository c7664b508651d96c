"""Universal files (.unv) of I-DEAS, Salome, Code_Aster and others.

1. A file is datasets between lines with -1: nodes (2411, 781), elements (2412, 780) and groups
   (2467, 2477, 2452, 2435, 2432, 2430, 2429); all others are kept and not looked at.
2. Coordinates have columns of 25 characters. A node that moves gets a whole line of these, with
   all digits that a double has.

Source: Siemens, "Universal file datasets".
"""

from __future__ import annotations

import re
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.patch import changed
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells

NODES, ELEMENTS = (2411, 781), (2412, 780)
GROUPS = (2467, 2477, 2452, 2435, 2432, 2430, 2429)
BEAMS = (11, 21, 22, 23, 24)  # with a line of three numbers more
RING6, RING8 = [0, 2, 4, 1, 3, 5], [0, 2, 4, 6, 1, 3, 5, 7]
KINDS: dict[int, tuple[str, list[int]]] = {  # number -> type, nodes in VTK's order
    **dict.fromkeys((11, 21, 22), ("line", [0, 1])),
    **dict.fromkeys((23, 24), ("line3", [0, 2, 1])),
    **dict.fromkeys((41, 51, 61, 74, 81, 91), ("triangle", [0, 1, 2])),
    **dict.fromkeys((42, 52, 62, 72, 82, 92), ("triangle6", RING6)),
    **dict.fromkeys((44, 54, 64, 71, 84, 94), ("quad", [0, 1, 2, 3])),
    **dict.fromkeys((45, 55, 65, 75, 85, 95), ("quad8", RING8)),
    111: ("tetra", [0, 1, 2, 3]),
    118: ("tetra10", [0, 2, 4, 9, 1, 3, 5, 6, 7, 8]),
    112: ("wedge", [0, 1, 2, 3, 4, 5]),
    113: ("wedge15", [0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8]),
    115: ("hexahedron", [0, 1, 2, 3, 4, 5, 6, 7]),
    116: (
        "hexahedron20",
        [0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11],
    ),
}
_MARK = re.compile(rb"^[ \t]*-1[ \t]*\r?$", re.M)


class Dataset(NamedTuple):
    """Number of a dataset, and begin and end of its lines."""

    number: int
    begin: int
    end: int


@dataclass(frozen=True, eq=False)
class UnvTemplate:
    """A universal file with the places of the lines of its coordinates: (n, 2)."""

    data: bytes
    original: Array
    lines: Indices

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates."""
        rows = np.flatnonzero(changed(self.original, points).any(axis=1))
        pieces, at = [], 0
        for row in rows[np.argsort(self.lines[rows, 0], kind="stable")].tolist():
            begin, end = self.lines[row].tolist()
            letter = "D" if b"D" in self.data[begin:end] else "E"
            text = "".join(f"{value:25.16E}" for value in points[row].tolist())
            pieces += [self.data[at:begin], text.replace("E", letter).encode()]
            at = end
        return b"".join([*pieces, self.data[at:]])

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file."""
        write_bytes(path, self.patched(points))


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a universal file; see `read_mesh`."""
    source = Source(path, data)
    sets = _datasets(source)
    reader = _Reader(source)
    for row in sets:
        if row.number in NODES:
            reader.nodes(row)
    if not reader.labels:
        raise source.failure("there is no dataset 2411 of nodes in this file")
    for row in sets:
        if row.number in ELEMENTS:
            reader.elements(row)
    progress(0.7)
    for row in sets:
        if row.number in GROUPS:
            reader.groups(row)
    return reader.mesh()


def _datasets(source: Source) -> list[Dataset]:
    marks = list(_MARK.finditer(source.data))
    if len(marks) % 2:
        raise source.error(marks[-1].start(), "a dataset does not end")
    found = []
    for first, last in zip(marks[::2], marks[1::2], strict=False):
        head = source.line_end(first.end())
        end = source.line_end(head)
        word = source.data[head:end].split()[:1] or [b""]
        number = source.integer(word[0].rstrip(b"bB"), head, "the number of a dataset")
        found.append(Dataset(number, end, last.start()))
    return found


class _Reader:
    """What the datasets of a file add up to."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.labels: list[int] = []
        self.values: list[float] = []
        self.lines: list[tuple[int, int]] = []
        self.cells: dict[str, list[list[int]]] = {}
        self.where: dict[int, tuple[str, int]] = {}  # label of an element -> type, row
        self.unread: Counter[str] = Counter()
        self.members: dict[str, list[tuple[int, int]]] = {}  # group -> kind of entity, label
        self.index: dict[int, int] = {}

    def _lines(self, row: Dataset) -> list[tuple[int, bytes]]:
        found, at = [], row.begin
        while at < row.end:
            end = min(self.source.line_end(at), row.end)
            found.append((at, self.source.data[at:end]))
            at = end
        return found

    def _numbers(self, place: int, line: bytes) -> list[int]:
        try:
            return [int(word) for word in line.split()]
        except ValueError:
            raise self.source.error(place, "expected whole numbers") from None

    def nodes(self, row: Dataset) -> None:
        """Take a dataset of nodes: two lines each."""
        lines = self._lines(row)
        if len(lines) % 2:
            raise self.source.error(row.begin, "the last node has no coordinates")
        for (place, head), (at, line) in zip(lines[::2], lines[1::2], strict=True):
            words = line.upper().replace(b"D", b"E").split()
            try:
                self.values += [float(word) for word in words]
            except ValueError:
                words = []
            if len(words) != 3 or not np.isfinite(self.values[-3:]).all():
                raise self.source.error(at, "a node needs three coordinates")
            self.labels += self._numbers(place, head)[:1]
            self.lines.append((at, at + len(line.rstrip(b"\r\n"))))
        self.index = {label: k for k, label in enumerate(self.labels)}
        if not len(self.index) == len(self.labels) == len(self.lines):
            raise self.source.error(row.begin, "a node without a label, or one that occurs twice")

    def elements(self, row: Dataset) -> None:
        """Take a dataset of elements: a head, a line more for beams, and lines of eight nodes."""
        lines = self._lines(row)
        at = 0
        while at < len(lines):
            place, line = lines[at]
            head = self._numbers(place, line)
            at += 1
            if len(head) < 6 or head[5] < 0:
                raise self.source.error(place, "the head of an element needs six numbers")
            label, number, count = head[0], head[1], head[5]
            at += number in BEAMS
            nodes: list[int] = []
            while len(nodes) < count:
                if at >= len(lines):
                    raise self.source.error(place, f"an element of {count} nodes is incomplete")
                nodes += self._numbers(*lines[at])
                at += 1
            self._element(place, label, number, nodes)

    def _element(self, place: int, label: int, number: int, nodes: list[int]) -> None:
        kind, order = KINDS.get(number, ("", []))
        if not kind:
            self.unread[f"type {number}"] += 1
            return
        missing = [node for node in nodes if node not in self.index]
        if missing or len(nodes) != len(order):
            what = f"node {missing[0]}, which is not there" if missing else f"{len(nodes)} nodes"
            raise self.source.error(place, f"an element of type {number} has {what}")
        rows = self.cells.setdefault(kind, [])
        self.where[label] = kind, len(rows)
        rows.append([self.index[nodes[k]] for k in order])

    def groups(self, row: Dataset) -> None:
        """Take a dataset of groups: a head, a name, and entities of four numbers."""
        lines = self._lines(row)
        at, width = 0, 2 if row.number in (2429, 2430, 2432) else 4
        while at + 1 < len(lines):
            place, line = lines[at]
            head = self._numbers(place, line)
            name = decoded(lines[at + 1][1]).strip()
            at += 2
            wanted = width * max(head[-1] if head else 0, 0)
            numbers: list[int] = []
            while len(numbers) < wanted and at < len(lines):
                numbers += self._numbers(*lines[at])
                at += 1
            if len(numbers) < wanted:
                raise self.source.error(place, f"group {name} is incomplete")
            pairs = zip(numbers[::width], numbers[1::width], strict=False)
            self.members.setdefault(name or f"group {head[0]}", []).extend(pairs)

    def mesh(self) -> Mesh:
        """Mesh with the groups as markers."""
        for title, count in self.unread.items():
            warnings.warn(
                f"{self.source.path.name}: {count} elements of {title} are kept but not shown",
                MeshWarning,
                stacklevel=3,
            )
        points = np.array(self.values).reshape(-1, 3)
        cells = {kind: np.array(rows, dtype=np.int64) for kind, rows in self.cells.items()}
        return Mesh(
            points,
            cells,
            self._markers(cells),
            unread=dict(self.unread),
            template=UnvTemplate(self.source.data, points, np.array(self.lines, dtype=np.int64)),
        )

    def _markers(self, cells: Cells) -> Markers:
        markers: Markers = {}
        for name, members in self.members.items():
            found: dict[str, list[int]] = {}
            for kind, label in members:
                if kind == 8 and label in self.where:
                    own, row = self.where[label]
                    found.setdefault(own, []).append(row)
                elif kind == 7 and label in self.index:
                    found.setdefault("vertex", []).append(self.index[label])
            nodes = {
                own: np.array(rows)[:, None] if own == "vertex" else cells[own][rows]
                for own, rows in found.items()
            }
            if nodes:
                markers[name] = nodes
        return markers
