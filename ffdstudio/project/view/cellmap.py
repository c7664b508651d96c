"""Which cell each displayed polygon belongs to, so that a measure per cell can be drawn."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.project.view.surface import DisplaySurface

NO_CELL = -1


def cells_of(mesh: Mesh, surface: DisplaySurface) -> Indices:
    """(p,) number of the cell of each polygon of a surface, as quality reports count; -1 for none.

    The polygons of a plane mesh or a surface are its cells, those of a volume mesh the outer
    faces of its cells.

    Examples
    --------
    >>> from ffdstudio.project.view.surface import surface_of
    >>> tetra = Mesh(np.eye(4)[:, :3], {"tetra": [[0, 1, 2, 3]]})
    >>> cells_of(tetra, surface_of(tetra)).tolist()
    [0, 0, 0, 0]
    """
    count = len(surface.offsets) - 1
    if blocks_of(mesh).dimension == 2:
        return np.arange(count)
    faces = topology_of(mesh).faces
    outer = np.flatnonzero(faces.neighbour < 0)
    face_sizes, sizes = np.diff(faces.offsets)[outer], np.diff(surface.offsets)
    nodes = surface.nodes[surface.connectivity]
    found = np.full(count, NO_CELL)
    for size in np.unique(sizes):
        polygons, candidates = np.flatnonzero(sizes == size), outer[face_sizes == size]
        if len(candidates):
            drawn = _rows(nodes, surface.offsets[polygons], size)
            place = _match(drawn, _rows(faces.nodes, faces.offsets[candidates], size))
            found[polygons] = np.where(place >= 0, faces.owner[candidates[place]], NO_CELL)
    return found


def _rows(nodes: Indices, begin: Indices, size: int) -> Indices:
    """(k, size) sorted nodes of polygons of one size."""
    return np.sort(nodes[begin[:, None] + np.arange(size)], axis=1)


def _match(rows: Indices, among: Indices) -> Indices:
    """(k,) where each row stands among others; -1 where it does not."""
    numbers = np.random.default_rng(0).integers(
        2**63, size=1 + max(rows.max(initial=0), among.max(initial=0))
    )
    key, keys = numbers[rows].sum(axis=1), numbers[among].sum(axis=1)
    order = np.argsort(keys)
    place = order[np.minimum(np.searchsorted(keys, key, sorter=order), len(order) - 1)]
    same = (among[place] == rows).all(axis=1)
    return np.where(same, place, -1)
