"""The inverse problem: our four methods, points outside, and splinepy beside them.

    python benchmarks/bench_embed.py [POINTS]

Three curved nets (swept twisted wing box, annulus of 300 degrees, wavy net; 8x6x4, cubic).
Repetitions are interleaved and the fastest one counts; only ratios mean anything on a
shared machine. Targets: at least 8 times faster a point inside than splinepy's
`proximities`, points outside at most 8 times dearer than points inside, none lost.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable

import numpy as np

from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.inversion import METHODS, invert
from tests.engine.nets import CURVED
from tests.engine.test_embedding import points_beside, points_inside

REPETITIONS = 7
SHARE = {"newton": 1, "secant": 1, "octree": 50, "golden": 50}  # the slow ones get fewer points


def main(count: int) -> int:
    """Print the tables; 1 if a target is missed."""
    first = _cold_start()
    print(f"first use of the kernels in this process: {first:.2f} s\n")
    good = True
    for name, make in CURVED.items():
        good &= _net(name, make(), count)
    return 0 if good else 1


def _cold_start() -> float:
    began = time.perf_counter()
    embed(CURVED["wavy"](), [[0.5, 0.5, 0.5]])
    return time.perf_counter() - began


def _net(name: str, lattice: Lattice, count: int) -> bool:
    inside, _ = points_inside(lattice, count)
    outside = points_beside(lattice, count // 10, 1e-6)
    runs: dict[str, tuple[int, Callable[[], object]]] = {}
    for method in METHODS:
        some = inside[: count // SHARE[method]]
        runs[method] = (len(some), lambda some=some, m=method: invert(lattice, some, m, 1e-12))
    runs["outside"] = (len(outside), lambda: invert(lattice, outside, "newton", 1e-12))
    other = _splinepy(lattice, inside[: count // 30])
    if other is not None:
        runs["splinepy"] = (count // 30, other)
    times = _fastest(runs)
    lost = {m: int((~runs[m][1]().inside).sum()) for m in METHODS}  # type: ignore[attr-defined]
    taken = int(runs["outside"][1]().inside.sum())  # type: ignore[attr-defined]
    print(f"{name}: {count} points inside, {len(outside)} at 1e-6 of the size outside a face")
    for key, seconds in times.items():
        note = f"lost {lost[key]}" if key in lost else ""
        note = f"taken for inside {taken}" if key == "outside" else note
        print(
            f"  {key:9} {seconds * 1e6:8.2f} us a point {seconds / times['newton']:8.2f} x  {note}"
        )
    good = taken == 0 and not any(lost.values()) and times["outside"] <= 8 * times["newton"]
    if "splinepy" in times:
        ratio = times["splinepy"] / times["newton"]
        print(f"  faster than splinepy: {ratio:.1f} times (target 8)")
        good &= ratio >= 8
    print(
        f"  outside against inside: {times['outside'] / times['newton']:.2f} (target at most 8)\n"
    )
    return good


def _fastest(runs: dict[str, tuple[int, Callable[[], object]]]) -> dict[str, float]:
    """Seconds a point of the fastest of the interleaved repetitions."""
    times = dict.fromkeys(runs, np.inf)
    for _ in range(REPETITIONS):
        for key, (count, call) in runs.items():
            began = time.perf_counter()
            call()
            times[key] = min(times[key], (time.perf_counter() - began) / count)
    return times


def _splinepy(lattice: Lattice, points: np.ndarray) -> Callable[[], object] | None:
    """The peer's way, on all cores too; None where it is not installed."""
    try:
        import splinepy
    except ImportError:
        print("splinepy is not installed: pip install splinepy to compare")
        return None
    logging.getLogger("splinepy").setLevel(logging.ERROR)  # it warns of points it does not solve
    net = np.moveaxis(lattice.control_points, 3, 0).reshape(3, -1, order="F").T
    spline = splinepy.BSpline(lattice.degrees, [list(u) for u in lattice.knots], net)
    return lambda: spline.proximities(points, [17, 13, 9], tolerance=1e-12, nthreads=2)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 300_000))
