"""LS-DYNA keyword decks (.k, .key, .dyn), with the files that they include.

1. A line with a star begins a keyword, ``$`` a comment. Fields have fixed columns (a node: 8
   for its number, 16 for each coordinate; 20 for all with ``LONG=Y``) or stand between commas.
2. A coordinate keeps its columns: 16 characters hold 9 to 14 digits, and rounding is said.
3. Nodes, shells, thick shells, solids, beams are read; a solid that repeats nodes is a
   tetrahedron, pyramid or wedge. Elements of a part are a marker under the part's title, node
   sets are markers. Cells of other keywords (``*ELEMENT_...``) are counted as not shown.

Source: LS-DYNA keyword user's manual, volume I.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import read_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.deck_files import DeckFile, DeckTemplate, located, same
from ffdstudio.meshes.formats.patch import changed
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning

SHELLS = ("ELEMENT_SHELL", "ELEMENT_SHELL_THICKNESS", "ELEMENT_SHELL_OFFSET")
SLENDER = ("MASS", "DISCRETE", "SEATBELT", "INERTIA", "PLOTEL", "SPH", "LANCING")
MOST = 10_000  # files of a deck


class Line(NamedTuple):
    """Place of a data line in its file, and its text without the end."""

    place: int
    text: bytes


class Keyword(NamedTuple):
    """A keyword in capitals with its data lines."""

    name: str
    source: Source
    lines: list[Line]


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an LS-DYNA deck; see `read_mesh`."""
    return _Reader(Source(path, data)).mesh()


def _keywords(source: Source) -> Iterator[Keyword]:
    name, lines, at = "", list[Line](), 0
    while at < len(source.data):
        end = source.line_end(at)
        text = source.data[at:end].rstrip(b"\r\n")
        if text.startswith(b"*"):
            yield Keyword(name, source, lines)
            name, lines = decoded(text[1:]).strip().upper(), []
        elif not text.startswith(b"$"):
            lines.append(Line(at, text))
        at = end
    yield Keyword(name, source, lines)


@dataclass
class Written:
    """Where the nodes of a file stand: lines (begin, end), node of each, width of its fields."""

    spans: list[tuple[int, int]] = field(default_factory=list)
    nodes: list[int] = field(default_factory=list)


class _Reader:
    """What the keywords of a deck add up to."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.files = [DeckFile(source, "")]
        self.written = [Written()]
        self.index: dict[int, int] = {}
        self.points: list[list[float]] = []
        self.cells: dict[str, list[list[int]]] = {}
        self.parts: dict[tuple[int, str], list[int]] = {}  # part, type -> rows
        self.titles: dict[int, str] = {}
        self.sets: dict[str, list[int]] = {}
        self.pending: list[tuple[Keyword, Line, int, list[int]]] = []  # part, nodes
        self.unread: Counter[str] = Counter()
        self.long = False

    def mesh(self) -> Mesh:
        self._file(self.source)
        if not self.points:
            raise self.source.failure("there is no *NODE with nodes in this deck")
        for keyword, line, part, nodes in self.pending:
            self._element(keyword, line, part, nodes)
        points = np.array(self.points)
        cells = {kind: np.array(rows, dtype=np.int64) for kind, rows in self.cells.items()}
        template = DeckTemplate(
            self.source.path,
            points,
            self.files,
            lambda new: [self._patched(k, points, new) for k in range(len(self.files))],
            lambda path, new: self._warn_of_rounding(path, points, new),
        )
        return Mesh(
            points, cells, self._markers(cells), unread=dict(self.unread), template=template
        )

    def _file(self, source: Source) -> None:
        for keyword in _keywords(source):
            name = keyword.name.split()[0] if keyword.name else ""
            self.long |= "LONG=Y" in keyword.name
            if name == "END":
                return
            if name == "NODE":
                self._nodes(keyword)
            elif name == "PART":
                self._parts(keyword)
            elif name.startswith("SET_NODE") and "GENERA" not in name:
                self._node_set(keyword, name.endswith("_TITLE"))
            elif name == "INCLUDE":
                self._include(keyword)
            elif name.startswith("ELEMENT_"):
                self._elements(keyword, name)

    def _words(self, line: Line, widths: list[int]) -> list[bytes]:
        """Fields of a line, between commas or in columns."""
        if b"," in line.text:
            return [word.strip() for word in line.text.split(b",")]
        found, at = [], 0
        for width in [20] * len(widths) if self.long else widths:
            found.append(line.text[at : at + width].strip())
            at += width
        return found

    def _integers(self, keyword: Keyword, line: Line, many: int, width: int = 8) -> list[int]:
        words = self._words(line, [width] * many)[:many]
        try:
            return [int(word or b"0") for word in words]
        except ValueError:
            raise keyword.source.error(line.place, "expected whole numbers") from None

    def _nodes(self, keyword: Keyword) -> None:
        own = self.written[self._number(keyword.source)]
        for line in keyword.lines:
            if not line.text.strip():
                continue
            words = self._words(line, [8, 16, 16, 16])
            try:
                number = int(words[0])
                xyz = [float((w or b"0").upper().replace(b"D", b"E")) for w in words[1:4]]
            except ValueError:
                raise keyword.source.error(line.place, "not the line of a node") from None
            xyz += [0.0] * (3 - len(xyz))
            if number in self.index or not np.isfinite(xyz).all():
                cause = "occurs twice" if number in self.index else "is not finite"
                raise keyword.source.error(line.place, f"node {number} {cause}")
            self.index[number] = len(self.points)
            own.spans.append((line.place, line.place + len(line.text)))
            own.nodes.append(len(self.points))
            self.points.append(xyz)

    def _number(self, source: Source) -> int:
        return next(k for k, file in enumerate(self.files) if file.source is source)

    def _parts(self, keyword: Keyword) -> None:
        """Titles of parts: a line with the title, then one that begins with the number."""
        for title, line in zip(keyword.lines[::2], keyword.lines[1::2], strict=False):
            number = self._integers(keyword, line, 1, 10)
            self.titles[number[0]] = decoded(title.text).strip()

    def _node_set(self, keyword: Keyword, titled: bool) -> None:
        lines = keyword.lines
        title = decoded(lines[0].text).strip() if titled and lines else ""
        lines = lines[1:] if titled else lines
        if not lines:
            return
        number = self._integers(keyword, lines[0], 1, 10)[0]
        members = [n for line in lines[1:] for n in self._integers(keyword, line, 8, 10) if n]
        self.sets.setdefault(title or f"node set {number}", []).extend(members)

    def _include(self, keyword: Keyword) -> None:
        text = "".join(decoded(line.text).strip().removesuffix(" +") for line in keyword.lines)
        name = text.replace("\\", "/")
        there = located(self.source.path, keyword.source.path, name) if name else None
        if there is None or not there[0].is_file():
            self._warn(f"{name}, which it includes, is not there; what it holds is not known")
            return
        if any(same(file.source.path, there[0]) for file in self.files) or len(self.files) > MOST:
            raise keyword.source.failure(f"includes {name}, which is included already")
        self.files.append(DeckFile(Source(there[0], read_bytes(there[0])), there[1]))
        self.written.append(Written())
        self._file(self.files[-1].source)

    def _warn(self, message: str) -> None:
        warnings.warn(f"{self.source.path.name}: {message}", MeshWarning, stacklevel=4)

    def _elements(self, keyword: Keyword, name: str) -> None:
        lines = [line for line in keyword.lines if line.text.strip()]
        if name in SHELLS:
            step = 1 if name == "ELEMENT_SHELL" else 2
            self._take(keyword, lines[::step], 6)
        elif name == "ELEMENT_TSHELL":
            self._take(keyword, lines, 10)
        elif name == "ELEMENT_BEAM":
            self._take(keyword, lines, 4)
        elif name == "ELEMENT_SOLID":
            self._solids(keyword, lines)
        elif not any(word in name for word in SLENDER):
            self._warn(f"elements of *{name} are kept but not shown")
            self.unread[f"*{name}"] += max(len(lines), 1)

    def _take(self, keyword: Keyword, lines: list[Line], many: int) -> None:
        for line in lines:
            _, part, *nodes = [*self._integers(keyword, line, many), 0, 0][: max(many, 2)]
            self.pending.append((keyword, line, part, nodes))

    def _solids(self, keyword: Keyword, lines: list[Line]) -> None:
        """Solids in one line, or in two: number and part, then the nodes."""
        at = 0
        while at < len(lines):
            head = self._integers(keyword, lines[at], 10)
            if any(head[2:]):
                self.pending.append((keyword, lines[at], head[1], head[2:]))
                at += 1
            elif at + 1 < len(lines):
                nodes = self._integers(keyword, lines[at + 1], 10)
                self.pending.append((keyword, lines[at], head[1], nodes))
                at += 2
            else:
                raise keyword.source.error(lines[at].place, "the last solid has no nodes")

    def _element(self, keyword: Keyword, line: Line, part: int, nodes: list[int]) -> None:
        kind, chosen = _shape(keyword.name.split()[0], nodes)
        missing = [node for node in chosen if node not in self.index]
        if missing or not kind:
            what = f"node {missing[0]}, which is not there" if missing else "too few nodes"
            raise keyword.source.error(line.place, f"an element has {what}")
        rows = self.cells.setdefault(kind, [])
        self.parts.setdefault((part, kind), []).append(len(rows))
        rows.append([self.index[node] for node in chosen])

    def _markers(self, cells: dict[str, Indices]) -> Markers:
        markers: Markers = {}
        for (part, kind), rows in self.parts.items():
            name = self.titles.get(part) or f"part {part}"
            own = markers.setdefault(name, {})
            both = [*([own[kind]] if kind in own else []), cells[kind][rows]]
            own[kind] = np.concatenate(both)
        for name, members in self.sets.items():
            nodes = [self.index[node] for node in members if node in self.index]
            if nodes:
                title = f"{name} (nodes)" if name in markers else name
                markers[title] = {"vertex": np.unique(nodes)[:, None]}
        return markers

    def _patched(self, file: int, old: Array, new: Array) -> bytes:
        """Content of a file with other coordinates."""
        data, own = self.files[file].source.data, self.written[file]
        moved = changed(old, new)
        pieces, at = [], 0
        for (begin, end), node in zip(own.spans, own.nodes, strict=True):
            if moved[node].any():
                line = self._line(data[begin:end], new[node], moved[node].tolist())
                pieces += [data[at:begin], line]
                at = end
        return b"".join([*pieces, data[at:]])

    def _line(self, line: bytes, point: Array, moved: list[bool]) -> bytes:
        """Line of a node with new numbers where it moves."""
        width = 20 if self.long else 16
        texts = [_fitted(value, width) for value in point.tolist()]
        if b"," in line:
            words = line.split(b",")
            words += [b""] * (4 - len(words))
            words[1:4] = [t if m else w for t, m, w in zip(texts, moved, words[1:4], strict=True)]
            return b",".join(words)
        first = 20 if self.long else 8
        cut = [line[first + width * k : first + width * (k + 1)] for k in range(3)]
        rows = zip(texts, moved, cut, strict=True)
        cut = [new.rjust(width) if is_new else old.ljust(width) for new, is_new, old in rows]
        return (line[:first].ljust(first) + b"".join(cut) + line[first + 3 * width :]).rstrip()

    def _warn_of_rounding(self, path: Path, old: Array, new: Array) -> None:
        width = 20 if self.long else 16
        values = new[changed(old, new)].tolist()
        if any(float(_fitted(value, width)) != value for value in values):
            warnings.warn(
                f"{path.name}: moved nodes are rounded to the {width} characters of their fields",
                MeshWarning,
                stacklevel=5,
            )


def _fitted(value: float, width: int) -> bytes:
    """Number with as many digits as there is room for."""
    texts = (repr(value), *(f"{value:.{digits}g}" for digits in range(16, 0, -1)))
    return next(text for text in texts if len(text) <= width).encode()


def _shape(name: str, nodes: list[int]) -> tuple[str, list[int]]:
    """Type of an element and its nodes; an empty type if there are too few."""
    if name == "ELEMENT_BEAM":
        return ("line", nodes[:2]) if all(nodes[:2]) else ("", [])
    if name in SHELLS:
        four = nodes[:4]
        if len(four) < 3 or not all(four[:3]):
            return "", []
        three = len(four) < 4 or four[3] in (0, four[2])
        return ("triangle", four[:3]) if three else ("quad", four)
    if len([n for n in nodes if n]) == 10:
        return "tetra10", nodes
    eight = nodes[:8]
    if len(eight) < 4 or not all(eight[:4]):
        return "", []
    rest = set(eight[4:]) - {0}
    if rest <= {eight[3]}:
        return "tetra", eight[:4]
    if len(eight) < 8 or not all(eight):
        return "", []
    if len(rest) == 1:
        return "pyramid", eight[:5]
    if eight[4] == eight[5] and eight[6] == eight[7]:
        return "wedge", [eight[k] for k in (0, 1, 4, 3, 2, 6)]
    return "hexahedron", eight
