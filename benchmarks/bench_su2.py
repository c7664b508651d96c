"""Open and save an SU2 mesh of 1 000 000 nodes, against NumPy parsing its numbers alone.

Each step is a process of its own, from its start to the fsynced file. The reference reads the
same file and parses the two blocks of numbers with NumPy's text parser.

Run: python benchmarks/bench_su2.py [--nodes N] [--repeat R]
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

NUMPY = """
import sys, numpy as np
data = open(sys.argv[1], "rb").read()
cut, end = data.index(b"NPOIN="), data.index(b"NMARK=")
np.fromstring(data[data.index(b"\\n", data.index(b"NELEM=")):cut], dtype=np.int64, sep=" ")
np.fromstring(data[data.index(b"\\n", cut):end], sep=" ")
"""
OPEN = """
import sys, resource, ffdstudio as ffd
mesh = ffd.read_mesh(sys.argv[1])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
# saving is timed inside, after an untimed opening; a bare start is added to it below
SAVE = """
import sys, time, numpy as np, ffdstudio as ffd
mesh = ffd.read_mesh(sys.argv[1])
points = mesh.points * (1 + 1e-3 * np.sin(np.arange(len(mesh.points)))[:, None])
start = time.perf_counter()
ffd.write_mesh(mesh, sys.argv[1] + ".out.su2", points)
print(time.perf_counter() - start)
"""
START = "import ffdstudio.meshes"


def generate(path: Path, nodes: int) -> None:
    """Write a wavy rectangle of triangles with full-length coordinates."""
    side = int(nodes**0.5)
    i, j = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    xy = np.stack([i + 0.3 * np.sin(j), j + 0.3 * np.cos(i)], axis=-1).reshape(-1, 2) / side
    corner = (i[:-1, :-1] * side + j[:-1, :-1]).ravel()
    lower = np.stack([corner, corner + side, corner + 1], axis=1)
    upper = np.stack([corner + 1, corner + side, corner + side + 1], axis=1)
    triangles = np.concatenate([lower, upper])
    with path.open("w") as out:
        out.write(f"NDIME= 2\nNELEM= {len(triangles)}\n")
        out.writelines(f"5 {a} {b} {c} {k}\n" for k, (a, b, c) in enumerate(triangles.tolist()))
        out.write(f"NPOIN= {len(xy)}\n")
        out.writelines(f"{x!r} {y!r} {k}\n" for k, (x, y) in enumerate(xy.tolist()))
        out.write("NMARK= 1\nMARKER_TAG= side\nMARKER_ELEMS= 1\n3 0 1\n")


def run(code: str, path: Path) -> tuple[float, str]:
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], check=True, capture_output=True, text=True
    )
    return time.perf_counter() - start, done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=1_000_000)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.su2"
        generate(path, options.nodes)
        size = path.stat().st_size
        seconds: dict[str, list[float]] = {"numpy": [], "open": [], "save": []}
        for _ in range(options.repeat):
            seconds["numpy"].append(run(NUMPY, path)[0])
            opened, memory = run(OPEN, path)
            seconds["open"].append(opened)
            seconds["save"].append(run(START, path)[0] + float(run(SAVE, path)[1]))
        best = {name: min(values) for name, values in seconds.items()}
    print(f"SU2, {options.nodes} nodes, {size / 1e6:.0f} MB, minimum of {options.repeat} runs")
    print(f"NumPy parsing the numbers alone  {best['numpy']:6.2f} s")
    print(f"open  {best['open']:6.2f} s = {best['open'] / best['numpy']:.2f} x NumPy (at most 3)")
    print(f"save  {best['save']:6.2f} s = {best['save'] / best['open']:.2f} x open (below 1)")
    print(f"peak memory of opening: {int(memory) * 1024 / size:.1f} x the file")


if __name__ == "__main__":
    main()
