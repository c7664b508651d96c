"""Figures of fits for `bench_adaptive.py`: equal variables, pairs of sections, a wing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import ffdstudio as ffd
from benchmarks.cst import refit
from ffdstudio.optimize.geometry.contour import Contour, cosine_abscissae
from ffdstudio.optimize.geometry.sections import target_contour
from ffdstudio.optimize.objectives.distance import ContourDistance
from ffdstudio.optimize.runs.study import Study
from tests.optimize.cases import columns, section, task

Array = np.ndarray
ROOT = Path(__file__).parents[1]
AIRFOILS = ROOT.parent / "shared" / "airfoils"
SKIN = ROOT / "sample_meshes" / "wing_skin.vtu"
NAMES = ("e387", "nlf1015", "nlr7301", "s1223", "dae11", "naca23012", "ah93w300", "rae2822",
         "ag35", "sc20714")  # fmt: skip


def errors(target: Contour, points: Array) -> str:
    """Orthogonal and vertical errors of a dense contour."""
    upper = cosine_abscissae(len(points))[1]
    kinds = {
        "orthogonal": ContourDistance(target, upper).distances(points)[0],
        "vertical": points[:, 1] - target.at(points[:, 0], upper)[:, 1],
    }
    told = (f"{k} {np.sqrt(np.mean(e**2)):.2e} / {abs(e).max():.2e}" for k, e in kinds.items())
    return ", ".join(told)


def at_equal_variables(rae: str, count: int) -> None:
    """The best of regular, cosine and CST beside adaptive, RMS / largest error."""
    target = target_contour(rae)
    fits = {
        "equally spaced": ffd.fit("naca0012", rae, columns=count, adaptive=None, spacing="uniform"),
        "Greville columns": ffd.fit("naca0012", rae, columns=count, adaptive=None),
        "adaptive": ffd.fit("naca0012", rae, columns=count),
    }
    shapes = {name: result.task.deformed(result.lattice) for name, result in fits.items()}
    shapes["cosine columns"] = cosine(target, count)
    shapes["CST"] = refit(target, 2 * count)
    for name, points in shapes.items():
        print(f"  N = {2 * count}, {name:<17} {errors(target, points)}")


def cosine(target: Contour, count: int) -> Array:
    """Dense contour fitted with cosine-spaced columns."""
    points, lattice = section(301), columns(count, "cosine")
    job = task(ContourDistance(target, cosine_abscissae(301)[1]), lattice, points, "l2")
    reached = Study(job, "gauss-newton").run().lattice(-1)
    return ffd.embed(lattice, section(2001)).deform(reached)


def pairs() -> list[float]:
    """Regular over adaptive RMS at 35 columns x 2 for the pairs whose files are there."""
    found = [("naca0012", str(AIRFOILS / f"{name}.dat")) for name in NAMES]
    found += [("naca4412", str(AIRFOILS / "whitcomb.dat"))]
    found += [(str(AIRFOILS / "rae2822.dat"), "naca0012")]
    ratios = []
    for source, target in found:
        if all(Path(f).exists() for f in (source, target) if f.endswith(".dat")):
            fits = [ffd.fit(source, target, adaptive=a) for a in (None, "gain")]
            ratios.append(fits[0].rms / fits[1].rms)
            name = f"{Path(source).stem} to {Path(target).stem}"
            print(f"  {name:<24} {fits[0].rms:.2e} / {fits[1].rms:.2e} = {ratios[-1]:.2f}")
    return ratios


def shared(name: str, **options: Any) -> Any:
    """Fit to one of the shared sections, None if it is not there."""
    path = AIRFOILS / f"{name}.dat"
    return ffd.fit("naca0012", str(path), **options) if path.exists() else None


def recovered(count: int, size: float) -> float:
    """Distance of the target's own points after a fit in the lattice that made it."""
    from ffdstudio.optimize.geometry.contour import upper_side
    from tests.optimize.cases import bumped

    points, lattice = section(201), columns(count)
    target = bumped(lattice, points, size)
    job = task(ContourDistance(Contour.through(target), upper_side(points)), lattice, points, "l2")
    reached = Study(job, "gauss-newton").run().lattice(-1)
    found = Contour.through(ffd.embed(lattice, points).deform(reached))
    return float(np.abs(found.nearest(target, upper_side(target)).distance).max())


def wing() -> tuple[Any, Any]:
    """A wing with a bump that is local in span: adaptive, and the best regular one tried."""
    skin = ffd.read_mesh(SKIN)
    bump = np.exp(-(((skin.points[:, 1:2] - 1.9) / 0.25) ** 2))
    target = ffd.Mesh(skin.points + [0, 0, 0.05] * bump, skin.cells)
    adaptive = ffd.fit(skin, target, columns=5, start=4, rows=4, variables=72, directions="z")
    shapes = ((4, 9, 2), (5, 7, 2), (4, 10, 2), (4, 11, 2))
    regular = [
        ffd.fit(skin, target, columns=a, rows=b, layers=c, directions="z", adaptive=None)
        for a, b, c in shapes
    ]
    return adaptive, min(regular, key=lambda result: result.rms)
