"""Deforming: our kernels, the ways not taken, and VTK beside them.

    python benchmarks/bench_deform.py [POINTS]

Lattice 8x6x4, cubic; random points, all inside. Repetitions are interleaved and the fastest
one counts; only ratios mean anything on a shared machine. Targets: at least 10 times faster
than `vtkBSplineTransform`, within 6 times a plain copy of the coordinates, weights at most
twice the time without, a drag at most 10 times a copy of the moved points, at most 150 bytes
a point for embedding and deforming; a pull-back at most 1.6 deformations (weighted 3.8), J dP
1.2, embedding in the box 3.3, in a curved lattice 60.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np
from scipy.interpolate import NdBSpline

from ffdstudio.engine import Embedding, Lattice, embed

REPETITIONS = 15
SHAPE, DEGREES = (8, 6, 4), (3, 3, 3)

Runs = dict[str, Callable[[], object]]


def main(count: int) -> int:
    """Print the tables; 1 if a target is missed."""
    rng = np.random.default_rng(0)
    box = Lattice.box([0, 0, 0], [1, 1, 1], SHAPE, DEGREES)
    points = rng.random((count, 3))
    runs, drag_rows = _runs(box, points, rng)
    times = _fastest(runs)
    _print(times, count)
    good = _targets(times, drag_rows)
    good &= _memory(count)
    _first_use()
    return 0 if good else 1


def _runs(box: Lattice, points: np.ndarray, rng: np.random.Generator) -> tuple[Runs, int]:
    moved = box.moved(box.control_points + 0.02 * rng.random((*SHAPE, 3)))
    weights = rng.uniform(0.5, 2, SHAPE)
    weighted = box.moved(weights=weights)
    turned = moved.moved(weights=rng.uniform(0.5, 2, SHAPE))
    one, rational = embed(box, points), embed(weighted, points)
    out, copy = np.empty_like(points), np.empty_like(points)
    drag = one.drag(moved, [SHAPE[1] * SHAPE[2] * 3 + SHAPE[2] * 3 + 1])
    some, some_copy = drag.start, np.empty_like(drag.start)
    runs: Runs = {
        "plain copy": lambda: np.copyto(copy, points),
        "deform": lambda: one.deform(moved, out),
        "deform, unchanged weights": lambda: rational.deform(
            weighted.moved(moved.control_points), out
        ),
        "deform, weights from 1": lambda: one.deform(turned, out),
        "deform, changed weights": lambda: rational.deform(turned, out),
        "deform, at rest": lambda: one.deform(box, out),
        "copy of the moved points": lambda: np.copyto(some_copy, some),
        "drag of a control point": lambda: drag.move([0.01, 0.02, 0.03], out),
        "J dP": lambda: one.jacobian_product(moved, moved.control_points),
        "J^T s": lambda: one.jacobian_pullback(moved, points),
        "J^T s, rational": lambda: one.jacobian_pullback(turned, points),
        "embed": lambda: embed(box, points),
        "vtkBSplineTransform": _vtk(box, moved, one, points),
    }
    return runs | _slow(box, moved, one, points), len(drag.rows)


def _slow(box: Lattice, moved: Lattice, embedding: Embedding, points: np.ndarray) -> Runs:
    """Ways that are timed with a tenth of the points."""
    part = points[: len(points) // 10]
    matrix = embed(box, part).jacobian(box)
    motion = (moved.control_points - box.control_points).reshape(-1, 3)
    spline = NdBSpline(box.knots, moved.control_points, DEGREES[0])
    u = embedding.parameters[: len(part)]
    curved = box.moved(box.control_points + 0.05 * np.sin(3 * box.control_points[..., ::-1]))
    places = curved.evaluate(part)
    return {
        "embed, curved /10": lambda: embed(curved, places),
        "NumPy twin /10": lambda: part + (moved.evaluate(u) - box.evaluate(u)),
        "SciPy sparse product /10": lambda: part + matrix @ motion,
        "SciPy NdBSpline /10": lambda: spline(u),
    }


def _vtk(
    box: Lattice, moved: Lattice, embedding: Embedding, points: np.ndarray
) -> Callable[[], object]:
    """The same displacements by VTK: a uniform cubic spline over a grid of coefficients."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersHybrid import vtkBSplineTransform

    motion = moved.control_points - box.control_points
    grid = vtkImageData()
    grid.SetDimensions(*SHAPE)
    # its control points stand a span outside the region they rule
    spans = np.array(SHAPE) - 3
    grid.SetSpacing(*(1 / spans))
    grid.SetOrigin(*(-1 / spans))
    flat = np.ascontiguousarray(motion.transpose(2, 1, 0, 3).reshape(-1, 3))
    grid.GetPointData().SetScalars(numpy_to_vtk(flat, deep=True))
    transform = vtkBSplineTransform()
    transform.SetCoefficientData(grid)
    transform.Update()
    given, answer = vtkPoints(), vtkPoints()
    for array in (given, answer):
        array.SetDataTypeToDouble()
    given.SetData(numpy_to_vtk(points, deep=True))

    def run() -> None:
        answer.Reset()
        transform.TransformPoints(given, answer)

    return run


def _fastest(runs: Runs) -> dict[str, float]:
    best = dict.fromkeys(runs, np.inf)
    for run in runs.values():
        run()
    for _ in range(REPETITIONS):
        for key, run in runs.items():
            began = time.perf_counter()
            run()
            best[key] = min(best[key], time.perf_counter() - began)
    return {key: seconds * (10 if key.endswith("/10") else 1) for key, seconds in best.items()}


def _print(times: dict[str, float], count: int) -> None:
    print(f"{count} points, {'x'.join(map(str, SHAPE))}, degrees {DEGREES}")
    for key, seconds in times.items():
        copies = seconds / times["plain copy"]
        print(f"  {key.removesuffix(' /10'):28s} {1e3 * seconds:9.2f} ms {copies:9.2f} copies")


def _targets(times: dict[str, float], drag_rows: int) -> bool:
    ours, weighted = times["deform"], max(t for k, t in times.items() if "weights" in k)
    drag = times["drag of a control point"] / times["copy of the moved points"]
    rows = [
        ("times faster than VTK", times["vtkBSplineTransform"] / ours, 10, False),
        ("copies of the coordinates", ours / times["plain copy"], 6, True),
        ("weights, times the unweighted time", weighted / ours, 2, True),
        ("J dP, deformations", times["J dP"] / ours, 1.2, True),
        ("J^T s, deformations", times["J^T s"] / ours, 1.6, True),
        ("J^T s rational, deformations", times["J^T s, rational"] / ours, 3.8, True),
        ("embedding in a box, deformations", times["embed"] / ours, 3.3, True),
        ("embedding curved, deformations", times["embed, curved /10"] / ours, 60, True),
        (f"drag, copies of its {drag_rows} points", drag, 10, True),
    ]
    met = [_target(*row) for row in rows]
    return all(met)


def _target(name: str, value: float, bound: float, at_most: bool) -> bool:
    met = value <= bound if at_most else value >= bound
    word = "at most" if at_most else "at least"
    print(f"  {name:38s} {value:8.2f}   target: {word} {bound} {'' if met else '  MISSED'}")
    return met


MEMORY = """
import sys
import numpy as np
from ffdstudio.engine import Lattice, embed

def peak():
    lines = open("/proc/self/status").read().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))

curved, count = sys.argv[1] == "curved", int(sys.argv[2])
box = Lattice.box([0, 0, 0], [1, 1, 1], (8, 6, 4))
net = box.control_points + 0.01 * curved * np.random.default_rng(1).random((8, 6, 4, 3))
rest, moved = box.moved(net), box.moved(net + 0.1)
embed(rest, np.full((1, 3), 0.5)).deform(moved)  # compilers and libraries in place
before = peak()
points = np.random.default_rng(0).random((count, 3))
embedding = embed(rest, points)
deformed = embedding.deform(moved)
print((peak() - before) / count)
"""


def _memory(count: int) -> bool:
    met = True
    for kind in ("box", "curved"):
        command = [sys.executable, "-c", MEMORY, kind, str(4 * count)]
        grown = float(subprocess.run(command, check=True, capture_output=True).stdout)
        met &= _target(f"bytes a point, embed and deform, {kind}", grown, 150, True)
    return met


FIRST = """
import time
import numpy as np
from ffdstudio.engine import Lattice, embed
box = Lattice.box([0, 0, 0], [1, 1, 1], (8, 6, 4))
embedding = embed(box, np.full((1, 3), 0.5))
began = time.perf_counter()
embedding.deform(box.moved(box.control_points + 1))
print(time.perf_counter() - began)
"""


def _first_use() -> None:
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        for name in ("cold", "from the disk cache"):
            command = [sys.executable, "-c", FIRST]
            done = subprocess.run(command, env=environment, check=True, capture_output=True)
            print(f"  first use of a degree triple, {name}: {float(done.stdout):.2f} s")


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000))
