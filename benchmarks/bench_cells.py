"""Inverted cells and safe amplitude: ours, the machine's limit, and NumPy on a share of the cells.

The limit is one pass of a kernel that reads the nodes of all cells and sums them. The peer is the
plain NumPy evaluation of corner Jacobians and their roots; it is timed on at most a million cells
and scaled. All are taken in turn, three times, in one run; the least time counts.

Run it from the root of the checkout: python benchmarks/bench_cells.py [--large]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np

from benchmarks.big_meshes import cube, motions
from ffdstudio import threads
from ffdstudio.aliases import AnyArray, Array
from ffdstudio.compiling import compiled
from ffdstudio.meshes import Mesh, inverted, safe_amplitude
from ffdstudio.meshes.measures import sweep
from ffdstudio.meshes.measures.blocks import blocks_of

SIZES = {False: {"tetra": 60, "hexahedron": 80}, True: {"tetra": 146, "hexahedron": 216}}
SHARE = 1_000_000


@compiled
def gathered(begin: int, end: int, nodes: AnyArray, points: AnyArray, out: AnyArray) -> None:
    """Sum the coordinates of the nodes of cells, which is the least that any check has to read."""
    total = 0.0
    for row in range(begin, end):
        for j in range(nodes.shape[1]):
            for k in range(3):
                total += points[nodes[row, j], k]
    out[0] = total


def limit(mesh: Mesh, kind: str) -> None:
    """Read rest and deformed coordinates of all cells once, on all cores."""
    nodes, out = mesh.cells[kind], np.zeros(1)
    for _ in range(2):
        threads.for_each(
            lambda a: gathered(a, min(a + 32768, len(nodes)), nodes, mesh.points, out),
            range(0, len(nodes), 32768),
        )


def ours(mesh: Mesh, step: Array) -> tuple[int, float]:
    return inverted(mesh, mesh.points + step).count, safe_amplitude(mesh, step)


def numpy_alone(mesh: Mesh, step: Array) -> tuple[int, float]:
    kept, sweep.SMALL = sweep.SMALL, 10**12
    try:
        return ours(mesh, step)
    finally:
        sweep.SMALL = kept


def clock(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def main(large: bool) -> None:
    for kind, n in SIZES[large].items():
        mesh = cube(kind, n)
        cells = mesh.cells[kind]
        part = Mesh(mesh.points, {kind: cells[:: max(len(cells) // SHARE, 1)]})
        scale = len(cells) / len(part.cells[kind])
        for each in (mesh, part):
            blocks_of(each)
        print(f"{len(cells):,} {kind}, {len(mesh.points):,} nodes, {threads.count()} cores")
        for name, step in motions(mesh.points).items():
            print(f"  {name:<10} {figures(mesh, part, kind, step, scale)}")


def figures(mesh: Mesh, part: Mesh, kind: str, step: Array, scale: float) -> str:
    """Times of the three ways, taken in turn, as a line."""
    runs: dict[str, Callable[[], object]] = {
        "ours": lambda: ours(mesh, step),
        "limit": lambda: limit(mesh, kind),
        "numpy": lambda: numpy_alone(part, step),
    }
    found = ours(mesh, step)  # the first time compiles
    limit(mesh, kind)
    best = dict.fromkeys(runs, np.inf)
    for _ in range(3):
        for title, work in runs.items():
            best[title] = min(best[title], clock(work))
    return (
        f"{best['ours']:7.2f} s   {best['ours'] / best['limit']:5.1f} limits   "
        f"NumPy {scale * best['numpy'] / best['ours']:6.1f} times as long   "
        f"{found[0]} inverted, safe {found[1]:.6g}"
    )


if __name__ == "__main__":
    main("--large" in sys.argv[1:])
