"""Whether the Jacobian of a hexahedron or wedge keeps one sign inside the cell.

1. Positive corners are not enough. A hexahedron's Jacobian is a polynomial of degree 2 in each
   direction and lies between the least and the largest of its 27 Bezier coefficients: all
   positive means valid. A coefficient at a corner of the parameter box is a value: not positive
   means folded. What stays undecided is split in eight (Johnen, Remacle, Geuzaine, "Geometrical
   validity of curvilinear finite elements", J. Comput. Phys. 233, 2013).
2. A wedge's Jacobian is linear over the triangle and quadratic from bottom to top, so its sign
   is decided by three quadratics at the triangle's corners, exactly.
3. Most hexahedra are nearly parallelepipeds. For them a bound of the determinant by the mean
   edges and the largest deviation from these is enough, and much cheaper.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.curved import coefficients, order_of
from ffdstudio.meshes.measures.vectors import cross, dot, gathered, length, pieces, triple

INSIDE = ("wedge", "hexahedron")
DEPTH, SHALLOW = 10, 4  # splits of linear cells, and of those of higher order
HEX_EDGES = (  # along u, v, w; the other two parameters run as (0,0), (1,0), (0,1), (1,1)
    ((0, 1), (3, 2), (4, 5), (7, 6)),
    ((0, 3), (1, 2), (4, 7), (5, 6)),
    ((0, 4), (1, 5), (3, 7), (2, 6)),
)
MIDDLE = np.array([[1.0, 0.0, 0.0], [-0.5, 2.0, -0.5], [0.0, 0.0, 1.0]])  # values -> Bezier


def folded(block: CellBlock, points: Array) -> np.ndarray:
    """(k,) whether the Jacobian of a cell that `has_inside` is not of one sign."""
    out = np.zeros(len(block.nodes), dtype=bool)
    test = {"wedge": _wedges, "hexahedron": _hexahedra}.get(block.type, _curved(block.type))
    for piece in pieces(len(out)):
        out[piece] = test(gathered(points, block.nodes[piece]))
    return out


def has_inside(kind: str) -> bool:
    """Whether cells of a type can be negative inside with good corners, and are looked into."""
    return kind in INSIDE or order_of(kind) > 0


def _curved(kind: str) -> Callable[[Array], np.ndarray]:
    return lambda x: _undecided(coefficients(kind, x), SHALLOW)


def coefficients_of(kind: str) -> Callable[[Array], Array]:
    """Function from (3, nodes, k) to coefficients, the last axis of which are the cells."""
    known = {"hexahedron": hex_coefficients, "wedge": wedge_coefficients}
    return known.get(kind, partial(coefficients, kind))


# ---- wedges ------------------------------------------------------------------------------


def _wedges(x: Array) -> np.ndarray:
    """Whether one of the quadratics is not of the sign of their sum."""
    values = wedge_coefficients(x)
    values = values * np.sign(values.sum(axis=(0, 1)))
    a, b, c = values.transpose(1, 0, 2)
    low = np.minimum(a, c) <= 0
    # inside the interval a Bezier quadratic with a, c > 0 reaches zero if b <= -sqrt(a c)
    dip = b <= -np.sqrt(np.maximum(a * c, 0))
    result: np.ndarray = (low | dip).any(axis=0)
    return result


def wedge_coefficients(x: Array) -> Array:
    """(3 corners, 3 Bezier coefficients, k) of the Jacobian of wedges (3, 6, k)."""
    r = x[:, [1, 4]] - x[:, [0, 3]]
    s = x[:, [2, 5]] - x[:, [0, 3]]
    up = x[:, 3:] - x[:, :3]
    across = cross(r, s)
    middle = (cross(r[:, 0], s[:, 1]) + cross(r[:, 1], s[:, 0])) / 2
    normals = np.stack([across[:, 0], middle, across[:, 1]], axis=1)
    return dot(up[:, :, None], normals[:, None])


# ---- hexahedra ---------------------------------------------------------------------------


def _hexahedra(x: Array) -> np.ndarray:
    doubt = np.flatnonzero(~_nearly_straight(x))
    out = np.zeros(x.shape[-1], dtype=bool)
    out[doubt] = _undecided(hex_coefficients(x[..., doubt]))
    return out


def hex_edges(x: Array) -> list[Array]:
    """Three arrays (3, 4, k) of the edges along u, v, w."""
    return [x[:, [b for _, b in e]] - x[:, [a for a, _ in e]] for e in HEX_EDGES]


def _nearly_straight(x: Array) -> np.ndarray:
    """Whether |det of the mean edges| exceeds all that the deviations can take away."""
    straight, larger = [], []
    for edge in hex_edges(x):
        mean = edge.sum(axis=1) / 4
        straight.append(mean)
        larger.append((length(mean), np.sqrt(_square(edge - mean[:, None]).max(axis=0))))
    (a, da), (b, db), (c, dc) = larger
    result: np.ndarray = np.abs(triple(*straight)) > (a + da) * (b + db) * (c + dc) - a * b * c
    return result


def _square(a: Array) -> Array:
    return dot(a, a)


def hex_coefficients(x: Array) -> Array:
    """(3, 3, 3, k) Bezier coefficients in u, v, w of the Jacobian of hexahedra (3, 8, k)."""
    u, v, w = (_at_middles(edge) for edge in hex_edges(x))
    values = triple(u[:, None], v[:, :, None], w[:, :, :, None])
    return bezier(values)


def _at_middles(edge: Array) -> Array:
    """(3, 3, 3, k) edge vectors at 0, 1/2, 1 of the other two parameters."""
    e = edge.reshape(3, 2, 2, -1)  # second parameter, first parameter
    e = np.stack([e[:, 0], (e[:, 0] + e[:, 1]) / 2, e[:, 1]], axis=1)
    return np.stack([e[:, :, 0], (e[:, :, 0] + e[:, :, 1]) / 2, e[:, :, 1]], axis=1)


def bezier(values: Array) -> Array:
    """Bezier coefficients from values at 0, 1/2, 1 in the first three axes."""
    for axis in range(3):
        values = np.moveaxis(np.tensordot(MIDDLE, values, axes=(1, axis)), 0, axis)
    return values


def _undecided(values: Array, depth: int = DEPTH) -> np.ndarray:
    """Whether polynomials (a, b, c, k) are not of one sign; what is left open at last is not."""
    count = values.shape[-1]
    open_boxes = values * np.sign(values.sum(axis=(0, 1, 2)))
    cell, bad = np.arange(count), np.zeros(count, dtype=bool)
    for _ in range(depth):
        bad[cell[(open_boxes[[0, -1]][:, [0, -1]][:, :, [0, -1]] <= 0).any(axis=(0, 1, 2))]] = True
        keep = np.flatnonzero((open_boxes <= 0).any(axis=(0, 1, 2)) & ~bad[cell])
        if not len(keep):
            return bad
        open_boxes = halves(open_boxes[..., keep])
        cell = np.tile(cell[keep], open_boxes.shape[-1] // len(keep))
    bad[_cells_left(open_boxes, cell)] = True
    return bad


def _cells_left(boxes: Array, cell: Indices) -> Indices:
    return np.unique(cell[(boxes <= 0).any(axis=(0, 1, 2))])


def halves(boxes: Array) -> Array:
    """Eight times as many boxes: each halved in the first three axes (de Casteljau).

    An axis of one coefficient is not halved: a plane has four times as many.
    """
    for axis in range(3):
        left = list(np.moveaxis(boxes, axis, 0))
        if len(left) == 1:
            continue
        low, high = [left[0]], [left[-1]]
        while len(left) > 1:
            left = [(a + b) / 2 for a, b in pairwise(left)]
            low.append(left[0])
            high.insert(0, left[-1])
        both = [np.stack(part, axis=axis) for part in (low, high)]
        boxes = np.concatenate(both, axis=-1)
    return boxes
