"""Adaptive lattices against static ones: the frozen protocol, and one pair over settings.

python benchmarks/compare_sections.py TARGETS [--exclude DIR] [-o DIR] [--count N] [--minutes M]

TARGETS is a folder of airfoil files that settings were not tuned on, such as the UIUC collection
in the wheel of aerosandbox (PyPI): unzip it, aerosandbox/geometry/airfoil/airfoil_database.
What is there in the folder of results is not computed again.
"""

from __future__ import annotations

import argparse
import csv
import sys
from itertools import product
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from ffdstudio.optimize.compare import report  # noqa: E402
from ffdstudio.optimize.compare.protocol import Case, Protocol  # noqa: E402
from ffdstudio.optimize.compare.session import compare, sections_in  # noqa: E402
from ffdstudio.optimize.compare.trial import result_of  # noqa: E402

RAE = ROOT / "sample_meshes" / "rae2822.dat"
PANELS, ANGLES = (161, 201, 281, 401), (-2.0, 0.0, 2.0, 4.0, 6.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("targets", type=Path)
    parser.add_argument("--exclude", type=Path, action="append", default=[])
    parser.add_argument("-o", "--output", type=Path, default=Path("compare"))
    parser.add_argument("--count", type=int, default=Protocol.count)
    parser.add_argument("--minutes", type=float)
    parser.add_argument("--processes", type=int, default=1)
    args = parser.parse_args()
    protocol = Protocol(count=args.count)
    files = sections_in(args.targets, args.exclude)
    seconds = None if args.minutes is None else 60 * args.minutes
    results = compare(files, protocol, args.output, args.processes, seconds)
    report.write(results, protocol, args.output)
    told = report.summary(results, protocol)
    print(report.text(told, protocol))
    judge(told)
    pair(args.output)


def judge(told: dict[str, Any]) -> None:
    """The distribution beside its targets."""
    large, small = told["N = 40"], told["N = 24"]
    below = len(large["below 1"]) / max(told["targets"], 1)
    show("targets", told["targets"], 100, more=True)
    show("N = 40, median factor", large["factor"]["median"], 8, more=True)
    show("N = 40, first decile", large["factor"]["first decile"], 2, more=True)
    show("N = 40, share below 1", below, 0.01)
    show("N = 40, below 0.5", len(large["below 0.5"]), 0)
    show("N = 24, median factor", small["factor"]["median"], 3, more=True)
    show("N = 24, first decile", small["factor"]["first decile"], 1, more=True)
    for level in ("0.001", "0.0001"):
        show(f"N = 40, solves to {level}, median", large[f"solves to {level}"]["median"], 1)


def pair(folder: Path) -> None:
    """RAE 2822 over panels and angles: the factor over the best rival of each."""
    protocol, least = Protocol(variables=(40,)), []
    for panels, angle in product(PANELS, ANGLES):
        result = result_of(Case(RAE, panels, angle), protocol)
        factor = report.factors([result], protocol, 40)[RAE.name]
        print(f"RAE 2822, {panels} panels, {angle:g} degrees: {factor:.2f}", flush=True)
        least.append((panels, angle, round(factor, 3)))
    show("RAE 2822, the least factor", min(f for _, _, f in least), 5, more=True)
    with (folder / "rae2822.csv").open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows([("panels", "angle", "factor"), *least])


def show(what: str, found: float, target: float, more: bool = False) -> None:
    met = found >= target if more else found <= target
    sign, verdict = ">=" if more else "<=", "" if met else "MISSED"
    print(f"{what:<44} {found:10.3g}  {sign} {target:<8.3g} {verdict}")


if __name__ == "__main__":
    main()
