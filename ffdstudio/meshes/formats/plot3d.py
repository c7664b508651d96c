"""PLOT3D grids of structured blocks, ASCII and binary.

1. A file does not say what it is: with or without a count of blocks, in two or three
   dimensions, with or without blanking, and if binary, with which byte order, real and record
   marks. The reading whose size fits the file exactly is the right one.
2. Each block holds all x, then all y, then all z; the first index runs fastest.

Source: NASA, "PLOT3D User's Manual" (TM-101067).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import pick_anywhere, split_tokens
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate
from ffdstudio.meshes.formats.plot3d_repeats import Repeats, RepeatTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import block_cells, offsets_of
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells

MOST_BLOCKS = 100_000


class Reading(NamedTuple):
    """A way to understand the file: (blocks, axes) nodes, and values a node with blanking."""

    header: int  # numbers or bytes before the first block
    shapes: Indices
    columns: int  # 2 or 3 coordinates, one more with blanking
    order: str = ""
    real: int = 8
    marks: int = 0  # bytes of a record mark
    apart: bool = False  # whether each coordinate is a record of its own

    @property
    def axes(self) -> int:
        """Coordinates of a node."""
        result: int = self.shapes.shape[1]
        return result

    @property
    def counts(self) -> Indices:
        """Nodes of each block."""
        result: Indices = np.prod(self.shapes, axis=1)
        return result


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a PLOT3D grid; see `read_mesh`."""
    source = Source(path, data)
    if b"\0" in data[:4000]:
        return _binary(source)
    return _text(source)


def _shapes(numbers: Indices) -> Iterator[tuple[int, Indices]]:
    """Ways to read the first whole numbers: how many they are, and the shapes of the blocks."""
    for axes in (3, 2):
        if len(numbers) >= axes:
            yield axes, numbers[:axes].reshape(1, axes)
        many = int(numbers[0]) if len(numbers) else 0
        if 0 < many <= MOST_BLOCKS and len(numbers) >= 1 + axes * many:
            yield 1 + axes * many, numbers[1 : 1 + axes * many].reshape(many, axes)


def _fits(shapes: Indices, most: int) -> bool:
    """Whether all are positive and together no larger than the file."""
    return bool((shapes > 0).all() and np.prod(shapes.astype(float), axis=1).sum() <= most)


def _text(source: Source) -> Mesh:
    starts, ends = split_tokens(source.data, b",")
    if not len(starts):
        raise source.failure("the file is empty")
    tokens = Repeats.of(source, starts, ends)
    starts, ends = tokens.starts, tokens.ends
    words = [source.data[starts[k] : ends[k]] for k in range(min(len(starts), 1 + 3 * MOST_BLOCKS))]
    whole = next((k for k, word in enumerate(words) if not word.isdigit()), len(words))
    numbers = np.array([int(word[:18]) for word in words[:whole]], dtype=np.int64)
    for header, shapes in _shapes(numbers):
        if not _fits(shapes, len(starts)):
            continue
        for columns in (shapes.shape[1], shapes.shape[1] + 1):
            reading = Reading(header, shapes, columns)
            if header + columns * int(reading.counts.sum()) == len(starts):
                places = _places(reading)
                if tokens.repeated:
                    return _mesh(source, reading, tokens.template(places))
                return _mesh(source, reading, _text_template(source, starts, ends, places))
    raise source.failure(f"its {len(starts)} numbers are no blocks of a PLOT3D grid")


def _places(reading: Reading) -> Indices:
    """(nodes, axes) position of each coordinate among all numbers of the file."""
    begin = reading.header + offsets_of(reading.counts * reading.columns)
    parts = [
        first + count * np.arange(reading.axes) + np.arange(count)[:, None]
        for first, count in zip(begin, reading.counts, strict=False)
    ]
    return np.concatenate(parts)


def _text_template(source: Source, starts: Indices, ends: Indices, places: Indices) -> TextTemplate:
    points = _padded(pick_anywhere(source, starts[places], ends[places]))
    return TextTemplate(source.data, points, starts[places], ends[places])


def _padded(values: Array) -> Array:
    return np.hstack([values, np.zeros((len(values), 3 - values.shape[1]))])


def _binary(source: Source) -> Mesh:
    size = len(source.data)
    for order in "<>":
        for marks in (4, 0):
            head = np.frombuffer(source.data, f"{order}i4", min(size // 4, 3 * MOST_BLOCKS + 4))
            numbers = _without_marks(head, order) if marks else head.astype(np.int64)
            for header, shapes in _shapes(numbers):
                if not _fits(shapes, size):
                    continue
                for real in (8, 4):
                    for columns in (shapes.shape[1], shapes.shape[1] + 1):
                        for apart in (False, True)[: 1 + (marks > 0)]:
                            reading = Reading(
                                4 * header, shapes, columns, order, real, marks, apart
                            )
                            if _size(reading) == size:
                                return _mesh(source, reading, _binary_template(source, reading))
    raise source.failure(f"its {size} bytes are no blocks of a PLOT3D grid")


def _without_marks(head: Indices, order: str) -> Indices:
    """Whole numbers of the first one or two Fortran records: count of blocks, and shapes."""
    numbers: list[int] = []
    at = 0
    for _ in range(2):
        if at >= len(head) or head[at] <= 0 or head[at] % 4:
            break
        many = int(head[at]) // 4
        if at + many + 1 >= len(head) or head[at + many + 1] != head[at]:
            break
        numbers += head[at + 1 : at + 1 + many].tolist()
        at += many + 2
        if many > 1:
            break
    return np.array(numbers, dtype=np.int64)


def _columns_size(reading: Reading) -> int:
    """Bytes of a node with its blanking."""
    return reading.axes * reading.real + 4 * (reading.columns - reading.axes)


def _begin(reading: Reading) -> Indices:
    """Place of the first number of each block."""
    if not reading.marks:
        first, gap = reading.header, 0
    else:  # marks around the count of blocks, the shapes and each block
        counted = reading.header > 4 * reading.shapes.size
        first, gap = reading.header + 8 + 8 * counted + 4, 8
    blocks = np.arange(len(reading.shapes))
    gap *= reading.columns if reading.apart else 1
    return first + offsets_of(reading.counts * _columns_size(reading))[:-1] + gap * blocks


def _size(reading: Reading) -> int:
    last = int(_begin(reading)[-1] + reading.counts[-1] * _columns_size(reading))
    return last + reading.marks + 8 * (reading.columns - 1) * reading.apart


def _binary_template(source: Source, reading: Reading) -> BinaryTemplate:
    dtype = np.dtype(f"{reading.order}f{reading.real}")
    parts = [
        begin
        + (reading.real * count + 8 * reading.apart) * np.arange(reading.axes)
        + reading.real * np.arange(count)[:, None]
        for begin, count in zip(_begin(reading), reading.counts, strict=True)
    ]
    places = np.concatenate(parts)
    raw = np.frombuffer(source.data, dtype=np.uint8)
    values = raw[places[:, :, None] + np.arange(reading.real)].view(dtype)[:, :, 0]
    with np.errstate(invalid="ignore"):
        points = values.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"node {bad[0]} (counted from 0) is not finite")
    return BinaryTemplate(source.data, _padded(points), dtype, places)


def _mesh(
    source: Source, reading: Reading, template: TextTemplate | BinaryTemplate | RepeatTemplate
) -> Mesh:
    cells: dict[str, list[Indices]] = {}
    markers: Markers = {}
    first = offsets_of(reading.counts)
    for k, shape in enumerate(reading.shapes.tolist()):
        block: Cells = block_cells(tuple(shape), int(first[k]))
        for kind, nodes in block.items():
            cells.setdefault(kind, []).append(nodes)
        if len(reading.shapes) > 1:
            markers[f"block {k + 1}"] = block
    joined = {kind: np.concatenate(nodes) for kind, nodes in cells.items()}
    return Mesh(template.original, joined, markers, dimension=reading.axes, template=template)
