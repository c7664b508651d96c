"""The strain energy of a mesh that follows, by edges of its cells.

1. Variables that are orthonormal on the surface alone may move the air beside it some 1e5 times
   as far as the wall. Dirichlet's energy of the displacement keeps them together: the integral
   of |grad u|^2 over the mesh in the lattice, over the lattice's volume, times the square of the
   surface's extent, so that it has the unit of the surface's own terms.
2. A corner of a cell gives a share of its volume to each of its edges: on a grid of bricks the
   sum of shares times (change of u along the edge over its length)^2 is the integral itself.
3. No more than `MOST` edges are looked at, chosen by a fixed seed with chances half even and
   half by volume, and weighted by what they stand for (Horvitz and Thompson, 1952).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.mesh import Mesh

MOST = 6000
SHARES = {"triangle": 0.5, "tetra": 1 / 6, "polygon": 0.5, "polyhedron": 1 / 6}


class CellEdges(NamedTuple):
    """CellEdges of cells.

    Attributes
    ----------
    nodes : numpy.ndarray
        (m, 2) indices into the points, the lower one first; each edge once.
    weights : numpy.ndarray
        (m,) volume over squared length.
    lengths : numpy.ndarray
        (m,)
    """

    nodes: Indices
    weights: Array
    lengths: Array

    def among(self, chosen: NDArray[np.bool_]) -> CellEdges:
        """CellEdges with a chosen node."""
        near = chosen[self.nodes].any(axis=1)
        return CellEdges(self.nodes[near], self.weights[near], self.lengths[near])

    def sampled(self, most: int = MOST) -> CellEdges:
        """At most so many edges that stand for all."""
        if len(self.nodes) <= most:
            return self
        volumes = self.weights * self.lengths**2
        chance = 0.5 / len(volumes) + 0.5 * volumes / volumes.sum()
        chance = np.minimum(most * chance, 1.0)
        random = np.random.default_rng(0).uniform(size=len(chance))
        kept = np.flatnonzero(random < chance)
        return CellEdges(self.nodes[kept], self.weights[kept] / chance[kept], self.lengths[kept])

    def rows(self, scale: float) -> tuple[Any, Indices]:
        """Sparse (m, k) differences whose square is the energy, and the k nodes they are of."""
        from scipy.sparse import csr_array

        nodes, place = np.unique(self.nodes, return_inverse=True)
        size = np.sqrt(scale * self.weights)
        values = np.column_stack([-size, size]).ravel()
        rows = np.repeat(np.arange(len(self.nodes)), 2)
        shape = (len(self.nodes), len(nodes))
        return csr_array((values, (rows, place.reshape(-1))), shape), nodes


def edges_of(mesh: Mesh) -> CellEdges:
    """CellEdges of the cells of the highest dimension, without those to the middle of polyhedra.

    Examples
    --------
    >>> square = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
    >>> found = edges_of(Mesh(square, {"quad": [[0, 1, 2, 3]]}, dimension=2))
    >>> found.nodes.tolist(), found.weights.tolist()
    ([[0, 1], [0, 3], [1, 2], [2, 3]], [0.25, 1.0, 1.0, 0.25])
    """
    from ffdstudio.meshes.measures.blocks import blocks_of

    blocks = blocks_of(mesh)
    points = blocks.extended(mesh.points)
    pairs, weights = [np.empty((0, 2), dtype=np.int64)], [np.empty(0)]
    for block in blocks.blocks:
        share = SHARES.get(block.type, 1.0) / len(block.corners)
        for corner in block.corners:
            ends = block.nodes[:, corner[1:]]
            vectors = points[ends] - points[block.nodes[:, corner[0]]][:, None]
            volume = share * _volume(vectors)
            squares = (vectors**2).sum(axis=2)
            for k in range(ends.shape[1]):
                pairs.append(np.column_stack([block.nodes[:, corner[0]], ends[:, k]]))
                with np.errstate(divide="ignore", invalid="ignore"):
                    weights.append(volume / squares[:, k])
    return _distinct(mesh, np.sort(np.concatenate(pairs), axis=1), np.concatenate(weights))


def _volume(vectors: Array) -> Array:
    """(k,) sizes of the parallelepipeds or parallelograms of edges (k, 3 or 2, 3)."""
    cross = np.cross(vectors[:, 0], vectors[:, 1])
    if vectors.shape[1] == 2:
        return np.asarray(np.linalg.norm(cross, axis=1))
    return np.asarray(np.abs((cross * vectors[:, 2]).sum(axis=1)))


def _distinct(mesh: Mesh, pairs: Indices, weights: Array) -> CellEdges:
    count = len(mesh.points)
    real = (pairs[:, 1] < count) & (pairs[:, 0] != pairs[:, 1]) & np.isfinite(weights)
    pairs, weights = pairs[real], weights[real]
    key, place = np.unique(pairs[:, 0] * count + pairs[:, 1], return_inverse=True)
    nodes: Indices = np.column_stack([key // count, key % count]).astype(np.int64)
    lengths = np.linalg.norm(mesh.points[nodes[:, 1]] - mesh.points[nodes[:, 0]], axis=1)
    total: Array = np.asarray(np.bincount(place.reshape(-1), weights, len(key)), dtype=np.float64)
    return CellEdges(nodes, total, lengths)
