"""Medit meshes (.mesh as text, .meshb binary).

1. A file is keywords with a count and as many records behind each; a record ends in a
   reference, a number by which users tell parts apart: each is a marker.
2. In a binary file a keyword is a number, with the place of the next one and a count behind it.

Source: P. Frey, "MEDIT: an interactive mesh visualization software" (INRIA RT-0253), and libMeshb.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells, dimension

KINDS = {  # keyword -> its number in binary files, type, nodes
    "Edges": (5, "line", 2),
    "Triangles": (6, "triangle", 3),
    "Quadrilaterals": (7, "quad", 4),
    "Tetrahedra": (8, "tetra", 4),
    "Prisms": (9, "wedge", 6),
    "Hexahedra": (10, "hexahedron", 8),
    "Pyramids": (49, "pyramid", 5),
}
NAMES = ("vertices", "edges", "surface", "volume")
DIMENSION, VERTICES, END = 3, 4, 54
_WORD = re.compile(rb"(?<!\S)[A-Za-z_]\w*")
_COMMENT = re.compile(rb"#[^\n]*")


class Part(NamedTuple):
    """Nodes of elements of a type, from 0, and their references."""

    kind: str
    nodes: Indices
    references: Indices


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Medit mesh; see `read_mesh`."""
    source = Source(path, data)
    binary = data[:4] in (b"\1\0\0\0", b"\0\0\0\1")
    reader: _Binary | _Text = _Binary(source) if binary else _Text(source)
    template, axes = reader.nodes()
    progress(0.5)
    return _mesh(source, template, axes, reader.parts(len(template.original)))


def _mesh(
    source: Source, template: TextTemplate | BinaryTemplate, axes: int, parts: list[Part]
) -> Mesh:
    count = len(template.original)
    cells: Cells = {}
    markers: Markers = {}
    for part in parts:
        if part.nodes.size and not (part.nodes.min() >= 0 and part.nodes.max() < count):
            raise source.failure(f"a {part.kind} refers to a vertex not in 1 to {count}")
        if len(part.nodes):
            cells[part.kind] = part.nodes
        for reference in filter(None, np.unique(part.references).tolist()):
            name = f"{NAMES[dimension(part.kind)]} {reference}"
            markers.setdefault(name, {})[part.kind] = part.nodes[part.references == reference]
    return Mesh(template.original, cells, markers, dimension=axes, template=template)


class _Text:
    """Sections of a text: begin and end of what follows each keyword."""

    def __init__(self, source: Source) -> None:
        data = _COMMENT.sub(lambda match: b" " * len(match[0]), source.data)
        self.source, self.data = source, data
        found = list(_WORD.finditer(data))
        ends = [*(match.start() for match in found[1:]), len(data)]
        self.sections: dict[str, tuple[int, int]] = {}
        for match, end in zip(found, ends, strict=False):
            self.sections.setdefault(match[0].decode("latin-1"), (match.end(), end))

    def _words(self, name: str) -> tuple[Indices, Indices]:
        begin, end = self.sections.get(name, (0, 0))
        starts, ends = split_tokens(self.data[begin:end])
        return starts + begin, ends + begin

    def _records(self, name: str, width: int) -> tuple[Indices, Indices]:
        """(count, width) begin and end of the numbers of a section."""
        starts, ends = self._words(name)
        if not len(starts):
            raise self.source.failure(f"there is no {name} in this file: no Medit mesh?")
        place = int(starts[0])
        count = self.source.integer(self.source.data[place : ends[0]], place, f"count of {name}")
        if len(starts) - 1 != count * width:
            raise self.source.error(
                place, f"{count} {name} of {width} numbers are announced, found {len(starts) - 1}"
            )
        return starts[1:].reshape(count, width), ends[1:].reshape(count, width)

    def nodes(self) -> tuple[TextTemplate, int]:
        """Template of the vertices, and their dimension."""
        starts, ends = self._words("Dimension")
        text = self.source.data[starts[0] : ends[0]] if len(starts) else b"3"
        axes = self.source.integer(text, int(starts[0]) if len(starts) else 0, "Dimension")
        if axes not in (2, 3):
            raise self.source.failure(f"Dimension must be 2 or 3, not {axes}")
        starts, ends = self._records("Vertices", axes + 1)
        starts, ends = starts[:, :axes], ends[:, :axes]
        points = np.zeros((len(starts), 3))
        points[:, :axes] = pick_numbers(self.source, starts.ravel(), ends.ravel()).reshape(-1, axes)
        return TextTemplate(self.source.data, points, starts, ends), axes

    def parts(self, count: int) -> list[Part]:
        """Elements by type."""
        found = []
        for name, (_, kind, size) in KINDS.items():
            if name in self.sections:
                starts, ends = self._records(name, size + 1)
                flat = pick_numbers(self.source, starts.ravel(), ends.ravel(), np.int64)
                table = flat.reshape(-1, size + 1)
                found.append(Part(kind, table[:, :size] - 1, table[:, size]))
        return found


class _Binary:
    """Sections of a binary file: place and number of records of each keyword."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.order = "<" if source.data[:1] == b"\1" else ">"
        self.at = 4
        version = self._integer("i4")
        if version not in (1, 2, 3, 4):
            raise source.failure(f"version {version} of the binary format is not known")
        self.real = np.dtype(self.order + ("f4" if version == 1 else "f8"))
        self.place = "i4" if version < 3 else "i8"
        self.int = np.dtype(self.order + ("i4" if version < 4 else "i8"))
        self.sections: dict[int, int] = {}
        while self.at < len(source.data):
            code, following = self._integer("i4"), self._integer(self.place)
            if code == END:
                break
            self.sections.setdefault(code, self.at)
            if following == 0:
                break
            if not self.at <= following <= len(source.data):
                raise source.failure("the place of a section is damaged")
            self.at = following

    def _integer(self, kind: str) -> int:
        dtype = np.dtype(self.order + kind)
        if self.at + dtype.itemsize > len(self.source.data):
            raise self.source.failure("the file ends too early")
        value = int(np.frombuffer(self.source.data, dtype, 1, self.at)[0])
        self.at += dtype.itemsize
        return value

    def _records(self, code: int, record: np.dtype) -> tuple[int, int]:
        """Number of records of a section and where the first one begins."""
        if code not in self.sections:
            raise self.source.failure("there are no vertices in this file")
        self.at = self.sections[code]
        count = self._integer(self.int.str[1:])
        if not 0 <= count * record.itemsize <= len(self.source.data) - self.at:
            raise self.source.failure(f"the file ends before its {count} records")
        return count, self.at

    def nodes(self) -> tuple[BinaryTemplate, int]:
        """Template of the vertices, and their dimension."""
        axes = 3
        if DIMENSION in self.sections:
            self.at = self.sections[DIMENSION]
            axes = self._integer("i4")
        if axes not in (2, 3):
            raise self.source.failure(f"Dimension must be 2 or 3, not {axes}")
        record = np.dtype([("x", self.real, (axes,)), ("r", self.int)])
        count, begin = self._records(VERTICES, record)
        with np.errstate(invalid="ignore"):
            found = np.frombuffer(self.source.data, record, count, begin)["x"].astype(np.float64)
        if not np.isfinite(found).all():
            raise self.source.failure("a vertex has a coordinate that is not finite")
        points = np.zeros((count, 3))
        points[:, :axes] = found
        places = begin + record.itemsize * np.arange(count)[:, None]
        places = places + self.real.itemsize * np.arange(axes)
        return BinaryTemplate(self.source.data, points, self.real, places), axes

    def parts(self, count: int) -> list[Part]:
        """Elements by type."""
        found = []
        for code, kind, size in KINDS.values():
            if code in self.sections:
                record = np.dtype([("n", self.int, (size,)), ("r", self.int)])
                many, begin = self._records(code, record)
                table = np.frombuffer(self.source.data, record, many, begin)
                nodes = table["n"].astype(np.int64).reshape(many, size) - 1
                found.append(Part(kind, nodes, table["r"].astype(np.int64)))
        return found
