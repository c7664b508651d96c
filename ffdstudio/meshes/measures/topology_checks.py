"""How the cells of a mesh hang together, checked as OpenFOAM's checkMesh does.

What is counted (checkMesh -allTopology says the same in brackets):

- points that no cell uses ("Unused points");
- faces given again ("identical duplicate faces"), in a mesh of cells those of over two cells;
- cells with the nodes of another one;
- cells whose faces do not close: an edge that is not one of exactly two of them ("Open cells");
- edges where more than two outer faces meet ("multiply connected (shared edge)"), or, on a surface,
  more than two cells;
- regions: cells that no way through faces joins ("Number of regions");
- faces that do not follow their cells, in files that list faces ("upper triangular order").
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.aliases import AnyArray, Indices, Mask
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.measures.recognise import ramps, recognised, sides
from ffdstudio.meshes.mesh import Faces, Mesh
from ffdstudio.meshes.pairing import loop_partners
from ffdstudio.meshes.topology import corners, dimension

TITLES = {
    "unused_points": "unused points",
    "duplicate_faces": "duplicate faces",
    "duplicate_cells": "duplicate cells",
    "open_cells": "open cells",
    "non_manifold_edges": "edges of over two outer faces",
    "unordered_faces": "faces out of upper-triangular order",
}


@dataclass(frozen=True)
class Connections:
    """What was found; 0 everywhere and one region are a sound mesh.

    Attributes
    ----------
    unordered_faces : int or None
        None where the file lists cells: then there is no order to keep.
    """

    unused_points: int
    duplicate_faces: int
    duplicate_cells: int
    open_cells: int
    non_manifold_edges: int
    regions: int
    unordered_faces: int | None = None

    @property
    def faults(self) -> dict[str, int]:
        """What is not sound, by its title; several regions are told but no fault."""
        return {title: count for name, title in TITLES.items() if (count := getattr(self, name))}

    def __str__(self) -> str:
        found = ", ".join(f"{count} {title}" for title, count in self.faults.items())
        regions = f"{self.regions} region" + ("s" if self.regions != 1 else "")
        return f"{found or 'no faults'}; {regions}"

    def to_dict(self) -> dict[str, int | None]:
        """Return the counts by name."""
        return asdict(self)


_known: WeakKeyDictionary[Mesh, Connections] = WeakKeyDictionary()


def connections(mesh: Mesh) -> Connections:
    """Check how the cells of a mesh hang together; once for each mesh.

    Examples
    --------
    >>> two = [[0, 1, 2, 3], [1, 2, 3, 4]]
    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [9, 9, 9]]
    >>> print(connections(Mesh(points, {"tetra": two})))
    1 unused points; 1 region
    """
    if mesh not in _known:
        _known[mesh] = _checked(mesh)
    return _known[mesh]


def _checked(mesh: Mesh) -> Connections:
    faces = topology_of(mesh).faces
    count = blocks_of(mesh).count
    return Connections(
        unused_points=_unused(mesh),
        duplicate_faces=_twice(faces),
        duplicate_cells=_same_cells(mesh),
        open_cells=int(_open(mesh.faces).sum()) if mesh.faces is not None else 0,
        non_manifold_edges=_branches(mesh, faces),
        regions=_regions(faces, count),
        unordered_faces=None if mesh.faces is None else _unordered(mesh.faces),
    )


def _unused(mesh: Mesh) -> int:
    used = np.zeros(len(mesh.points), dtype=bool)
    if mesh.faces is not None:
        used[mesh.faces.nodes] = True
    for nodes in mesh.cells.values():
        used[nodes] = True
    return int((~used).sum())


def _twice(faces: Faces) -> int:
    """Faces with the nodes of an earlier one."""
    partner = _groups(faces.nodes, faces.offsets)
    return int((partner != np.arange(len(partner))).sum())


def _groups(nodes: Indices, offsets: Indices) -> Indices:
    """The first list with the same nodes, for each of these lists; itself if there is none."""
    first = np.arange(len(offsets) - 1)
    partner = loop_partners(nodes, offsets)
    paired = np.flatnonzero(partner >= 0)
    first[paired] = np.minimum(paired, partner[paired])
    many: dict[tuple[int, ...], int] = {}
    for k in np.flatnonzero(partner < -1).tolist():
        key = tuple(np.sort(nodes[offsets[k] : offsets[k + 1]]).tolist())
        first[k] = many.setdefault(key, k)
    return first


def _same_cells(mesh: Mesh) -> int:
    """Cells with the nodes of an earlier one of their type."""
    if mesh.faces is not None:
        known, _ = recognised(mesh.faces)
        rows = [nodes for nodes, _ in known.values()]
    else:
        top = blocks_of(mesh).dimension
        rows = [corners(k, nodes) for k, nodes in mesh.cells.items() if dimension(k) == top]
    return sum(_repeated(nodes) for nodes in rows)


def _repeated(nodes: Indices) -> int:
    """Rows with the nodes of an earlier one: candidates by a sum of random numbers of nodes."""
    if not len(nodes):
        return 0
    numbers = np.random.default_rng(0).integers(2**63, size=nodes.max() + 1, dtype=np.uint64)
    key = numbers[nodes[:, 0]]
    for column in nodes.T[1:]:
        key = key + numbers[column]
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, other = np.sort(nodes[order[same]], axis=1), np.sort(nodes[order[same + 1]], axis=1)
    return int((one == other).all(axis=1).sum())


def _open(faces: Faces) -> Mask:
    """Cells with an edge that is not one of exactly two of their faces."""
    _, rest = recognised(faces)  # the others are closed, or they would not have been recognised
    out = np.zeros(faces.cells, dtype=bool)
    cell, face, _ = sides(faces)
    mine = rest[cell]
    cell, face = cell[mine], face[mine]
    low, high, step = _edges(faces, face)
    rows = np.stack([np.repeat(cell, step), low, high], axis=1)
    found, times = np.unique(rows, axis=0, return_counts=True)
    out[found[times != 2, 0]] = True
    return out


def _edges(faces: Faces, chosen: Indices) -> tuple[Indices, Indices, Indices]:
    """Lower and higher node of the edges of faces, one face after the other; and their numbers."""
    size = np.diff(faces.offsets)[chosen]
    step, begin = ramps(size), np.repeat(faces.offsets[chosen], size)
    here = faces.nodes[begin + step]
    ahead = faces.nodes[begin + (step + 1) % np.repeat(size, size)]
    return np.minimum(here, ahead), np.maximum(here, ahead), size


def _branches(mesh: Mesh, faces: Faces) -> int:
    """Edges of more than two outer faces, or of more than two cells of a surface."""
    if blocks_of(mesh).dimension == 3:
        low, high, _ = _edges(faces, np.flatnonzero(faces.neighbour < 0))
    else:
        low, high = _sides_of_cells(mesh)
    apart = low != high
    _, times = np.unique(low[apart] * len(mesh.points) + high[apart], return_counts=True)
    return int((times > 2).sum())


def _sides_of_cells(mesh: Mesh) -> tuple[Indices, Indices]:
    rows = [corners(k, nodes) for k, nodes in mesh.cells.items() if dimension(k) == 2]
    here = np.concatenate([nodes.ravel() for nodes in rows])
    ahead = np.concatenate([np.roll(nodes, -1, axis=1).ravel() for nodes in rows])
    return np.minimum(here, ahead), np.maximum(here, ahead)


def _regions(faces: Faces, cells: int) -> int:
    """Number of sets of cells that faces join."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    inner = faces.neighbour >= 0
    ends: tuple[AnyArray, AnyArray] = faces.owner[inner], faces.neighbour[inner]
    graph = coo_array((np.ones(len(ends[0]), dtype=np.int8), ends), shape=(cells, cells))
    return int(connected_components(graph, directed=False)[0])


def _unordered(faces: Faces) -> int:
    """Inner faces that are not in the order of owner, then neighbour, or have them exchanged."""
    inner = faces.neighbour >= 0
    own, other = faces.owner[inner], faces.neighbour[inner]
    behind = (own[1:] < own[:-1]) | ((own[1:] == own[:-1]) & (other[1:] <= other[:-1]))
    late = int((~inner[: int(inner.sum())]).sum())  # outer faces among the inner ones
    return int(behind.sum()) + int((own > other).sum()) + late
