"""The drags that keep cells valid, as half-spaces h . D < 1.

1. All nodes move by x0 + b D with one common vector D. The determinant of a corner's edges
   e_i + (b_i - b_0) D is then exactly linear in D, V + g . D: the terms of higher order have
   parallel columns. With the sign the corner has, D is safe while h . D < 1, h = -g / V.
2. Along a direction only the largest h . D counts, and that is reached at a vertex of the convex
   hull of all h: what lies inside the hull of a few extreme ones can be dropped unseen, and the
   vertices of the rest answer for a million cells in every direction.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.corners import edges, unit
from ffdstudio.meshes.measures.vectors import cross, dot, gathered, pieces

ROUGH, FINE = 12, 64  # directions whose extreme points make the polytopes, tried in turn
SLICE = 2048  # vectors compared at once: with the facets they fit the cache
MANY = 20_000  # half-spaces that the hull is made of at once


def corner_halfspaces(
    block: CellBlock, start: Array, influence: Array, signs: Array, up: Array | None
) -> tuple[Array, Indices]:
    """(m, 3) vectors h of the corners of cells, and the cells they belong to.

    `influence` is b by extended point, `signs` those of the undeformed corners (corners, k).
    Corners that do not turn with D, have no sign or are inverted already set no limit.
    """
    x = gathered(start, block.nodes)
    b = influence[block.nodes].T
    parts, cells = [], []
    for corner, sign in zip(block.corners, signs, strict=True):
        normal = None if up is None else unit(cross(*edges(gathered(up, block.nodes), corner)))
        e = edges(x, corner)
        volume, gradient = _linear(e, [b[i] - b[corner[0]] for i in corner[1:]], normal)
        volume = volume * sign
        some = np.flatnonzero((volume > 0) & (gradient != 0).any(axis=0))
        parts.append((-gradient[:, some] * (sign[some] / volume[some])).T)
        cells.append(block.cells[some])
    return np.concatenate(parts), np.concatenate(cells)


def _linear(e: list[Array], b: list[Array], normal: Array | None) -> tuple[Array, Array]:
    """Jacobian of the edges and its gradient (3, k) by the common vector D."""
    if len(e) == 3:
        first = cross(e[1], e[2])
        gradient = b[0] * first + b[1] * cross(e[2], e[0]) + b[2] * cross(e[0], e[1])
        return dot(e[0], first), gradient
    turned = b[1] * e[0] - b[0] * e[1]  # d (e0 x e1) = turned x D
    if normal is None:
        area = e[0][0] * e[1][1] - e[0][1] * e[1][0]
        return area, np.stack([-turned[1], turned[0], np.zeros_like(area)])
    return dot(cross(*e), normal), cross(normal, turned)


class Region:
    """Half-spaces that are collected and thinned to those that count.

    Attributes
    ----------
    vectors, cells : numpy.ndarray
        (m, 3) h and the cell of each.
    """

    def __init__(self) -> None:
        self.vectors, self.cells = np.empty((0, 3)), np.empty(0, dtype=np.int64)
        self._waiting: list[tuple[Array, Indices]] = []
        self._count, self._radius = 0, 0.0
        self._polytopes: list[Array] = []

    def add(self, vectors: Array, cells: Indices) -> None:
        """Take half-spaces in; what the polytope known so far covers is dropped."""
        keep = np.flatnonzero((vectors * vectors).sum(axis=1) >= max(self._radius, 0.0) ** 2)
        keep = keep[self.outside(vectors[keep])]
        self._waiting.append((vectors[keep], cells[keep]))
        self._count += len(keep)
        if self._count > MANY:
            self.thin()

    def thin(self) -> None:
        """Keep the vertices of the convex hull, and learn what can be dropped at sight."""
        vectors = np.concatenate([self.vectors, *(v for v, _ in self._waiting)])
        cells = np.concatenate([self.cells, *(c for _, c in self._waiting)])
        self._waiting, self._count = [], 0
        if len(vectors):
            keep = _vertices(vectors)
            vectors, cells = vectors[keep], cells[keep]
            found = [_facets(vectors, count) for count in (ROUGH, FINE)]
            self._polytopes = [facets for facets in found if len(facets)]
            self._radius = max((-float(x[:, 3].max()) for x in self._polytopes), default=0.0)
        self.vectors, self.cells = vectors, cells

    def outside(self, vectors: Array) -> np.ndarray:
        """Mask of vectors not covered by the polytopes of those known."""
        mask = np.zeros(len(vectors), dtype=bool)
        for piece in pieces(len(vectors), SLICE):
            left = np.arange(piece.start, piece.stop)
            for facets in self._polytopes:
                slack = 1e-12 * np.abs(facets[:, 3]).max()
                reach = (facets[:, :3] @ vectors[left].T + facets[:, 3:]).max(axis=0)
                left = left[reach > -slack]
            mask[left] = True
        return mask

    def steepest(self, direction: Array) -> tuple[float, int]:
        """Largest h . D and the cell it comes from; 0 and -1 if nothing stands in the way."""
        if not len(self.vectors):
            return 0.0, -1
        values = self.vectors @ direction
        best = int(values.argmax())
        return max(float(values[best]), 0.0), int(self.cells[best])


def _vertices(vectors: Array) -> Indices:
    """Indices of the vertices of the convex hull of the vectors and 0, in the space they span."""
    flat, _ = _spanned(vectors)
    rank = flat.shape[1]
    if rank == 0:
        return np.arange(1)
    if rank == 1:
        return np.unique([flat.argmin(), flat.argmax()])
    hull = _hull(np.vstack([flat, np.zeros(rank)]))
    if hull is None:
        return np.arange(len(vectors))
    vertices: Indices = hull.vertices[hull.vertices < len(vectors)].astype(np.int64)
    return vertices


def _facets(vectors: Array, count: int) -> Array:
    """(k, 4) outward normals and offsets of the polytope of extreme vectors and 0."""
    flat, axes = _spanned(vectors)
    rank = flat.shape[1]
    extreme = np.unique((flat @ _directions(count)[:, :rank].T).argmax(axis=0))
    hull = _hull(np.vstack([flat[extreme], np.zeros(rank)])) if rank > 1 else None
    if hull is None:
        return np.empty((0, 4))
    return np.column_stack([hull.equations[:, :-1] @ axes, hull.equations[:, -1]])


def _hull(points: Array):  # type: ignore[no-untyped-def]
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(points)
    except QhullError:  # too few or too flat for a hull: then nothing is dropped
        return None


def _spanned(vectors: Array) -> tuple[Array, Array]:
    """Coordinates in an orthonormal basis of the span of the vectors, and that basis."""
    _, values, axes = np.linalg.svd(vectors.T @ vectors)
    axes = axes[values > 1e-18 * max(values[0], np.finfo(float).tiny)]
    return vectors @ axes.T, axes


def _directions(count: int) -> Array:
    """Directions spread evenly over the sphere (Fibonacci lattice)."""
    i = np.arange(count) + 0.5
    z, angle = 1 - 2 * i / count, np.pi * (1 + np.sqrt(5)) * i
    radius = np.sqrt(1 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
