"""The panel method against closed forms, and what it costs.

Run it from the root of the checkout: python benchmarks/bench_panel.py
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from ffdstudio.optimize.flow.panel import PanelFlow  # noqa: E402
from tests.optimize.cases import section  # noqa: E402
from tests.optimize.closed_forms import Transformed  # noqa: E402

NAMES = {15.0: "Karman-Trefftz, 15 degrees", 5.0: "Karman-Trefftz, 5 degrees", 0.0: "Joukowski"}


def main() -> None:
    print("| section, 5 degrees of incidence | panels | CL, error % | drag, counts | Cp, RMS |")
    print("|---|---|---|---|---|")
    for edge, name in NAMES.items():
        for panels in (80, 160, 320):
            lift, drag, pressure = errors(Transformed(edge), panels)
            print(f"| {name} | {panels} | {lift:+.4f} | {drag:+.2f} | {pressure:.1e} |")
    points = section(201)
    flow, weights = PanelFlow(points, [2.0]), np.ones((1, 200))
    value = best(lambda: PanelFlow(points, [2.0]))
    gradient, jacobian = best(lambda: flow.gradient(weights)), best(flow.pressure_jacobian)
    print(f"200 panels, CPU time: value {1e3 * value:.2f} ms, gradient {1e3 * gradient:.2f} ms, "
          f"both 4 at most; Jacobian of the pressures {jacobian / value:.1f} values")  # fmt: skip


def errors(shape: Transformed, panels: int) -> tuple[float, float, float]:
    """Lift in percent, drag in counts and RMS of the pressures at the middles."""
    flow = PanelFlow(shape.nodes(panels + 1), [shape.angle])
    theta = shape.theta(panels + 1)
    exact = 1 - shape.speed(0.5 * (theta[1:] + theta[:-1])) ** 2
    gap = np.sqrt(np.mean((flow.pressure[0] - exact) ** 2))
    return 100 * (flow.lift()[0] / shape.lift - 1), 1e4 * flow.drag()[0], float(gap)


def best(work: Callable[[], object]) -> float:
    """Least CPU time of 20 calls."""
    times = []
    for _ in range(20):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times)


if __name__ == "__main__":
    main()
