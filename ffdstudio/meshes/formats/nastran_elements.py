"""The cards of Nastran's elements."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.card_deck import WIDTH, Deck, integers
from ffdstudio.meshes.formats.vtkcells import MIDDLE_BEFORE_TOP
from ffdstudio.meshes.mesh import MeshWarning

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


class Elements(NamedTuple):
    """Elements of a type: (k, nodes) identifiers of nodes; (k,) numbers, properties and lines."""

    kind: str
    nodes: Indices
    numbers: Indices
    properties: Indices
    lines: Indices


def elements(deck: Deck, section: Indices) -> list[Elements]:
    """Elements of a deck by type; `section` (lines,) tells sections of bulk data apart."""
    found = []
    for name in ELEMENTS:
        for star in (False, True):
            lines = deck.cards(name, star)
            if len(lines):
                parts = _of_card(deck, name, lines, star)
                found += [_single(part, section) for part in parts]
    return found


def unread(deck: Deck) -> Counter[str]:
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


def _of_card(deck: Deck, name: str, lines: Indices, star: bool) -> list[Elements]:
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
            rows = np.stack([table[full, 0], properties[full], lines[full]])
            found.append(Elements(kind, nodes[full][:, order], *rows))
    if left.any() and name != "CBUSH":  # which may end in the ground
        raise deck.error(int(lines[left][0]), f"this element needs {min(types)} nodes")
    return found


def _single(elements: Elements, section: Indices) -> Elements:
    """Elements without those that repeat one of their section with all its nodes."""
    numbers, part = elements.numbers, section[elements.lines]
    order = np.lexsort((numbers, part))
    same = np.flatnonzero((np.diff(numbers[order]) == 0) & (np.diff(part[order]) == 0))
    twice = (elements.nodes[order[same]] == elements.nodes[order[same + 1]]).all(axis=1)
    if not twice.any():
        return elements
    kept = np.ones(len(order), dtype=bool)
    kept[order[same[twice] + 1]] = False
    return Elements(elements.kind, *(part[kept] for part in elements[1:]))
