"""Studies with a mesh that follows against the same ones without: cells, costs, layers.

Sections are drawn by a seed from a folder of airfoil files. For each and each kind of study:
inverted cells at any iterate (counted afterwards), the cost over that without a mesh, the least
height of a first-layer cell over its height at rest, and by how much non-orthogonality grew
(99.9th percentile, degrees).

usage: bench_followed_studies.py [FOLDER OF .dat FILES] [--count N] [--seed S] [--only KIND]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from ffdstudio.meshes import inverted, quality
from ffdstudio.optimize.build.build import build, following_meshes
from ffdstudio.optimize.spec.codec import from_values
from ffdstudio.samples import sample

ROOMY = {"lower": [-0.3, -0.36], "upper": [1.3, 0.36], "frozen": 1}
GROW = {"variables": 40}
KINDS = {
    "contour, 2 rows, tight": ({"shape": [5, 2]}, "contour", "gauss-newton", GROW),
    "contour, 3 rows, tight": ({"shape": [5, 3]}, "contour", "gauss-newton", GROW),
    "contour, 5 rows, roomy": ({"shape": [11, 5], **ROOMY}, "contour", "gauss-newton", GROW),
    "contour, 5 rows, L-BFGS": ({"shape": [11, 5], **ROOMY}, "contour", "lbfgs", GROW),
    "contour, 31x5 fixed": ({"shape": [31, 5], **ROOMY}, "contour", "gauss-newton", None),
    "pressure, 2 rows, tight": ({"shape": [5, 2]}, "flow", "lbfgs", {**GROW, "slope": 0.8}),
    "pressure, 5 rows, roomy": ({"shape": [11, 5], **ROOMY}, "flow", "lbfgs", GROW),
    "lift and thickness, 5 rows": ({"shape": [9, 5], **ROOMY}, "lift", "slsqp", None),
    "lift and thickness, 2 rows": ({"shape": [5, 2]}, "lift", "slsqp", {"variables": 20}),
    "wing surface, 6x5x5": ({}, "wing", "gauss-newton", None),
}


def values(kind: str, target: Path, mesh: bool) -> dict:
    """Tables of a case."""
    lattice, goal, method, refinement = KINDS[kind]
    if goal == "wing":
        box = {"shape": [6, 5, 5], "lower": [-1.0, -1.5, -1.0], "upper": [2.5, 4.5, 1.0]}
        return {
            "shape": {"source": str(sample("wing_air.su2")), "marker": "WING"},
            "lattice": box,
            "variables": {"directions": ["z"], "frozen": 1},
            "objective": {
                "kind": "surface", "target": str(sample("wing_skin.vtu")),
                "deformed": {
                    "shape": [4, 3, 2], "degrees": [3, 2, 1],
                    "moves": [[1, 2, 1, 0.0, 0.0, 0.05]],
                },
            },
            "method": {"name": method, "metric": "l2"},
        }  # fmt: skip
    found: dict = {
        "shape": {"source": "naca0012"},
        "lattice": {k: v for k, v in lattice.items() if k != "frozen"},
        "variables": {"frozen": lattice.get("frozen", 0)},
        "objective": {"kind": "contour" if goal == "contour" else "flow", "target": str(target)},
        "method": {"name": method, **({"metric": "l2"} if method == "gauss-newton" else {})},
        "budget": {"evaluations": 300},
    }
    if mesh:
        found["shape"]["mesh"] = str(sample("naca0012.su2"))
    if goal != "contour":
        found["objective"]["angles"] = [2.0]
    if goal == "lift":
        found["constraints"] = [
            {"kind": "lift", "angle": 2.0, "equal": 0.5},
            {"kind": "max-thickness", "lower": 0.125},
        ]
    if refinement:
        found["refinement"] = refinement
    return found


def ran(kind: str, target: Path, mesh: bool):
    """A study, run."""
    case = build(from_values(values(kind, target, mesh)))
    if mesh:
        case.keeping(following_meshes(case))
    begin = time.perf_counter()
    history = case.study.run()
    return case, history, time.perf_counter() - begin


def figures(kind: str, target: Path) -> dict[str, float]:
    """What one study does to its mesh."""
    case, history, seconds = ran(kind, target, True)
    _, plain, before = ran(kind, target, False)
    body = case.task.followers[0]
    counts = [
        inverted(body.mesh, body.at(history.lattice(k))).count for k in range(len(history.iterates))
    ]
    report = quality(body.mesh, body.at(history.lattice(-1)))
    layer = report.measures["first_layer_ratio"]
    rest = quality(body.mesh).measures
    skewed = [np.nanpercentile(m["non_orthogonality"], 99.9) for m in (report.measures, rest)]
    return {
        "iterates": len(counts), "inverted": max(counts), "cost": history.iterates[-1].cost,
        "ratio": history.iterates[-1].cost / max(plain.iterates[-1].cost, 1e-30),
        "layer": float(np.nanmin(layer)), "layer_most": float(np.nanmax(layer)),
        "degrees": float(skewed[0] - skewed[1]),
        "walls": float(body.walls is not None), "seconds": seconds, "plain": before,
        "decrease": history.iterates[-1].cost / history.iterates[0].cost,
        "plain_decrease": plain.iterates[-1].cost / plain.iterates[0].cost,
    }  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--count", type=int, default=6)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    files = sorted(Path(args.folder).glob("*.dat")) if args.folder else [sample("rae2822.dat")]
    drawn = np.random.default_rng(args.seed).permutation(len(files))[: args.count]
    print("kind; section: iterates, inverted, J, J/J0, plain J/J0, J ratio, layers, degrees, s")
    for kind in KINDS:
        if args.only and args.only not in kind:
            continue
        chosen = [files[k] for k in drawn] if KINDS[kind][1] != "wing" else files[:1]
        for file in chosen:
            try:
                f = figures(kind, file)
            except Exception as error:
                print(f"{kind}; {file.stem}: {type(error).__name__}: {error}", flush=True)
                continue
            print(
                f"{kind}{' [walls]' if f['walls'] else ''}; {file.stem}: {f['iterates']}, "
                f"{f['inverted']}, {f['cost']:.3e}, {f['decrease']:.1e}, "
                f"{f['plain_decrease']:.1e}, "
                f"{f['ratio']:.3f}, {f['layer']:.3f}-{f['layer_most']:.3f}, {f['degrees']:+.1f}, "
                f"{f['seconds']:.1f} ({f['plain']:.1f})", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    main()
