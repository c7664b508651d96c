"""Boxes at rest, sheared ones as well: the inverse in closed form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.inversion.net import Net


class AffineMap(NamedTuple):
    """``y = origin + (u - start) @ edges``; coordinates along the lattice's axes."""

    origin: Array
    start: Array
    edges: Array
    identity: bool

    @classmethod
    def of(cls, net: Net) -> AffineMap | None:
        """Map of a net whose points lie, to rounding, where an affine map puts them."""
        if not net.polynomial:
            return None
        grid = np.stack(np.meshgrid(*net.abscissae, indexing="ij"), axis=-1)
        rounding = 8 * np.finfo(float).eps * max(np.abs(net.points).max(), net.diagonal)
        if np.abs(net.points - grid).max() <= rounding:
            start = np.zeros(net.dimension)
            return cls(start, start, np.eye(net.dimension), True)
        start, origin = grid[(0,) * net.dimension], net.points[(0,) * net.dimension]
        edges = np.empty((net.dimension, net.dimension))
        for k in range(net.dimension):
            far = tuple(-1 if i == k else 0 for i in range(net.dimension))
            edges[k] = (net.points[far] - origin) / (grid[far][k] - start[k])
        if np.abs(origin + (grid - start) @ edges - net.points).max() > rounding:
            return None
        lengths = np.linalg.norm(edges, axis=1)
        if not lengths.min() > 0 or abs(np.linalg.det(edges / lengths[:, None])) < 1e-9:
            return None  # flat: leave it to the general search, which refuses it
        return cls(origin, start, edges, False)

    def invert(self, y: Array, low: Array, high: Array) -> tuple[Array, Array, Array]:
        """Parameters held inside the domain, distance they were moved for that, residual."""
        u = y if self.identity else (y - self.origin) @ np.linalg.inv(self.edges) + self.start
        held = np.clip(u, low, high)
        away = np.linalg.norm((u - held) @ self.edges, axis=1)
        back = held if self.identity else self.origin + (held - self.start) @ self.edges
        return held, away, np.linalg.norm(back - y, axis=1)
