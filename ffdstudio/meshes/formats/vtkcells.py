"""VTK's cell types, and the cells of structured blocks: shared by several formats."""

from __future__ import annotations

import warnings

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.mesh import MeshWarning
from ffdstudio.meshes.topology import Cells

SIZED = {  # VTK's number -> name and number of nodes
    1: ("vertex", 1),
    3: ("line", 2),
    5: ("triangle", 3),
    9: ("quad", 4),
    10: ("tetra", 4),
    12: ("hexahedron", 8),
    13: ("wedge", 6),
    14: ("pyramid", 5),
    21: ("line3", 3),
    22: ("triangle6", 6),
    23: ("quad8", 8),
    24: ("tetra10", 10),
    25: ("hexahedron20", 20),
    26: ("wedge15", 15),
    27: ("pyramid13", 13),
    28: ("quad9", 9),
    29: ("hexahedron27", 27),
}
SWAPPED = {8: ("quad", [0, 1, 3, 2]), 11: ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6])}
POLYGON = 7
MIDDLE_BEFORE_TOP = {  # VTK's order for formats that list the middle edges before the upper ones
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
}


def cells_of(source: Source, offsets: Indices, nodes: Indices, types: Indices, count: int) -> Cells:
    """Cells by type from VTK's flat arrays.

    Parameters
    ----------
    offsets : numpy.ndarray
        (cells + 1,) where each cell begins in `nodes`.
    nodes, types : numpy.ndarray
        Node indices of all cells, and VTK's number for each cell.
    count : int
        Number of points.

    Raises
    ------
    InputError
        If the arrays do not fit each other or a node does not exist.
    """
    sizes = np.diff(offsets)
    if len(sizes) != len(types) or offsets[0] != 0 or offsets[-1] > len(nodes) or (sizes < 0).any():
        raise source.failure("the offsets, nodes and types of the cells do not fit each other")
    if nodes.size and not (nodes.min() >= 0 and nodes.max() < count):
        raise source.failure(f"a cell refers to a point that is not in 0 to {count - 1}")
    parts: dict[str, list[Indices]] = {}
    for number in np.unique(types).tolist():
        chosen = np.flatnonzero(types == number)
        for name, rows in _rows(source, number, offsets[chosen], sizes[chosen]):
            parts.setdefault(name, []).append(nodes[rows])
    return {name: np.concatenate(found) for name, found in parts.items()}


def _rows(
    source: Source, number: int, begins: Indices, sizes: Indices
) -> list[tuple[str, Indices]]:
    """Names and places of the nodes of cells that have the same VTK number."""
    if number in SIZED or number in SWAPPED:
        name, order = SWAPPED.get(number) or (SIZED[number][0], list(range(SIZED[number][1])))
        if (sizes != len(order)).any():
            raise source.failure(f"a {name} with another number of nodes than {len(order)}")
        return [(name, begins[:, None] + np.array(order))]
    if number != POLYGON:
        warnings.warn(
            f"{source.path.name}: cells of VTK's type {number} are kept but not shown",
            MeshWarning,
            stacklevel=2,
        )
        return []
    return [
        (polygon_name(size), begins[sizes == size][:, None] + np.arange(size))
        for size in np.unique(sizes).tolist()
        if size > 0
    ]


def polygon_name(size: int) -> str:
    """Type of a face with that many corners.

    Examples
    --------
    >>> polygon_name(4), polygon_name(5)
    ('quad', 'polygon5')
    """
    return {1: "vertex", 2: "line", 3: "triangle", 4: "quad"}.get(size, f"polygon{size}")


def offsets_of(sizes: Indices) -> Indices:
    """(k + 1,) where each of k lists of these sizes begins when they follow each other."""
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def block_cells(shape: tuple[int, ...], first: int = 0) -> Cells:
    """Cells of a structured block of nodes, the first index running fastest.

    Directions with a single node do not count: a block of one layer gives quads.

    Examples
    --------
    >>> block_cells((2, 2, 1))
    {'quad': array([[0, 1, 3, 2]])}
    """
    index = first + np.arange(int(np.prod(shape)), dtype=np.int64).reshape(shape[::-1])
    index = index.reshape([n for n in shape[::-1] if n > 1])
    match index.ndim:
        case 1:
            return {"line": np.stack([index[:-1], index[1:]], axis=1)}
        case 2:
            return {"quad": _quads(index[:-1], index[1:])}
        case 3:
            layers = [_layer(index[:-1]), _layer(index[1:])]
            return {"hexahedron": np.concatenate(layers, axis=1)}
    return {}


def _quads(low: Indices, high: Indices) -> Indices:
    corners = [low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]]
    return np.stack([corner.ravel() for corner in corners], axis=1)


def _layer(index: Indices) -> Indices:
    """Quads of every layer of a block, (k, 4)."""
    corners = [index[:, :-1, :-1], index[:, :-1, 1:], index[:, 1:, 1:], index[:, 1:, :-1]]
    return np.stack([corner.ravel() for corner in corners], axis=1)
