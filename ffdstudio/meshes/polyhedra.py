"""Cells given by their faces, as the faces of a face-based mesh.

Each cell brings all of its faces, so that an inner one is given twice. Files do not agree on
which way such faces look; here each is turned so that it looks out of its own cell, as seen from
the mean of the cell's nodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.mesh import Faces
from ffdstudio.meshes.pairing import ALONE, MANY, loop_partners
from ffdstudio.meshes.topology import FACES, Cells, corners, dimension

PRISMS = {  # by number of nodes: what VTK calls pentagonal and hexagonal prism
    2 * n: (
        tuple(range(n))[::-1],
        tuple(range(n, 2 * n)),
        *((i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)),
    )
    for n in (5, 6)
}


@dataclass(frozen=True, eq=False)
class Loops:
    """Faces as seen from cells: nodes one face after the other, and the cell of each face."""

    nodes: Indices
    sizes: Indices
    cells: Indices


def loops_of(kind: str, nodes: Indices, cells: Indices) -> Loops:
    """Faces of cells of a type with a table of faces, or of `PRISMS`; `cells` are their numbers."""
    table = FACES.get(kind) or PRISMS[nodes.shape[1]]
    flat = np.concatenate([np.array(face) for face in table])
    sizes = np.array([len(face) for face in table])
    return Loops(nodes[:, flat].ravel(), np.tile(sizes, len(nodes)), np.repeat(cells, len(table)))


def faced(
    points: Array,
    cells: Cells,
    solids: Sequence[tuple[str, Indices, Indices]],
    polyhedra: Sequence[Loops],
    what: str,
) -> tuple[Faces, dict[str, int]]:
    """Faces of all volume cells, and the cells that are lost on the way, by type.

    Parameters
    ----------
    points : numpy.ndarray
        (n, 3) coordinates.
    cells : dict
        All cells of known types; plane ones that are no faces of the others are lost.
    solids : sequence
        Type, nodes and number in the file of the volume cells among them, prisms besides.
    polyhedra : sequence of Loops
        The others, by number in the file.
    what : str
        Names the file where it is wrong.
    """
    lost: dict[str, int] = {}
    parts, plain = list(polyhedra), []
    for kind, nodes, place in solids:
        if kind in FACES or kind == "prism":
            plain.append(loops_of(kind, nodes, place))
        else:
            lost[kind] = lost.get(kind, 0) + len(nodes)
    parts += plain
    order = np.unique(np.concatenate([part.cells for part in parts]))
    parts = [Loops(p.nodes, p.sizes, np.searchsorted(order, p.cells)) for p in parts]
    for kind, nodes in cells.items():
        free = 0 if dimension(kind) != 2 else _free(corners(kind, nodes), parts)
        lost |= {kind: free} if free else {}
    return faces_of(points, parts, what), lost


def _free(rows: Indices, parts: Sequence[Loops]) -> int:
    """Number of plane cells that are no face of these."""
    nodes = np.concatenate([rows.ravel(), *(part.nodes for part in parts)])
    sizes = np.concatenate([np.full(len(rows), rows.shape[1]), *(part.sizes for part in parts)])
    partner = loop_partners(nodes, np.concatenate([[0], np.cumsum(sizes)]))[: len(rows)]
    return int(((partner == ALONE) | ((partner >= 0) & (partner < len(rows)))).sum())


def faces_of(points: Array, parts: Iterable[Loops], what: str) -> Faces:
    """Distinct faces with owner and neighbour.

    Raises
    ------
    InputError
        If a face belongs to more than two cells, or twice to one; `what` names the file.

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    >>> two = loops_of("tetra", np.array([[0, 1, 2, 3], [1, 2, 3, 4]]), np.arange(2))
    >>> faces = faces_of(points, [two], "here")
    >>> len(faces), faces.neighbour.max()
    (7, np.int64(1))
    """
    found = list(parts)
    nodes = np.concatenate([part.nodes for part in found])
    sizes = np.concatenate([part.sizes for part in found])
    cells = np.concatenate([part.cells for part in found])
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    partner = loop_partners(nodes, offsets)
    wrong = np.flatnonzero((partner == MANY) | ((partner >= 0) & (cells[partner] == cells)))
    if len(wrong):
        bad = nodes[offsets[wrong[0]] : offsets[wrong[0] + 1]].tolist()
        raise InputError(f"{what}: the face of nodes {bad} (counted from 0) is given too often")
    nodes = _outward(points, nodes, sizes, offsets, cells)
    # of two equal ones the cell with the lower number is the owner
    neighbour = np.where(partner >= 0, cells[partner], -1)
    kept = np.flatnonzero((partner < 0) | (cells < neighbour))
    kept = kept[np.argsort(cells[kept], kind="stable")]
    size = sizes[kept]
    step = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
    return Faces(
        nodes[np.repeat(offsets[kept], size) + step],
        np.concatenate([[0], np.cumsum(size)]),
        cells[kept],
        neighbour[kept],
    )


def _outward(
    points: Array, nodes: Indices, sizes: Indices, offsets: Indices, cells: Indices
) -> Indices:
    """Nodes of the faces, in the reversed order where a face looks into its cell."""
    face = np.repeat(np.arange(len(sizes)), sizes)
    step = np.arange(len(nodes)) - np.repeat(offsets[:-1], sizes)
    last = np.repeat(offsets[1:] - 1, sizes)
    x = points[nodes]
    centre = _means(x, face, len(sizes))
    middle = _means(centre, cells, int(cells.max(initial=-1)) + 1)
    ends = step + 1 == np.repeat(sizes, sizes)
    ahead = np.where(ends, np.repeat(offsets[:-1], sizes), np.arange(len(nodes)) + 1)
    area = np.cross(x - centre[face], points[nodes[ahead]] - centre[face])
    out = np.einsum("ij,ij->i", _sums(area, face, len(sizes)), centre - middle[cells])
    inward = np.repeat(out < 0, sizes)
    return np.where(inward, nodes[last - step], nodes)


def _sums(values: Array, groups: Indices, count: int) -> Array:
    return np.column_stack([np.bincount(groups, column, count) for column in values.T])


def _means(values: Array, groups: Indices, count: int) -> Array:
    return (
        _sums(values, groups, count) / np.maximum(np.bincount(groups, minlength=count), 1)[:, None]
    )
