"""SU2 meshes in two and three dimensions.

1. Sections come in any order, in every zone anew, so they are collected first and understood
   afterwards. A section is a line ``KEY= value`` with the lines up to the next one.
2. ``%`` begins a comment anywhere. ``NDIME=2`` needs no blank. ``NPOIN=`` may hold two numbers
   (the second one leaves out halo nodes); lines may end in index columns, which are kept.
3. Node indices count from 0 in each zone (``NZONE=``, ``IZONE=``).
4. Nodes that stand for each other in marker SEND_RECEIVE are linked: those sent (SEND_RECV= or
   SEND_TO= with a positive number) with those received from that number, in their order.
5. FFD boxes (``FFD_...``) are kept as they are; SU2_DEF would move the shape back by a stale
   one, so writing a moved mesh with a section that nobody replaced warns.

Source: SU2 documentation, "Mesh File".
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.number_table import Rows, read_rows
from ffdstudio.meshes.formats.patch import TextTemplate
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.formats.su2_sections import Su2Section, ffd_spans, sections_of, zones_of
from ffdstudio.meshes.links import Link
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import CORNERS, Cells

CODES = {
    1: "vertex",
    3: "line",
    5: "triangle",
    9: "quad",
    10: "tetra",
    12: "hexahedron",
    13: "wedge",
    14: "pyramid",
}


@dataclass(frozen=True, eq=False)
class SU2Template(TextTemplate):
    """The file, with the places of its FFD sections."""

    ffd: tuple[tuple[int, int], ...] = ()
    ffd_is_fresh: bool = False
    zones: int = 1

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file; warn if it takes along an FFD section that no longer fits."""
        super().write(path, points)
        if self.ffd and not self.ffd_is_fresh and not np.array_equal(points, self.original):
            warnings.warn(
                f"{path.name}: the FFD boxes inside the file are kept as they were; "
                "SU2_DEF would move the shape back to them",
                MeshWarning,
                stacklevel=3,
            )


def zone_count(mesh: Mesh) -> int:
    """Number of zones of the SU2 file of a mesh."""
    return mesh.template.zones if isinstance(mesh.template, SU2Template) else 1


def ffd_sections(mesh: Mesh) -> list[bytes]:
    """FFD boxes embedded in the SU2 file of a mesh, from ``FFD_NBOX=`` on, byte for byte.

    A file of several zones may have a section in each; a mesh of another format has none.
    """
    template = mesh.template
    if not isinstance(template, SU2Template):
        return []
    return [template.data[begin:end] for begin, end in template.ffd]


def replace_ffd_sections(mesh: Mesh, sections: Sequence[bytes]) -> Mesh:
    """Return the same mesh with other FFD boxes in its file, or without any.

    Parameters
    ----------
    mesh : Mesh
        Read from an SU2 file.
    sections : sequence of bytes
        Whole lines from ``FFD_NBOX=`` on, each in the place of an old one, or at the end of a
        file that has none. Old ones beyond these are stripped.

    Raises
    ------
    InputError
        If the mesh does not come from an SU2 file.
    """
    old = mesh.template
    if not isinstance(old, SU2Template):
        raise InputError("only the file of an SU2 mesh can hold FFD boxes")
    places = old.ffd or ((len(old.data), len(old.data)),)
    new = [*sections, *([b""] * len(places))][: len(places)]
    if not old.ffd and new[0] and not old.data.endswith(b"\n"):
        new[0] = b"\n" + new[0]
    pieces, spans, shifts, at = [], [], [0], 0
    for (begin, end), text in zip(places, new, strict=True):
        pieces += [old.data[at:begin], text]
        spans.append((begin + shifts[-1], begin + shifts[-1] + len(text)))
        shifts.append(shifts[-1] + len(text) - (end - begin))
        at = end
    before = np.searchsorted([end for _, end in places], old.starts, side="right")
    behind = np.array(shifts)[before]
    template = replace(
        old,
        data=b"".join([*pieces, old.data[at:]]),
        starts=old.starts + behind,
        ends=old.ends + behind,
        ffd=tuple(span for span in spans if span[0] < span[1]),
        ffd_is_fresh=True,
    )
    return replace(mesh, template=template)


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read an SU2 file; see `read_mesh`."""
    source = Source(path, data)
    sections = sections_of(source)
    zones = zones_of(source, sections)
    reader = _Reader(source, progress)
    for name, part in zones:
        reader.zone(name, part)
    starts, ends = np.concatenate(reader.starts), np.concatenate(reader.ends)
    points = np.concatenate(reader.points)
    spans = ffd_spans(source, sections)
    template = SU2Template(data, points, starts, ends, ffd=spans, zones=len(zones))
    return Mesh(
        points,
        {kind: np.concatenate(nodes) for kind, nodes in reader.cells.items()},
        reader.markers,
        dimension=starts.shape[1],
        links=tuple(reader.links()),
        template=template,
    )


class _Reader:
    """What the zones of a file add up to."""

    def __init__(self, source: Source, progress: Progress) -> None:
        self.source = source
        self.tick = lambda place: progress(place / max(len(source.data), 1))
        self.points: list[Array] = []
        self.starts: list[Indices] = []
        self.ends: list[Indices] = []
        self.cells: dict[str, list[Indices]] = {}
        self.markers: Markers = {}
        self.halos: list[tuple[str, int, Indices]] = []  # marker, number of the partner, nodes

    def zone(self, name: str, sections: list[Su2Section]) -> None:
        first = sum(map(len, self.points))
        axes = self._dimension(self._one(sections, b"NDIME"))
        self._points(self._one(sections, b"NPOIN"), axes)
        count = sum(map(len, self.points)) - first
        cells = self._elements(self._one(sections, b"NELEM"), first, count)
        for kind, nodes in cells.items():
            self.cells.setdefault(kind, []).append(nodes)
        if name:
            self.markers[name] = cells
        self._markers(name and f"{name}/", sections, first, count)

    def _one(self, sections: list[Su2Section], key: bytes) -> Su2Section:
        found = [section for section in sections if section.key == key]
        if not found:
            raise self.source.failure(f"there is no {key.decode()}= section: not an SU2 mesh?")
        if len(found) > 1:
            raise self.source.error(found[1].place, f"a second {key.decode()}= in the same zone")
        return found[0]

    def _count(self, section: Su2Section) -> int:
        token = (section.value.split() or [b""])[0]
        return self.source.integer(token, section.place, f"{section.key.decode('latin-1')}=")

    def _dimension(self, section: Su2Section) -> int:
        axes = self._count(section)
        if axes not in (2, 3):
            raise self.source.error(section.place, f"NDIME= must be 2 or 3, not {axes}")
        if self.starts and self.starts[0].shape[1] != axes:
            raise self.source.error(section.place, "zones of different NDIME= in one file")
        return axes

    def _rows(self, section: Su2Section, dtype: type, what: str) -> Rows:
        """Lines of a section, as many as its keyword says."""
        count = self._count(section)
        spans = dtype is np.float64
        rows = read_rows(self.source, section.begin, section.end, dtype, b"%", spans, self.tick)
        if len(rows) != count:
            key = section.key.decode("latin-1")
            raise self.source.error(
                section.place, f"{key}= announces {count} {what}, but {len(rows)} lines follow"
            )
        return rows

    def _points(self, section: Su2Section, axes: int) -> None:
        rows = self._rows(section, np.float64, "nodes")
        short = np.flatnonzero(rows.widths < axes)
        if len(short):
            place = int(rows.places[short[0]])
            raise self.source.error(place, f"a node needs {axes} coordinates")
        self._indexed_alike(rows, axes, halos=len(section.value.split()) > 1)
        where = rows.columns(axes)
        points = np.zeros((len(rows), 3))
        points[:, :axes] = rows.values[where]
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            place = int(rows.places[bad[0]])
            raise self.source.error(place, "a coordinate is not a finite number")
        self.points.append(points)
        self.starts.append(rows.starts[where])
        self.ends.append(rows.ends[where])

    def _indexed_alike(self, rows: Rows, axes: int, halos: bool) -> None:
        """Refuse a node with other numbers behind its coordinates than the other nodes.

        There may be an index, or a local and a global one, which halo nodes alone may have. A
        number too many in one line may as well stand before the coordinates, and would shift them.
        """
        widths = rows.widths
        if not halos:
            usual = int(np.bincount(np.minimum(widths, axes + 3), minlength=1).argmax())
            for odd in np.flatnonzero(widths != usual)[:1]:
                found = f"this node has {widths[odd]} numbers, others {usual}"
                raise self.source.error(int(rows.places[odd]), found)
        for odd in np.flatnonzero(widths > axes + 2)[:1]:
            found = f"this node has {widths[odd]} numbers, {axes + 2} at most are known"
            raise self.source.error(int(rows.places[odd]), found)
        for column in (axes, axes + 1):
            behind = np.flatnonzero(widths > column)
            indices = rows.values[rows.first[behind] + column]
            for odd in behind[~np.isfinite(indices) | (indices != np.floor(indices))][:1]:
                found = "behind the coordinates of a node stands no index"
                raise self.source.error(int(rows.places[odd]), found)

    def _elements(self, section: Su2Section, first: int, count: int) -> Cells:
        rows = self._rows(section, np.int64, "elements")
        codes = rows.values[rows.first[:-1]]
        cells = {}
        for code in np.unique(codes).tolist():
            chosen = np.flatnonzero(codes == code)
            if code not in CODES:
                self._refuse(rows, int(chosen[0]), f"unknown element type {code}")
            cells[CODES[code]] = first + self._nodes(rows, chosen, CODES[code], count)
        return cells

    def _nodes(self, rows: Rows, chosen: Indices, kind: str, count: int) -> Indices:
        size, widths = CORNERS[kind], rows.widths[chosen]
        odd = np.flatnonzero((widths < size + 1) | (widths > size + 3))
        if len(odd):
            found = int(widths[odd[0]]) - 1
            self._refuse(rows, int(chosen[odd[0]]), f"a {kind} has {size} nodes, found {found}")
        table = rows.table() if len(chosen) == len(rows) else None
        if table is None:
            table = rows.values[rows.columns(size + 1, chosen)]
        nodes = table[:, 1 : size + 1]
        wrong = np.flatnonzero(((nodes < 0) | (nodes >= count)).any(axis=1))
        if len(wrong):
            self._refuse(rows, int(chosen[wrong[0]]), f"a node index is not in 0 to {count - 1}")
        return nodes

    def _refuse(self, rows: Rows, row: int, message: str) -> None:
        raise self.source.error(int(rows.places[row]), message)

    def _markers(self, prefix: str, sections: list[Su2Section], first: int, count: int) -> None:
        tag, kept = "", None
        for section in sections:
            if section.key in (b"MARKER_TAG", b"MARKERTAG"):
                tag = prefix + decoded(section.value)
            elif section.key == b"MARKER_ELEMS":
                kept = section
                if self._is_empty(section):  # a keyword such as SEND_RECV= stands before them
                    continue
                self._add(tag, self._elements(section, first, count))
                kept = None
            elif kept is not None and not self._is_empty(section, kept):
                body = kept._replace(begin=section.begin, end=section.end)
                cells = self._elements(body, first, count)
                self._add(tag, cells)
                self._remember_halo(tag, section, cells)
                kept = None
        announced = [section for section in sections if section.key == b"NMARK"]
        found = sum(section.key in (b"MARKER_TAG", b"MARKERTAG") for section in sections)
        for section in announced[:1]:
            if self._count(section) != found:
                raise self.source.error(
                    section.place, f"NMARK= announces {self._count(section)} markers, found {found}"
                )

    def _is_empty(self, section: Su2Section, counted: Su2Section | None = None) -> bool:
        """Whether no line follows where elements are announced."""
        lines = self.source.data[section.begin : section.end].splitlines()
        solid = any(line.split(b"%")[0].strip() for line in lines)
        return not solid and self._count(counted or section) > 0

    def _remember_halo(self, tag: str, section: Su2Section, cells: Cells) -> None:
        """Keep the nodes that are sent (a positive number) or received."""
        word = (section.value.split() or [b""])[0]
        if section.key in (b"SEND_RECV", b"SEND_TO") and re.fullmatch(rb"[-+]?\d{1,9}", word):
            self.halos.append((tag, int(word), cells.get("vertex", np.empty((0, 1), int)).ravel()))

    def links(self) -> Iterator[Link]:
        """Nodes sent with those received, where there are as many."""
        waiting = list(self.halos)
        while waiting:
            tag, number, nodes = waiting.pop(0)
            fits = (row for row in waiting if row[:2] == (tag, -number))
            other = next((row for row in fits if len(row[2]) == len(nodes)), None)
            if other is not None and len(nodes):
                waiting = [row for row in waiting if row is not other]
                sent, received = (nodes, other[2]) if number > 0 else (other[2], nodes)
                yield Link((tag,), sent, received)

    def _add(self, tag: str, cells: Cells) -> None:
        """Add a marker; one that comes in several parts is joined."""
        joined = dict(self.markers.get(tag, {}))
        for kind, nodes in cells.items():
            joined[kind] = np.concatenate([joined[kind], nodes]) if kind in joined else nodes
        self.markers[tag] = joined
