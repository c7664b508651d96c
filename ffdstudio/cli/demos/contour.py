"""The paper's figure 5: NACA 0012 to RAE 2822, a regular lattice against one that refines itself.

Both use the paper's own method, conjugate directions over the control points, and both may
spend the same number of evaluations of the distance.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ffdstudio.cli.demos.common import Clock
from ffdstudio.cli.study_files import write_contour
from ffdstudio.exchange import write_lattice
from ffdstudio.files import write_bytes
from ffdstudio.optimize import FitResult, fit, plots
from ffdstudio.samples import sample

SOURCE = "naca0012"
REACHED = ("rms", "max_error", "kulfan_ratio", "variables", "evaluations", "iterations")


def run(folder: Path, evaluations: int = 10_000) -> dict[str, Any]:
    """Fit twice, write plots, histories, lattice and contour, return the figures."""
    clock = Clock()
    regular = clock("regular", lambda: _fit(evaluations, None))
    adaptive = clock("adaptive", lambda: _fit(evaluations, "gain"))
    files = clock("write", lambda: _write(folder, regular, adaptive))
    return {
        "regular": {name: getattr(regular, name) for name in REACHED},
        "adaptive": {name: getattr(adaptive, name) for name in REACHED},
        "adaptive_at_regular_rms": _first_at(adaptive, regular.rms),
        "seconds": clock.seconds,
        "files": files,
    }


def told(figures: dict[str, Any]) -> str:
    """One line for people."""
    regular, adaptive = figures["regular"], figures["adaptive"]
    there = figures["adaptive_at_regular_rms"]
    met = "not reached by the adaptive one"
    if there is not None:
        met = f"adaptive there with {there['variables']} after {there['evaluations']}"
    return (
        f"NACA 0012 to RAE 2822, conjugate directions: regular RMS {regular['rms']:.2e} with "
        f"{regular['variables']} variables after {regular['evaluations']} evaluations, {met}, "
        f"{adaptive['rms']:.2e} at the end with {adaptive['variables']}"
    )


def _fit(evaluations: int, indicator: str | None) -> FitResult:
    target = sample("rae2822.dat")
    return fit(
        SOURCE, target, adaptive=indicator, method="powell", metric="none", evaluations=evaluations
    )


def _first_at(result: FitResult, rms: float) -> dict[str, Any] | None:
    """What the first iterate that is as close has used."""
    found = next((row for row in result.history if row["rms"] <= rms), None)
    return found and {name: found[name] for name in ("variables", "evaluations")}


def _write(folder: Path, regular: FitResult, adaptive: FitResult) -> list[str]:
    studies = {"regular": regular.study, "adaptive": adaptive.study}
    files = plots.save(plots.convergence(studies, "rms"), folder, "figure5_convergence")
    for name, history in studies.items():
        write_bytes(folder / f"figure5_{name}.csv", plots.table(history))
        files.append(f"figure5_{name}.csv")
    write_lattice(folder / "contour.lattice.json", adaptive.rest, adaptive.lattice, units="chord")
    points = adaptive.built.monitor.deformed(adaptive.lattice)
    files += ["contour.lattice.json", write_contour(folder / "contour.dat", "adaptive", points)]
    return files + _sections(folder, adaptive)


def _sections(folder: Path, adaptive: FitResult) -> list[str]:
    """The paper's figure 4: the lattice that has adapted itself."""
    built = adaptive.built
    target = built.spec.objective.contour(built.place)
    assert target is not None
    fitted = built.monitor.deformed(adaptive.lattice)
    curves = {
        "NACA 0012": built.shape.dense,
        "RAE 2822": target.sample(len(fitted)),
        "fitted": fitted,
    }
    fig = plots.outlines(curves, adaptive.lattice.control_points, target="RAE 2822")
    return plots.save(fig, folder, "figure4_lattice")
