"""Nastran decks (.bdf, .nas, .dat): small, large and free fields, INCLUDE files.

1. A coordinate has 8 characters in a small field: too few. A GRID that moves becomes a GRID*
   with 16; one that stays keeps its line. 16 characters hold 13 to 15 digits, which is said.
2. Included files belong to the deck and are written beside it under the same relative name.
   An original is never overwritten unless the deck itself is.
3. Coordinates in a local frame (CP) are refused: the numbers are not x, y, z.
4. Elements of one property are a marker.

Source: MSC Nastran quick reference guide, bulk data entries.
"""

from __future__ import annotations

import os
import re
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_together
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.card_deck import BLANK, WIDTH, Deck, integers, reals
from ffdstudio.meshes.formats.grids import Grids, grid_fields, plain, sixteen
from ffdstudio.meshes.formats.patch import changed
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import MIDDLE_BEFORE_TOP
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells

# card -> fields before the nodes, and the type for each number of nodes
ELEMENTS: dict[str, tuple[int, dict[int, str]]] = {
    "CTRIA3": (2, {3: "triangle"}),
    "CTRIAR": (2, {3: "triangle"}),
    "CTRIA6": (2, {3: "triangle", 6: "triangle6"}),
    "CQUAD4": (2, {4: "quad"}),
    "CQUADR": (2, {4: "quad"}),
    "CQUAD8": (2, {4: "quad", 8: "quad8"}),
    "CTETRA": (2, {4: "tetra", 10: "tetra10"}),
    "CPYRAM": (2, {5: "pyramid", 13: "pyramid13"}),
    "CPENTA": (2, {6: "wedge", 15: "wedge15"}),
    "CHEXA": (2, {8: "hexahedron", 20: "hexahedron20"}),
    "CTRIA": (2, {3: "triangle"}),
    "CQUAD": (2, {4: "quad", 8: "quad8", 9: "quad9"}),
    "CSHEAR": (2, {4: "quad"}),
    "CTRAX3": (2, {3: "triangle"}),
    "CTRAX6": (2, {6: "triangle6"}),
    "CTRIAX": (2, {3: "triangle", 6: "triangle6"}),
    "CTRIAX6": (2, {3: "triangle", 6: "triangle6"}),
    "CQUADX": (2, {4: "quad", 8: "quad8", 9: "quad9"}),
    "CQUADX4": (2, {4: "quad"}),
    "CQUADX8": (2, {4: "quad", 8: "quad8"}),
    "CPLSTN3": (2, {3: "triangle"}),
    "CPLSTN4": (2, {4: "quad"}),
    "CPLSTN6": (2, {3: "triangle", 6: "triangle6"}),
    "CPLSTN8": (2, {4: "quad", 8: "quad8"}),
    "CPLSTS3": (2, {3: "triangle"}),
    "CPLSTS4": (2, {4: "quad"}),
    "CPLSTS6": (2, {3: "triangle", 6: "triangle6"}),
    "CPLSTS8": (2, {4: "quad", 8: "quad8"}),
    "CTWEDGE": (2, {6: "wedge"}),
    "CIHEX1": (2, {8: "hexahedron"}),
    "CIHEX2": (2, {8: "hexahedron", 20: "hexahedron20"}),
    "CONROD": (1, {2: "line"}),
    "CTUBE": (2, {2: "line"}),
    "CROD": (2, {2: "line"}),
    "CBAR": (2, {2: "line"}),
    "CBEAM": (2, {2: "line"}),
    "CBUSH": (2, {2: "line"}),
    "PLOTEL": (1, {2: "line"}),
}
ROUND = ("CTRIAX6",)  # corners and middles in turn
# begins of cards with C that are no cells with an area or a volume
NO_CELL = re.compile(
    r"CORD|CEND|CELAS|CDAMP|CMASS|CONM|CONV|CONTR|CONCT|COMB|COND|CONS|CGAP|CVISC|CBEND|CBEAM|CBAR|"
    r"CBUSH|CBUTT|CFAST|CWELD|CSEAM|CSPOT|CINT|CBELT|CPIPE|CSUP|CSET|CNGRET|CLOAD|CREEP|CYAX|CYJOIN|"
    r"CYSUP|CYSYM|CYCL|CAERO|CAMPBL|CASE|CHECK|CSSCHD|CTYPE|CVEL|CROSS|CODU|COUNT|CURV|CHAN|CMREBAI|"
    r"CMREBAR|CSTR|CRO|CPOINT|CFLUID|CBARAO|CSLOT|CHACAB|CMB|CMET|CMLIST|CMPL|CNVOL|CFLO|CL1D|CSPH|CSPR|CT$"
)
_CARD = re.compile(r"C[A-Z][A-Z0-9]{1,6}")
_INCLUDE = re.compile(  # a name in quotes may go on in the next lines
    rb"^[ \t]*INCLUDE[ \t]+(?:'([^'$]{0,500})'|\"([^\"$]{0,500})\"|([^\s'\"]+))", re.I | re.M
)
_END = re.compile(rb"^[ \t]*ENDDATA\b", re.I | re.M)


@dataclass(frozen=True, eq=False)
class NastranTemplate:
    """The deck with its included files."""

    path: Path
    original: Array
    files: list[Grids]

    def patched(self, points: Array) -> bytes:
        """Content of the deck itself with these (n, 3) coordinates."""
        return self._contents(points)[0]

    def _contents(self, points: Array) -> list[bytes]:
        first, found = 0, []
        for grids in self.files:
            found.append(grids.patched(points[first : first + len(grids.ids)]))
            first += len(grids.ids)
        return found

    def write(self, path: Path, points: Array) -> None:
        """Write the deck and, beside it, the files that it includes."""
        contents = self._contents(points)
        in_place = _same(path, self.path)
        targets = [path]
        for grids, content in zip(self.files[1:], contents[1:], strict=True):
            own = grids.deck.source
            target = path.parent / grids.relative
            outside = Path(grids.relative).is_absolute() or ".." in Path(grids.relative).parts
            if content != own.data and not in_place and (outside or _same(target, own.path)):
                raise InputError(
                    f"nodes move in {own.path}, which the deck includes as {grids.relative}: "
                    "write into another folder, or it would be overwritten"
                )
            targets.append(own.path if outside else target)
        together: dict[Path, bytes] = {}
        for target, content, grids in zip(targets[1:], contents[1:], self.files[1:], strict=True):
            if not in_place and _same(target, grids.deck.source.path):
                continue  # an original in which nothing moves
            if not target.exists() or read_bytes(target, to_update=True) != content:
                _make(target.parent)
                together[target] = content
        write_together([*together.items(), (path, contents[0])])
        self._warn(path, points)

    def _warn(self, path: Path, points: Array) -> None:
        moved = points[changed(self.original, points)]
        if any(float(plain(sixteen(value))) != value for value in moved.tolist()):
            warnings.warn(
                f"{path.name}: moved nodes are rounded to the 16 characters of Nastran's fields",
                MeshWarning,
                stacklevel=4,
            )


def _same(one: Path, other: Path) -> bool:
    return os.path.realpath(one) == os.path.realpath(other)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror}") from error


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Nastran deck; see `read_mesh`."""
    files = _files(path, data)
    decks = [Deck(Source(own, text)) for own, _, text in files]
    frame = max(map(_default_frame, decks))
    grids = [_grids(deck, file[1], frame) for deck, file in zip(decks, files, strict=True)]
    ids = np.concatenate([part.ids for part in grids])
    points = np.concatenate([part.points for part in grids])
    if not len(ids):
        raise InputError(f"{path}: there is no GRID in this deck")
    order = np.argsort(ids, kind="stable")
    twice = np.flatnonzero(np.diff(ids[order]) == 0)
    if len(twice):
        raise InputError(f"{path}: GRID {ids[order][twice[0]]} occurs twice")
    progress(0.5)
    cells: dict[str, list[Indices]] = {}
    markers: dict[str, dict[str, list[Indices]]] = {}
    for part in grids:
        for kind, nodes, properties in _elements(part.deck):
            found = np.minimum(np.searchsorted(ids[order], nodes), len(ids) - 1)
            if (ids[order][found] != nodes).any():
                missing = nodes[ids[order][found] != nodes][0]
                raise part.deck.source.failure(f"an element refers to GRID {missing}, not there")
            rows = order[found]
            cells.setdefault(kind, []).append(rows)
            for number in np.unique(properties).tolist():
                inside = markers.setdefault(f"property {number}", {})
                inside.setdefault(kind, []).append(rows[properties == number])
    unread = sum((_unread(part.deck) for part in grids), Counter())
    named: Markers = {name: _joined(parts) for name, parts in markers.items()}
    template = NastranTemplate(path, points, grids)
    return Mesh(points, _joined(cells), named, unread=dict(unread), template=template)


def _joined(parts: dict[str, list[Indices]]) -> Cells:
    return {kind: np.concatenate(nodes) for kind, nodes in parts.items()}


def _files(path: Path, data: bytes) -> list[tuple[Path, str, bytes]]:
    """The deck and all files that it includes: path, name as seen from the deck, content."""
    found, waiting, seen = [], [(path, "", data)], {os.path.realpath(path)}
    while waiting:
        own, relative, text = waiting.pop(0)
        found.append((own, relative, text))
        if len(found) > 10_000:
            raise InputError(f"{path}: includes too many files")
        end = _END.search(text)
        for match in _INCLUDE.finditer(text, 0, end.start() if end else len(text)):
            quoted = match[1] or match[2] or match[3] or b""
            name = "".join(line.strip() for line in quoted.decode("utf-8", "replace").splitlines())
            target, name = _included(path, own, name.replace("\\", "/"))
            if os.path.realpath(target) in seen:
                raise InputError(f"{own}: includes {name}, which is included already")
            seen.add(os.path.realpath(target))
            waiting.append((target, name, read_bytes(target)))
    return found


def _included(deck: Path, own: Path, name: str) -> tuple[Path, str]:
    """An included file and its name as seen from the deck; names may be seen from `own`, too."""
    if (deck.parent / name).exists():
        return deck.parent / name, name
    beside = own.parent / name
    if beside.exists():
        return beside, os.path.relpath(beside, deck.parent)
    raise InputError(f"{own}: cannot read {name}, which it includes: there is no such file")


def _default_frame(deck: Deck) -> int:
    """Frame (CP) of the GRIDs that name none, from a GRDSET card."""
    lines = deck.cards("GRDSET")[:1]
    return int(integers(deck, lines, deck.fields(lines)[:, 1]).sum())


def _grids(deck: Deck, relative: str, frame: int) -> Grids:
    repeated = np.flatnonzero(deck.heads[: deck.count, 0] == ord("="))
    if len(repeated):
        place = int(deck.begins[repeated[0]])
        raise deck.source.error(place, "cards repeated by '=' are not supported")
    small, large = deck.cards("GRID"), deck.cards("GRID", star=True)
    lines = np.sort(np.concatenate([small, large]))
    is_large = np.isin(lines, large)
    fields = grid_fields(deck, lines, is_large)
    ids = integers(deck, lines, fields[:, 0])
    frames = integers(deck, lines, fields[:, 1])
    frames = np.where((fields[:, 1] == BLANK).all(axis=1), frame, frames)
    if frames.any():
        bad = int(np.flatnonzero(frames)[0])
        raise deck.source.error(
            int(deck.begins[lines[bad]]),
            f"GRID {ids[bad]} is given in the local frame {frames[bad]} (CP), not in x, y, z",
        )
    points = np.stack([reals(deck, lines, fields[:, 2 + axis]) for axis in range(3)], axis=1)
    return Grids(deck, relative, ids, points, lines, is_large)


def _elements(deck: Deck) -> list[tuple[str, Indices, Indices]]:
    """Types with node identifiers (k, nodes) and properties (k,)."""
    found = []
    for name in ELEMENTS:
        for star in (False, True):
            lines = deck.cards(name, star)
            if len(lines):
                found += _of_card(deck, name, lines, star)
    return found


def _unread(deck: Deck) -> Counter[str]:
    """Cards of cells that are not known here, which the user is told of."""
    heads = np.ascontiguousarray(deck.heads[: deck.count]).view("S8")[:, 0]
    names, counts = np.unique(heads[deck.heads[: deck.count, 0] == ord("C")], return_counts=True)
    found: Counter[str] = Counter()
    for head, count in zip(names.tolist(), counts.tolist(), strict=True):
        name = head.decode("latin-1").strip().rstrip("*")
        if name not in ELEMENTS and _CARD.fullmatch(name) and not NO_CELL.match(name):
            found[name] += count
    for name, count in found.items():
        warnings.warn(
            f"{deck.source.path.name}: {count} cards {name} are kept but not shown",
            MeshWarning,
            stacklevel=2,
        )
    return found


def _of_card(
    deck: Deck, name: str, lines: Indices, star: bool
) -> list[tuple[str, Indices, Indices]]:
    skipped, types = ELEMENTS[name]
    most = max(types)
    parts, at = [deck.fields(lines, star)], lines.copy()
    on = np.arange(len(lines))  # cards that have not ended yet
    while sum(part.shape[1] for part in parts) < skipped + most:
        at[on] = deck.continuation(at[on], np.full(len(on), star))
        on = on[at[on] >= 0]
        part = np.full_like(parts[0], 32)
        part[on] = deck.fields(at[on], star)
        parts.append(part)
    fields = np.concatenate(parts, axis=1)[:, : skipped + most]
    flat = integers(deck, np.repeat(lines, skipped + most), fields.reshape(-1, WIDTH))
    table = flat.reshape(len(lines), -1)
    nodes = table[:, skipped:]
    properties = table[:, 1] if skipped > 1 else np.zeros(len(lines), dtype=np.int64)
    found = []
    left = np.ones(len(lines), dtype=bool)
    if name in ROUND:
        nodes = nodes[:, [0, 2, 4, 1, 3, 5]]
    for count in sorted(types, reverse=True):
        full = left & (nodes[:, :count] > 0).all(axis=1)
        left &= ~full
        if full.any():
            kind = types[count]
            order = MIDDLE_BEFORE_TOP.get(kind, list(range(count)))
            found.append((kind, nodes[full][:, order], properties[full]))
    if left.any() and name != "CBUSH":  # which may end in the ground
        place = int(deck.begins[lines[left][0]])
        raise deck.source.error(place, f"this element needs {min(types)} nodes")
    return found
