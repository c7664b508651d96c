"""The FFD section of an SU2 mesh as text: boxes in, boxes out.

1. Only the section is parsed, wherever it stands; a mesh of a gigabyte costs one search.
2. We read what SU2 and its users write (blanks, comments, CRLF) and write what SU2 reads:
   fixed order, one key a line, ``KEY= value`` with one space, tabs, no blank at the end of
   a line. A blank after FFD_BLENDING makes SU2 misread all that follows.
3. FFD_DEGREE d means d + 1 control points for both blendings; the order is separate.
4. Boxes that are not ours to change keep their bytes.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.exchange.text import integer, naming, shown, vector
from ffdstudio.limits import check_control_points

MAX_POINTS = 10_000_000  # nodes that a box may have cached
MAX_BOXES = 10_000


@dataclass
class Box:
    """One box as the file states it."""

    tag: str
    level: int
    counts: tuple[int, ...]
    orders: tuple[int, ...] | None  # of the B-spline; None is BEZIER
    parents: list[str]
    children: list[str]
    corners: Array
    net: Array | None  # (i, j, k, 3); None: FFD_CONTROL_POINTS= 0, the box is not set up
    surface: list[bytes] = field(default_factory=list)  # the lines of the cached embedding
    raw: bytes = b""  # how the box stands in the file


@dataclass
class BoxSection:
    """All boxes and the place they take: ``data[start:end]``."""

    boxes: list[Box]
    start: int
    end: int
    levels: int
    dimension: int


def parse(data: bytes, name: str, dimension: int | None = None) -> BoxSection:
    """Parse the first FFD section; without one `boxes` is empty and its place the end of the file.

    The dimension of the mesh is read from the file unless it is given.
    """
    dimension = dimension or _dimension(data, name)
    found = _sections(data, name, dimension, 1)
    return found[0] if found else BoxSection([], len(data), len(data), 1, dimension)


def all_boxes(data: bytes, name: str) -> list[Box]:
    """Return the boxes of all zones of a mesh, each of which may have a section."""
    found = _sections(data, name, _dimension(data, name))
    return [box for section in found for box in section.boxes]


def has_zones(data: bytes) -> bool:
    """Whether there are several zones in a mesh."""
    return len(re.findall(rb"^[ \t]*NDIME[ \t]*=", data, re.MULTILINE)) > 1


def _sections(data: bytes, name: str, dimension: int, most: int | None = None) -> list[BoxSection]:
    begins = re.finditer(rb"^[ \t]*FFD_NBOX[ \t]*=", data, re.MULTILINE)
    found = []
    for begin in itertools.islice(begins, most):
        reader = _Reader(data, begin.start(), name)
        count = reader.number("FFD_NBOX")
        levels = reader.number("FFD_NLEVEL")
        if count > MAX_BOXES:
            raise InputError(f"{name}: FFD_NBOX= {count} is out of range")
        boxes = [_box(reader, dimension) for _ in range(count)]
        tags = [box.tag for box in boxes]
        if len(set(tags)) < len(tags):
            raise InputError(f"{name}: two FFD boxes have the same tag")
        found.append(BoxSection(boxes, begin.start(), reader.position, levels, dimension))
    return found


def each_box(data: bytes, name: str) -> Iterator[tuple[str, Box | InputError]]:
    """Tags with boxes one by one, a broken box as what is wrong with it."""
    dimension = _dimension(data, name)
    for found in re.finditer(rb"^[ \t]*FFD_TAG[ \t]*=", data, re.MULTILINE):
        reader = _Reader(data, found.start(), name)
        tag = reader.value("FFD_TAG").decode("utf-8", "replace")
        reader.position = found.start()
        try:
            yield tag, _box(reader, dimension)
        except InputError as error:
            yield tag, error


def compose(section: BoxSection) -> bytes:
    """Return the text of the section."""
    if not section.boxes:
        return b""
    levels = max(section.levels, 1 + max(box.level for box in section.boxes))
    head = f"FFD_NBOX= {len(section.boxes)}\nFFD_NLEVEL= {levels}\n".encode()
    return head + b"".join(box.raw or box_text(box) for box in section.boxes)


def replaced(data: bytes, section: BoxSection) -> bytes:
    """Return the file with its section in the place of the old one."""
    before = data[: section.start]
    if before and not before.endswith(b"\n"):
        before += b"\n"
    return before + compose(section) + data[section.end :]


def box_text(box: Box) -> bytes:
    """Return a box as SU2 reads it."""
    directions = "IJK"[: len(box.corners[0])]
    lines = [f"FFD_TAG= {box.tag}", f"FFD_LEVEL= {box.level}"]
    lines += [f"FFD_DEGREE_{d}= {n - 1}" for d, n in zip(directions, box.counts, strict=False)]
    lines.append(f"FFD_BLENDING= {'BEZIER' if box.orders is None else 'BSPLINE_UNIFORM'}")
    orders = zip(directions, box.orders or (), strict=False)
    lines += [f"BSPLINE_ORDER_{d}= {order}" for d, order in orders]
    for key, tags in (("FFD_PARENTS", box.parents), ("FFD_CHILDREN", box.children)):
        lines += [f"{key}= {len(tags)}", *tags]
    lines.append(f"FFD_CORNER_POINTS= {len(box.corners)}")
    lines += ["\t".join(map(repr, corner)) for corner in box.corners.tolist()]
    net = np.empty((0, 0, 0, 3)) if box.net is None else box.net
    lines.append(f"FFD_CONTROL_POINTS= {net[..., 0].size}")
    for (i, j, k), point in zip(
        np.ndindex(net.shape[:3]), net.reshape(-1, 3).tolist(), strict=True
    ):
        lines.append("\t".join([str(i), str(j), str(k), *map(repr, point)]))
    lines.append(f"FFD_SURFACE_POINTS= {len(box.surface)}")
    return "\n".join([*lines, ""]).encode() + b"".join(line + b"\n" for line in box.surface)


class _Reader:
    """Lines of the section one by one, without blanks and comments."""

    def __init__(self, data: bytes, position: int, name: str) -> None:
        self.data, self.position, self.name = data, position, name

    def line(self) -> bytes:
        while self.position < len(self.data):
            end = self.data.find(b"\n", self.position)
            end = len(self.data) if end < 0 else end + 1
            text = self.data[self.position : end].split(b"%", 1)[0].strip()
            self.position = end
            if text:
                return text
        raise InputError(f"{self.name}: the FFD section ends too early")

    def lines(self, count: int) -> list[bytes]:
        return [self.line() for _ in range(count)]

    def value(self, key: str) -> bytes:
        found, sign, value = self.line().partition(b"=")
        if not sign or found.strip() != key.encode():
            raise InputError(f"{self.name}: {key}= expected in the FFD section, got {shown(found)}")
        return value.strip()

    def number(self, key: str) -> int:
        count = integer(self.value(key), self.name, key)
        if not 0 <= count <= MAX_POINTS:
            raise InputError(f"{self.name}: {key}= {count} is out of range")
        return count

    def optional(self, key: str) -> bytes | None:
        """Value of a key that may be missing."""
        before = self.position
        try:
            return self.value(key)
        except InputError:
            self.position = before
            return None

    def tags(self, key: str) -> list[str]:
        return [text.decode("utf-8", "replace") for text in self.lines(self.number(key))]


def _dimension(data: bytes, name: str) -> int:
    found = re.search(rb"^[ \t]*NDIME[ \t]*=[ \t]*([23])\b", data, re.MULTILINE)
    if found is None:
        raise InputError(f"{name}: no SU2 mesh (NDIME= 2 or 3 is missing)")
    return int(found[1])


def _box(reader: _Reader, dimension: int) -> Box:
    start = reader.position
    tag = reader.value("FFD_TAG").decode("utf-8", "replace")
    level = reader.number("FFD_LEVEL")
    counts = [reader.number(f"FFD_DEGREE_{d}") + 1 for d in "IJK"[:dimension]]
    if dimension == 2:
        reader.optional("FFD_DEGREE_K")
        counts.append(2)
    with naming(reader.name):
        check_control_points(counts)
    blending = reader.optional("FFD_BLENDING") or b"BEZIER"  # what SU2 takes without it
    if blending not in (b"BEZIER", b"BSPLINE_UNIFORM"):
        raise InputError(f"{reader.name}: FFD_BLENDING= {shown(blending)} is not known")
    orders = _orders(reader, dimension) if blending == b"BSPLINE_UNIFORM" else None
    parents, children = reader.tags("FFD_PARENTS"), reader.tags("FFD_CHILDREN")
    corners = _corners(reader, dimension)
    net = _net(reader, (counts[0], counts[1], counts[2]))
    surface = reader.lines(reader.number("FFD_SURFACE_POINTS"))
    raw = reader.data[start : reader.position]
    shape = tuple(counts[:dimension])
    return Box(tag, level, shape, orders, parents, children, corners, net, surface, raw)


def _orders(reader: _Reader, dimension: int) -> tuple[int, ...]:
    orders = tuple(reader.number(f"BSPLINE_ORDER_{d}") for d in "IJK"[:dimension])
    if dimension == 2:
        reader.optional("BSPLINE_ORDER_K")
    return orders


def _corners(reader: _Reader, dimension: int) -> Array:
    count = reader.number("FFD_CORNER_POINTS")
    if count != 2**dimension:
        raise InputError(
            f"{reader.name}: FFD_CORNER_POINTS= must be {2**dimension} in {dimension}D, not {count}"
        )
    rows = [vector(line.split(), reader.name) for line in reader.lines(count)]
    if any(not dimension <= len(row) <= 3 for row in rows):
        raise InputError(f"{reader.name}: an FFD corner needs {dimension} coordinates")
    return np.array([row[:dimension] for row in rows])


def _net(reader: _Reader, shape: tuple[int, int, int]) -> Array | None:
    count = reader.number("FFD_CONTROL_POINTS")
    if count == 0:
        return None
    expected = shape[0] * shape[1] * shape[2]
    if count != expected:
        raise InputError(
            f"{reader.name}: FFD_CONTROL_POINTS= {count} does not fit the degrees, which need "
            f"{expected}"
        )
    net = np.full((*shape, 3), np.nan)
    for line in reader.lines(count):
        words = line.split()
        index = tuple(integer(word, reader.name, "a control point's index") for word in words[:3])
        if len(words) != 6 or not all(0 <= i < n for i, n in zip(index, shape, strict=True)):
            raise InputError(f"{reader.name}: wrong FFD control point: {shown(line)}")
        net[index] = vector(words[3:], reader.name)
    if np.isnan(net).any():
        raise InputError(f"{reader.name}: an FFD control point is missing, another occurs twice")
    return net
