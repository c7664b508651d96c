"""Gmsh meshes: MSH 1.0, 2.x, 4.0 and 4.1, ASCII and binary.

1. Nodes carry tags of any order; cells refer to tags. Here they become indices from 0.
2. In 4.1 a block of nodes has all its tags first, then the coordinates; nodes with parameters
   on their curve or surface have these behind x y z. Tags and parameters are kept.
3. Physical groups become markers. Before 4.0 the cell names its group, since then its entity
   does, also one that a partition has cut. Before 4.0 an element of two groups stands in the
   file twice, which makes one cell. What $Entities says of the geometry stays as it is.
4. Nodes that $Periodic pairs are linked.

Source: Gmsh reference manual, "File formats".
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.gmsh_periodic import Periodic, links_of
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh, Template
from ffdstudio.meshes.topology import Cells, dimension

KINDS = ("point", "curve", "surface", "volume")
NAMES = {  # Gmsh's number -> name and number of nodes
    1: ("line", 2),
    2: ("triangle", 3),
    3: ("quad", 4),
    4: ("tetra", 4),
    5: ("hexahedron", 8),
    6: ("wedge", 6),
    7: ("pyramid", 5),
    8: ("line3", 3),
    9: ("triangle6", 6),
    10: ("quad9", 9),
    11: ("tetra10", 10),
    12: ("hexahedron27", 27),
    13: ("wedge18", 18),
    14: ("pyramid14", 14),
    15: ("vertex", 1),
    16: ("quad8", 8),
    17: ("hexahedron20", 20),
    18: ("wedge15", 15),
    19: ("pyramid13", 13),
    21: ("triangle10", 10),
    23: ("triangle15", 15),
    25: ("triangle21", 21),
    26: ("line4", 4),
    27: ("line5", 5),
    28: ("line6", 6),
    29: ("tetra20", 20),
    30: ("tetra35", 35),
    31: ("tetra56", 56),
    36: ("quad16", 16),
    37: ("quad25", 25),
    38: ("quad36", 36),
    92: ("hexahedron64", 64),
    93: ("hexahedron125", 125),
}
ORDER = {  # VTK's order of the nodes where Gmsh has another one
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    "hexahedron27": [
        *(0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17),
        *(10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26),
    ],
    "quad16": [*range(8), 9, 8, 11, 10, 12, 13, 15, 14],
    "wedge15": [*range(6), 6, 9, 7, 12, 14, 13, 8, 10, 11],
    "wedge18": [*range(6), 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16],
    "pyramid13": [*range(5), 5, 8, 10, 6, 7, 9, 11, 12],
    "pyramid14": [*range(5), 5, 8, 10, 6, 7, 9, 11, 12, 13],
}


class Nodes(NamedTuple):
    """Tags of the nodes in the order of the file, and the template that holds them."""

    tags: Indices
    template: Template


class Elements(NamedTuple):
    """Elements of one type with the tags of their nodes, and the group of each.

    `groups` holds physical tags, (k,) with 0 for none, and `owners` the tags of their entities;
    or, since 4.0, `entity` is the entity that they all belong to.
    """

    type: int
    nodes: Indices
    groups: Indices
    entity: int = 0
    owners: Indices | None = None


class GmshLayout(Protocol):
    """How one version writes its sections."""

    def nodes(self) -> Nodes:
        """Read the nodes."""

    def elements(self) -> list[Elements]:
        """Read the elements."""

    def entities(self) -> dict[tuple[int, int], list[int]]:
        """Physical tags by dimension and tag of the entity."""

    def periodic(self) -> list[Periodic]:
        """Pairs of entities whose nodes correspond."""


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Gmsh mesh; see `read_mesh`."""
    source = Source(path, data)
    sections = _sections(source)
    progress(0.1)
    layout = _layout(source, sections)
    nodes = layout.nodes()
    progress(0.5)
    entities = layout.entities()
    parts: dict[str, list[Indices]] = {}
    groups: dict[tuple[int, int], dict[str, list[Indices]]] = {}
    find = _Finder(source, nodes.tags)
    names = _physical_names(source, sections)
    titles: dict[tuple[int, int], str] = {}
    for elements in layout.elements():
        name, cells = _cells(find, elements)
        parts.setdefault(name, []).append(cells[_is_first(elements)])
        titles |= _titles(elements, dimension(name), entities, names)
        for key, chosen in _membership(elements, dimension(name), entities):
            groups.setdefault(key, {}).setdefault(name, []).append(cells[chosen])
    points = nodes.template.original
    flat = not (points[:, 2] != 0).any() and not any(dimension(name) == 3 for name in parts)
    return Mesh(
        points,
        _joined(parts),
        _markers(names, groups),
        dimension=2 if flat else 3,
        links=tuple(links_of(layout.periodic(), find, titles)),
        template=nodes.template,
    )


def _sections(source: Source) -> dict[str, tuple[int, int]]:
    """Begin and end of what each section holds."""
    data = source.data
    found: dict[str, tuple[int, int]] = {}
    at = data.find(b"$")
    while at >= 0:
        begin = source.line_end(at)
        name = data[at + 1 : begin].strip().decode("latin-1")
        closing = name.upper() if name.isupper() else name
        mark = (b"$END" if name.isupper() else b"$End") + closing.encode("latin-1")
        end = data.find(mark, begin)
        if end < 0:
            raise source.error(at, f"section ${name[:30]} does not end")
        found.setdefault(name, (begin, end))
        at = data.find(b"$", end + len(mark))
    return found


def _layout(source: Source, sections: dict[str, tuple[int, int]]) -> GmshLayout:
    from ffdstudio.meshes.formats import gmsh_40, gmsh_binary, gmsh_text

    if "NOD" in sections:
        return gmsh_text.Old(source, sections, 1)
    if "MeshFormat" not in sections:
        raise source.failure("there is neither $MeshFormat nor $NOD: not a Gmsh mesh?")
    begin, _ = sections["MeshFormat"]
    end = source.line_end(begin)
    words = source.data[begin:end].split()
    if len(words) < 3:
        raise source.error(begin, "expected version, file type and data size")
    version = words[0].decode("latin-1")
    size = source.integer(words[2], begin, "the data size")
    if not (version.startswith("2.") or version in ("2", "4", "4.0", "4.1")):
        raise source.error(begin, f"MSH {version[:10]} is not supported; save it as 4.1 or 2.2")
    if words[1] == b"0":
        if version.startswith("2"):
            return gmsh_text.Old(source, sections, 2)
        return (gmsh_text.New if version == "4.1" else gmsh_40.Text)(source, sections)
    if size not in ((8,) if version.startswith("2") else (4, 8)):
        raise source.error(begin, f"a data size of {size} is not supported")
    one = source.data[end : end + 4]
    orders = {b"\x01\0\0\0": "<", b"\0\0\0\x01": ">"}
    if one not in orders:
        raise source.error(end, "the mark of the byte order is damaged")
    if version == "4.1":
        return gmsh_binary.New(source, sections, orders[one], size)
    if version.startswith("4"):
        return gmsh_40.Binary(source, sections, orders[one], size)
    return gmsh_binary.Old(source, sections, orders[one])


class _Finder:
    """Indices of nodes from their tags."""

    def __init__(self, source: Source, tags: Indices) -> None:
        self.source = source
        self.order = np.argsort(tags, kind="stable")
        self.sorted = tags[self.order]
        twice = np.flatnonzero(self.sorted[1:] == self.sorted[:-1])
        if len(twice):
            raise source.failure(f"node tag {self.sorted[twice[0]]} occurs twice")

    def __call__(self, tags: Indices) -> Indices:
        if not len(self.sorted):
            raise self.source.failure("there are elements but no nodes")
        place = np.minimum(np.searchsorted(self.sorted, tags), len(self.sorted) - 1)
        wrong = self.sorted[place] != tags
        if wrong.any():
            raise self.source.failure(
                f"an element refers to node {tags[wrong][0]}, which is not there"
            )
        return self.order[place]


def _cells(find: _Finder, elements: Elements) -> tuple[str, Indices]:
    """Name and (k, nodes) indices in VTK's order."""
    name, count = NAMES[elements.type]
    if elements.nodes.shape[1] != count:
        raise find.source.failure(
            f"a {name} has {count} nodes, found one with {elements.nodes.shape[1]}"
        )
    nodes = find(elements.nodes)
    return name, nodes[:, ORDER[name]] if name in ORDER else nodes


def _is_first(elements: Elements) -> NDArray[np.bool_]:
    """Whether elements do not repeat an earlier one for another group of its entity."""
    first = np.ones(len(elements.nodes), dtype=bool)
    owners, groups = elements.owners, elements.groups
    if owners is None or len(groups) == 0 or (groups == groups[0]).all():
        return first
    pairs = np.stack([owners, groups], axis=1)
    runs = np.flatnonzero(np.append(True, (pairs[1:] != pairs[:-1]).any(axis=1)))
    pairs = np.unique(pairs[runs], axis=0)[:, 0]
    repeated = np.flatnonzero(np.isin(owners, pairs[1:][np.diff(pairs) == 0]))
    _, kept = np.unique(elements.nodes[repeated], axis=0, return_index=True)
    first[repeated] = False
    first[repeated[kept]] = True
    return first


def _membership(
    elements: Elements, dim: int, entities: dict[tuple[int, int], list[int]]
) -> list[tuple[tuple[int, int], slice | Indices]]:
    """Physical groups of the elements, as (dimension, tag), with the rows in them."""
    if elements.entity:
        tags = entities.get((dim, elements.entity), [])
        return [((dim, abs(tag)), slice(None)) for tag in tags]
    return [
        ((dim, int(tag)), np.flatnonzero(elements.groups == tag))
        for tag in np.unique(elements.groups)
        if tag != 0
    ]


def _titles(
    elements: Elements,
    dim: int,
    entities: dict[tuple[int, int], list[int]],
    names: dict[tuple[int, int], str],
) -> dict[tuple[int, int], str]:
    """Names of the entities that these elements belong to, where they have a physical group."""
    if elements.entity:
        tags = entities.get((dim, elements.entity), [])
        groups = {elements.entity: abs(tags[0])} if tags else {}
    elif elements.owners is not None:
        pairs = np.unique(np.stack([elements.owners, elements.groups], axis=1), axis=0)
        groups = dict(reversed(pairs.tolist()))
    else:
        groups = {}
    return {
        (dim, entity): names.get((dim, tag), f"physical {KINDS[dim]} {tag}")
        for entity, tag in groups.items()
        if tag
    }


def _markers(
    names: dict[tuple[int, int], str],
    groups: dict[tuple[int, int], dict[str, list[Indices]]],
) -> Markers:
    markers: Markers = {}
    for (dim, tag), parts in sorted(groups.items()):
        name = names.get((dim, tag), f"physical {KINDS[dim]} {tag}")
        if name in markers:
            name = f"{name} ({KINDS[dim]})"
        markers[name] = _joined(parts)
    return markers


def _physical_names(
    source: Source, sections: dict[str, tuple[int, int]]
) -> dict[tuple[int, int], str]:
    begin, end = sections.get("PhysicalNames", (0, 0))
    names = {}
    for line in source.data[begin:end].splitlines()[1:]:
        words = line.split(None, 2)
        if len(words) == 3 and words[0].isdigit() and words[1].lstrip(b"-").isdigit():
            text = decoded(words[2].strip().strip(b'"'))
            names[int(words[0]), int(words[1])] = text
    return names


def _joined(parts: dict[str, list[Indices]]) -> Cells:
    return {name: np.concatenate(found) for name, found in parts.items()}


def finite(source: Source, points: Array, tags: Indices) -> Array:
    """Points of a binary file if all are finite numbers."""
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"node {tags[bad[0]]} has a coordinate that is not finite")
    return points
