"""Print each figure of the adaptive fits and optimizations beside its target.

Run it from the root of the checkout: python benchmarks/bench_adaptive.py
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

import ffdstudio as ffd  # noqa: E402
from benchmarks import fit_figures  # noqa: E402
from ffdstudio.optimize.build.build import read_case  # noqa: E402
from ffdstudio.optimize.geometry.sections import target_contour  # noqa: E402
from ffdstudio.optimize.methods.descent import Lbfgs  # noqa: E402
from ffdstudio.optimize.objectives.flow import FlowTarget  # noqa: E402
from ffdstudio.optimize.runs.record import RunHistory  # noqa: E402
from ffdstudio.optimize.runs.study import Budget, Refinement, Study  # noqa: E402
from tests.optimize.cases import columns, section, task  # noqa: E402

RAE = str(ROOT / "sample_meshes" / "rae2822.dat")
POINTS = section(161)


def main() -> None:
    paper()
    contour()
    comparisons()
    shapes()
    evaluations()
    pressures()
    reachable()
    adjoint()
    constrained()
    timing()


def show(what: str, found: float, target: float, more: bool = False) -> None:
    met = found >= target if more else found <= target
    sign, verdict = ">=" if more else "<=", "" if met else "MISSED"
    print(f"{what:<66} {found:10.3g}  {sign} {target:<8.3g} {verdict}")


def paper() -> None:
    """The paper's own way: conjugate directions over control points.

    The rival has Greville columns, the spacing of adaptive fits; the paper's equally spaced
    lattice is printed beside it.
    """
    same: dict[str, Any] = {"adaptive": None, "method": "powell", "metric": "none"}
    equal = ffd.fit("naca0012", RAE, spacing="uniform", evaluations=10_000, **same)
    regular = ffd.fit("naca0012", RAE, evaluations=10_000, **same)
    print(f"conjugate directions, equally spaced: RMS {equal.rms:.2e}")
    adaptive = ffd.fit("naca0012", RAE, method="powell", metric="none", evaluations=10_000)
    met = next((h for h in adaptive.history if h["rms"] <= regular.rms), None)
    print(
        f"conjugate directions, regular: RMS {regular.rms:.2e}, {regular.evaluations} evaluations"
    )
    if met is None:
        print("  adaptive does not reach it: MISSED")
        return
    show(
        "  adaptive, variables at the regular run's final RMS", met["variables"], regular.variables
    )
    show("  adaptive, evaluations at it", met["evaluations"], regular.evaluations)


def contour() -> None:
    result = ffd.fit("naca0012", RAE)
    show("35 columns x 2, RMS", result.rms, 5e-7)
    show("35 columns x 2, largest error", result.max_error, 2.5e-6)
    result = ffd.fit("naca0012", RAE, columns=12)
    show("24 variables, RMS", result.rms, 1e-5)
    show("24 variables, of Kulfan's tolerance", result.kulfan_ratio or 0, 0.1)
    show("12 variables, of Kulfan's tolerance", ratio(columns=6), 1)
    show("10 variables, minimax, of Kulfan's tolerance", ratio(columns=5, norm="max"), 1)
    rows = ffd.fit("naca0012", RAE, columns=14, rows=3, row_wise=True)
    show(f"row-wise, {rows.variables} variables in 3 rows, RMS", rows.rms, 1e-6)


def ratio(**options: Any) -> float:
    return ffd.fit("naca0012", RAE, **options).kulfan_ratio or 0.0


def comparisons() -> None:
    print("RMS / largest error at equal numbers of variables")
    for count in (12, 20, 35):
        fit_figures.at_equal_variables(RAE, count)


def shapes() -> None:
    ratios = fit_figures.pairs()
    if len(ratios) == 12:
        show("pairs, adaptive at least 3 times better", sum(r >= 3 for r in ratios), 8, more=True)
        show("pairs, the least ratio", min(ratios), 1, more=True)
    s1223 = fit_figures.shared("s1223", rows=3, relocate=False)
    if s1223 is not None:
        show(f"S1223, 3 rows, {s1223.variables} variables, largest error", s1223.max_error, 4e-4)
    dae = fit_figures.shared("dae11", rows=3, start=4, columns=12, variables=16, row_wise=True)
    if dae is not None:
        show("DAE-11, 16 variables row-wise, of Kulfan's tolerance", dae.kulfan_ratio, 1)
    for count, size in ((9, 0.02), (20, 0.02), (20, 0.05)):
        found = fit_figures.recovered(count, size)
        show(f"known lattice, {count} columns, amplitude {size}, recovered to", found, 1e-12)
    adaptive, regular = fit_figures.wing()
    print(f"wing: adaptive {adaptive.variables} variables RMS {adaptive.rms:.2e}, best regular "
          f"{regular.variables} variables {regular.rms:.2e}")  # fmt: skip
    show("  RMS, adaptive over the best regular with as many", adaptive.rms / regular.rms, 1)


def evaluations() -> None:
    def until(limit: float, **options: Any) -> float:
        history = ffd.fit("naca0012", RAE, **options).history
        return next((h["evaluations"] for h in history if h["rms"] <= limit), float("inf"))

    show("L-BFGS, 35 x 2, evaluations to 1e-6", until(1e-6, adaptive=None, method="lbfgs"), 20)
    show("conjugate directions, adaptive, evaluations to 1e-5", until(1e-5, method="powell"), 1000)
    show("conjugate directions, adaptive, evaluations to 1e-6", until(1e-6, method="powell"), 2500)


def pressures() -> None:
    flow = FlowTarget.like(target_contour(RAE).sample(161), [2.0])
    start = flow.evaluate(POINTS, False).value
    static = {k: Study(task(flow, columns(20, k), POINTS)).run() for k in ("greville", "cosine")}
    settings = Refinement(variables=40, slope=0.8)
    adaptive = Study(task(flow, columns(5), POINTS), "lbfgs", settings).run()
    for name, history in {**static, "adaptive": adaptive}.items():
        print(f"pressures, N = 40, {name}: J/J0 {history.iterates[-1].cost / start:.2e}")
    best = min(h.iterates[-1].cost for h in static.values())
    show("  adaptive below the better by a factor", best / adaptive.iterates[-1].cost, 5, more=True)
    for fraction in (1e-3, 1e-4):
        spent = [solves(h, fraction * start) for h in (static["greville"], adaptive)]
        show(f"  solves to J/J0 = {fraction:g}, adaptive over regular", spent[1] / spent[0], 1.3)
    forgetful = Lbfgs(carry_memory=False)
    plain = Study(
        task(flow, columns(5), POINTS), forgetful, settings, Budget(evaluations=300)
    ).run()
    forgotten = solves(plain, 1e-4 * start) / solves(static["greville"], 1e-4 * start)
    print(f"  the same with the memory dropped at refinements: {forgotten:.2f}")


def reachable() -> None:
    for count in (6, 12, 20):
        fitted = ffd.fit("naca0012", RAE, columns=count, adaptive=None)
        target = FlowTarget.like(ffd.embed(fitted.rest, POINTS).deform(fitted.lattice), [2.0])
        goal = 1e-6 * target.evaluate(POINTS, False).value
        record = Study(task(target, fitted.rest, POINTS)).run().first_below(goal)
        found = float("inf") if record is None else record.evaluation
        show(f"reachable pressures, N = {2 * count}, evaluations to 1e-6", found, 20)


def adjoint() -> None:
    """Against central differences of fourth order along a random direction."""
    flow = FlowTarget([1.0, 3.0], lift=[0.4, 0.7], moment=[-0.05, -0.06])
    along = np.zeros_like(POINTS)
    along[:, 1] = np.random.default_rng(0).standard_normal(len(POINTS)) * np.abs(POINTS[:, 1])

    def value(t: float) -> float:
        return flow.evaluate(POINTS + t * along, False).value

    h = 1e-4
    slope = (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h)
    gradient = flow.evaluate(POINTS).gradient
    assert gradient is not None
    show("adjoint, relative error", abs(float((gradient * along).sum()) / slope - 1), 1e-6)


def constrained() -> None:
    study = read_case(ROOT / "resources" / "cases" / "lift.toml").study
    history = study.run()
    last = history.iterates[-1].measures
    violation = max(v for k, v in last.items() if k.startswith("violation"))
    print(f"lift and thickness, slsqp, adaptive: {history.records[-1].note}")
    show("  largest violation", violation, 1e-8)


def solves(history: RunHistory, cost: float) -> float:
    record = history.first_below(cost)
    return float("inf") if record is None else record.flow + record.adjoint


def timing() -> None:
    def once(work: Callable[[], object]) -> float:
        begin = time.perf_counter()
        work()
        return time.perf_counter() - begin

    runs = [
        (
            once(lambda: ffd.fit("naca0012", RAE)),
            once(lambda: ffd.fit("naca0012", RAE, adaptive=None)),
        )
        for _ in range(3)
    ]
    run, single = (min(times) for times in zip(*runs, strict=True))
    print(f"adaptive run to 35 columns {run:.2f} s, single fit {single:.3f} s")
    show("  seconds (or 5 times the single fit)", run, max(2.0, 5 * single))


if __name__ == "__main__":
    main()
