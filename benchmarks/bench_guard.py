"""The live guard on a million tetrahedra, against a copy of the moved points and cell volumes.

python benchmarks/bench_guard.py [cells along an edge, default 55]

A cubic lattice of 8x6x4 control points lies around a cube of 6 n^3 tetrahedra and one inner
control point is dragged. Repetitions of what is compared take turns; the least time counts.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import ffdstudio as ffd
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.safety import Guard

KUHN = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))


def cube(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and hexahedra of a distorted unit cube."""
    axis = np.linspace(0, 1, n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    points += 0.1 / n * np.random.default_rng(0).random(points.shape)
    i = np.arange((n + 1) ** 3).reshape((n + 1,) * 3)
    low, high = slice(None, -1), slice(1, None)
    corner = [(low, low), (high, low), (high, high), (low, high)]
    nodes = [i[a, b, c].ravel() for c in (low, high) for a, b in corner]
    return points, np.stack(nodes, axis=-1)


def least(tasks: dict[str, Callable[[], object]], times: int) -> dict[str, float]:
    """Least time of each task, taking turns."""
    best = dict.fromkeys(tasks, np.inf)
    for _ in range(times):
        for name, task in tasks.items():
            begin = time.perf_counter()
            task()
            best[name] = min(best[name], time.perf_counter() - begin)
    return best


def volumes(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Volumes of tetrahedra in plain NumPy."""
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6


def main() -> None:
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 55
    points, hexahedra = cube(n)
    cells = np.concatenate([hexahedra[:, tet] for tet in KUHN])
    mesh = Mesh(points, {"tetra": cells})
    lattice = ffd.Lattice.around(points, shape=(8, 6, 4))
    embedding = ffd.embed(lattice, points)
    drag = embedding.drag(lattice, [np.ravel_multi_index((3, 2, 1), lattice.shape)])
    moved, buffer = points[drag.rows], np.empty((len(drag.rows), 3))
    guard = Guard(mesh, points, drag.influence, drag.rows)
    directions = iter(np.random.default_rng(1).normal(size=(10_000, 3)))
    set_up = least(
        {
            "volumes": lambda: volumes(points, cells),
            "set-up": lambda: Guard(mesh, points, drag.influence, drag.rows),
        },
        3,
    )
    frame = least(
        {
            "copy": lambda: np.copyto(buffer, moved),
            "frame": lambda: guard.limit(next(directions)),
        },
        200,
    )
    print(f"{len(cells)} tetrahedra, {len(drag.rows)} of {len(points)} nodes move")
    print(f"{len(guard.region.vectors)} half-spaces kept")
    ratio = set_up["set-up"] / set_up["volumes"]
    print(f"set-up {1e3 * set_up['set-up']:.0f} ms = {ratio:.1f} x volumes (at most 10)")
    ratio = frame["frame"] / frame["copy"]
    print(f"frame {1e6 * frame['frame']:.0f} us = {ratio:.3f} x copy of moved points (at most 3)")


if __name__ == "__main__":
    main()
