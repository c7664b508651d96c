"""Cubes of many hexahedra or tetrahedra with slightly moved nodes, and motions of their nodes."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes import Mesh

KUHN = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
CORNERS = (
    *((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
    *((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
)


def cube(kind: str, n: int) -> Mesh:
    """Unit cube of n^3 nodes in hexahedra, or in six tetrahedra each."""
    line = np.linspace(0, 1, n)
    points = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    points += 0.1 / n * np.sin(1e3 * points[:, [1, 2, 0]])
    index = np.arange(n**3).reshape(n, n, n)
    bricks = [index[a : n - 1 + a, b : n - 1 + b, c : n - 1 + c].ravel() for a, b, c in CORNERS]
    cells = np.stack(bricks, axis=1)
    if kind == "tetra":
        cells = np.concatenate([cells[:, corners] for corners in KUHN])
    return Mesh(points, {kind: cells})


def motions(points: Array) -> dict[str, Array]:
    """Displacements of a part of the nodes, of all, and one that turns cells inside out."""
    away = np.linalg.norm(points - 0.5, axis=1)

    def bump(radius: float, size: float) -> Array:
        reach = np.maximum(1 - away / radius, 0) ** 2
        return reach[:, None] * np.array([size, 2 * size, size])

    return {"local": bump(0.2, 0.01), "global": bump(5.0, 0.01), "inverting": bump(0.5, 0.6)}
