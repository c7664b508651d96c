"""Outer faces of a volume mesh: ours, VTK's, a sort of all faces, and the machine's limit.

The limit is to write and read back once the keys of all faces. Time and memory at the peak are of
a process of its own each, so that none pays for another; they are taken in turn, twice.

Run it from the root of the checkout: python benchmarks/bench_faces.py [--large]
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.big_meshes import cube  # noqa: E402
from ffdstudio.aliases import Indices  # noqa: E402
from ffdstudio.meshes.topology import FACES, skin  # noqa: E402

SIZES = {False: {"tetra": 50, "hexahedron": 60}, True: {"tetra": 146, "hexahedron": 101}}
VTK_TYPES = {"tetra": 10, "hexahedron": 12}


def sorted_faces(kind: str, cells: Indices) -> int:
    """All faces sorted by their nodes, the way it is done without buckets."""
    faces = np.concatenate([cells[:, face] for face in FACES[kind]])
    key = np.sort(faces, axis=1)
    order = np.lexsort(key.T)
    same = (key[order[1:]] == key[order[:-1]]).all(axis=1)
    return len(faces) - 2 * int(same.sum())


def keys_alone(kind: str, cells: Indices) -> int:
    """Write one number for every face, and read it again."""
    keys = np.concatenate([cells[:, face[0]] + cells[:, face[1]] for face in FACES[kind]])
    return int(keys.max())


def of_vtk(kind: str, cells: Indices) -> int:
    """Let vtkDataSetSurfaceFilter do it."""
    import pyvista as pv

    head = np.full((len(cells), 1), cells.shape[1])
    types = np.full(len(cells), VTK_TYPES[kind])
    points = np.zeros((int(cells.max()) + 1, 3))
    grid = pv.UnstructuredGrid(np.hstack([head, cells]).ravel(), types, points)
    return int(grid.extract_surface(algorithm="dataset_surface").n_cells)


def ours(kind: str, cells: Indices) -> int:
    return sum(map(len, skin({kind: cells}).values()))


WAYS = {"ours": ours, "limit": keys_alone, "sort": sorted_faces, "VTK": of_vtk}


def one(way: str, kind: str, file: str) -> None:
    """Run one way, alone in this process, and print what it took."""
    WAYS[way](kind, cube(kind, 4).cells[kind])  # compiles, imports
    cells = np.load(file)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.perf_counter()
    count = WAYS[way](kind, cells)
    took = time.perf_counter() - begin
    more = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(json.dumps({"seconds": took, "bytes": 1024 * more / len(cells), "faces": count}))


def main(large: bool, folder: Path) -> None:
    for kind, n in SIZES[large].items():
        cells = cube(kind, n).cells[kind]
        print(f"{len(cells):,} {kind}")
        np.save(folder / "cells.npy", cells)
        found: dict[str, list[dict[str, float]]] = {way: [] for way in WAYS}
        for _ in range(2):
            for way in WAYS:
                command = [sys.executable, __file__, "--one", way, kind, str(folder / "cells.npy")]
                run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
                if run.returncode == 0:
                    found[way].append(json.loads(run.stdout.splitlines()[-1]))
        mine = min(row["seconds"] for row in found["ours"])
        for way, rows in found.items():
            if rows:
                best = min(row["seconds"] for row in rows)
                most = max(row["bytes"] for row in rows)
                print(
                    f"  {way:<6} {best:7.2f} s  {best / mine:6.2f} of ours  "
                    f"{most:7.0f} bytes a cell at the peak  {rows[0]['faces']:.0f}"
                )


if __name__ == "__main__":
    if "--one" in sys.argv:
        at = sys.argv.index("--one")
        one(*sys.argv[at + 1 : at + 4])
    else:
        with tempfile.TemporaryDirectory() as folder:
            main("--large" in sys.argv[1:], Path(folder))
