"""What the cell types are made of. Node order is VTK's, names are meshio's."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError

Cells = dict[str, Indices]


def numbers(values: ArrayLike, what: str) -> Array:
    """Return real numbers as an array; raises `InputError` for anything else.

    Examples
    --------
    >>> numbers([[1, 2], [3]], "points")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: points must be an array of numbers
    """
    try:
        array = np.asarray(values)
        if not np.iscomplexobj(array):
            return array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        pass
    raise InputError(f"{what} must be an array of numbers")


CORNERS = {
    "vertex": 1,
    "line": 2,
    "triangle": 3,
    "quad": 4,
    "tetra": 4,
    "pyramid": 5,
    "wedge": 6,
    "hexahedron": 8,
}
DIMENSION = {
    "vertex": 0,
    "line": 1,
    "triangle": 2,
    "quad": 2,
    "polygon": 2,
    "tetra": 3,
    "pyramid": 3,
    "wedge": 3,
    "hexahedron": 3,
}
FACES = {  # by corner, normals pointing out of a well-oriented cell
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": (
        (0, 4, 7, 3),
        (1, 2, 6, 5),
        (0, 1, 5, 4),
        (3, 7, 6, 2),
        (0, 3, 2, 1),
        (4, 5, 6, 7),
    ),
}


def base_type(cell_type: str) -> str:
    """Linear type of a cell: "triangle" for "triangle6", "polygon" for "polygon7".

    Examples
    --------
    >>> base_type("hexahedron20")
    'hexahedron'
    """
    return re.sub(r"\d+$", "", cell_type)


def corners(cell_type: str, nodes: Indices) -> Indices:
    """(k, corners) corner nodes of cells of any order; polygons are all corners."""
    return nodes[:, : CORNERS.get(base_type(cell_type), nodes.shape[1])]


def dimension(cell_type: str) -> int:
    """Dimension of a cell type, 0 to 3; 3 for what is not known."""
    return DIMENSION.get(base_type(cell_type), 3)


def skin(cells: Cells) -> Cells:
    """Outer faces of volume cells: the corner faces that occur once, in the order of the cells.

    Examples
    --------
    >>> {kind: len(faces) for kind, faces in skin({"pyramid": np.arange(5)[None]}).items()}
    {'triangle': 4, 'quad': 1}
    """
    from ffdstudio.meshes.pairing import outer

    known = {kind: nodes for kind, nodes in cells.items() if base_type(kind) in FACES}
    sides = [(corners(kind, nodes), FACES[base_type(kind)]) for kind, nodes in known.items()]
    found: dict[str, list[Indices]] = {"triangle": [], "quad": []}
    for (nodes, table), rows in zip(sides, outer(sides), strict=True):
        for face, chosen in zip(table, rows, strict=True):
            kind = "triangle" if len(face) == 3 else "quad"
            found[kind].append(nodes[chosen[:, None], face].astype(np.int64, copy=False))
    return {kind: np.concatenate(faces) for kind, faces in found.items() if faces}
