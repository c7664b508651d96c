"""Cells of every type for the tests of quality and safety: ideal ones and distorted crowds."""

import numpy as np

from ffdstudio.meshes import Mesh

CUBE = np.array(
    [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
    ],
    dtype=float,
)
UNIT = {
    "triangle": CUBE[[0, 1, 3]],
    "quad": CUBE[:4],
    "tetra": CUBE[[0, 1, 3, 4]],
    "pyramid": np.vstack([CUBE[:4], [0.5, 0.5, 0.8]]),
    "wedge": CUBE[[0, 1, 3, 4, 5, 7]],
    "hexahedron": CUBE,
}
VTK_TYPE = {
    "triangle": 5,
    "quad": 9,
    "tetra": 10,
    "hexahedron": 12,
    "wedge": 13,
    "pyramid": 14,
}


def crowd(kind, count=300, distortion=0.15, seed=0, surface=False):
    """Mesh of separate, randomly distorted cells of one type."""
    rng = np.random.default_rng(seed)
    unit = UNIT[kind]
    points = unit + rng.uniform(-distortion, distortion, (count, *unit.shape))
    plane = kind in ("triangle", "quad")
    if plane and not surface:
        points[..., 2] = 0
    points += 3.0 * np.arange(count)[:, None, None] * [1, 0, 0]
    cells = np.arange(count * len(unit)).reshape(count, -1)
    dimension = 2 if plane and not surface else 3
    return Mesh(points.reshape(-1, 3), {kind: cells}, dimension=dimension)


def in_plane(mesh, vectors):
    """Vectors without the component that a plane mesh does not have."""
    return vectors * [1, 1, 0] if mesh.dimension == 2 else vectors


def block(nx, ny, nz):
    """Points and hexahedra of a unit cube divided into bricks."""
    sides = [np.linspace(0, 1, n + 1) for n in (nx, ny, nz)]
    points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    i = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    low, high = slice(None, -1), slice(1, None)
    around = [(low, low), (high, low), (high, high), (low, high)]
    nodes = [i[a, b, c].ravel() for c in (low, high) for a, b in around]
    return points, np.stack(nodes, axis=-1)
