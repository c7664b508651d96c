"""What a comparison has found: a table of all runs, the distribution, and plots."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.files import write_bytes
from ffdstudio.optimize import plots
from ffdstudio.optimize.compare.protocol import ADAPTIVE, Protocol
from ffdstudio.optimize.compare.rivals import TITLES

Result = dict[str, Any]
QUANTILES = {"least": 0.0, "first decile": 0.1, "first quartile": 0.25, "median": 0.5,
             "third quartile": 0.75, "ninth decile": 0.9}  # fmt: skip
NEVER = float("inf")


def solves_to(run: dict[str, Any], cost: float) -> float:
    """Solves until the cost is at or below a limit; infinite if it never is.

    Examples
    --------
    >>> solves_to({"path": [(5, 1.0), (9, 0.1)]}, 0.5)
    9
    """
    return next((solves for solves, value in run.get("path", []) if value <= cost), NEVER)


def rows(results: Iterable[Result], protocol: Protocol) -> list[dict[str, Any]]:
    """One row for each run: what it reached, and when it met the levels."""
    found = []
    for result in results:
        for key, run in result.get("runs", {}).items():
            name, _, count = key.rpartition("-")
            row = {"target": result["target"], "panels": result["panels"],
                   "angle": result["angle"], "method": name, "N": int(count)}  # fmt: skip
            start, path = result["start"], run.get("path")
            row |= {"J/J0": path[-1][1] / start if path else "", "solves": path and path[-1][0]}
            for level in protocol.levels:
                row[f"solves to {level:g}"] = solves_to(run, level * start)
            row |= {"variables": run.get("variables", ""), "seconds": run.get("seconds", "")}
            found.append(row | {"ended": run.get("ended", run.get("error", ""))})
    return found


def factors(results: Iterable[Result], protocol: Protocol, count: int) -> dict[str, float]:
    """J of the best rival over that of the adaptive lattice, by target; 0 where that failed."""
    found = {}
    for result in results:
        if "runs" in result:
            least = {n: _reached(result, n, count) for n in (*protocol.rivals, ADAPTIVE)}
            best, ours = min(least[n] for n in protocol.rivals), least[ADAPTIVE]
            found[result["target"]] = best / ours if np.isfinite(best) and ours > 0 else 0.0
    return found


def _reached(result: Result, name: str, count: int) -> float:
    path = result["runs"][f"{name}-{count}"].get("path")
    return float(path[-1][1]) if path else NEVER


def ratios(results: Iterable[Result], protocol: Protocol, count: int, level: float) -> Array:
    """Solves of the adaptive lattice over those of the first rival, to a fraction of the start.

    Where nobody gets there it is left out; where one of them does not it is infinite or zero.
    """
    found = []
    for result in results:
        if "runs" not in result:
            continue
        limit = level * result["start"]
        runs = result["runs"]
        first = min(solves_to(runs[f"{n}-{count}"], limit) for n in protocol.rivals)
        ours = solves_to(runs[f"{ADAPTIVE}-{count}"], limit)
        if np.isfinite(min(first, ours)):
            found.append(ours / first if np.isfinite(first) else 0.0)
    return np.array(found)


def summary(results: Sequence[Result], protocol: Protocol) -> dict[str, Any]:
    """The distribution, and every failure by name."""
    told: dict[str, Any] = {
        "targets": sum("runs" in result for result in results),
        "refused": {r["target"]: r["refused"] for r in results if "refused" in r},
    }
    for count in protocol.variables:
        each = factors(results, protocol, count)
        values = np.array(list(each.values()))
        if not values.size:
            continue
        part: dict[str, Any] = {
            "factor": {n: float(np.quantile(values, q)) for n, q in QUANTILES.items()},
            "below 1": {n: round(f, 3) for n, f in sorted(each.items()) if f < 1},
            "below 0.5": sorted(n for n, f in each.items() if f < 0.5),
            "best rival": _winners(results, protocol, count),
        }
        for level in protocol.levels:
            found = ratios(results, protocol, count, level)
            if found.size:
                quantiles = np.quantile(found, [0.25, 0.5, 0.75], method="closest_observation")
                names = ("first quartile", "median", "third quartile")
                part[f"solves to {level:g}"] = {
                    "targets": len(found), **dict(zip(names, quantiles.tolist(), strict=True))
                }  # fmt: skip
        told[f"N = {count}"] = part
    return told


def _winners(results: Sequence[Result], protocol: Protocol, count: int) -> dict[str, int]:
    best = [
        min(protocol.rivals, key=lambda name: _reached(result, name, count))
        for result in results
        if "runs" in result
    ]
    return {TITLES[name]: best.count(name) for name in protocol.rivals if name in best}


def text(told: dict[str, Any], protocol: Protocol) -> str:
    """The distribution as a table for people, in Markdown."""
    lines = [
        f"{told['targets']} targets, panels {protocol.panels[0]} to {protocol.panels[1]}, angles "
        f"{protocol.angles[0]:g} to {protocol.angles[1]:g} degrees, seed {protocol.seed}, "
        f"{protocol.evaluations} evaluations for everybody, metric {protocol.metric}.", "",
        "| J of the best static over adaptive | " + " | ".join(QUANTILES) + " | below 1 |",
        "|---|" + "---|" * (len(QUANTILES) + 1),
    ]  # fmt: skip
    parts = {name: part for name, part in told.items() if name.startswith("N = ")}
    for name, part in parts.items():
        cells = [f"{value:.3g}" for value in part["factor"].values()]
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {len(part['below 1'])} |")
    lines += ["", "| solves, adaptive over the first static | first quartile | median | third "
              "quartile | targets |", "|---|---|---|---|---|"]  # fmt: skip
    for name, part in parts.items():
        for level in protocol.levels:
            if found := part.get(f"solves to {level:g}"):
                cells = [f"{found[k]:.3g}" for k in ("first quartile", "median", "third quartile")]
                lines.append(f"| {name}, to {level:g} | {' | '.join(cells)} | {found['targets']} |")
    lines.append("")
    for name, part in parts.items():
        below = ", ".join(f"{n} {f:g}" for n, f in part["below 1"].items()) or "none"
        lines.append(f"Below 1 at {name}: {below}.")
    lines += [f"Refused: {name}: {why}" for name, why in told["refused"].items()]
    return "\n".join(lines) + "\n"


def write(results: Sequence[Result], protocol: Protocol, folder: Path) -> list[str]:
    """Write table, distribution and plots; returns the names of the files."""
    told, table = summary(results, protocol), rows(results, protocol)
    write_bytes(folder / "summary.json", json.dumps(told, indent=1).encode())
    write_bytes(folder / "summary.md", text(told, protocol).encode())
    out = io.StringIO()
    if table:
        writer = csv.DictWriter(out, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(_short(row) for row in table)
    write_bytes(folder / "runs.csv", out.getvalue().encode())
    names = ["summary.json", "summary.md", "runs.csv"]
    if told["targets"]:
        names += plots.save(_distribution(results, protocol), folder, "factors")
        names += plots.save(_curves(results, protocol), folder, "curves")
    return names


def _short(row: dict[str, Any]) -> dict[str, Any]:
    return {k: f"{v:.4g}" if isinstance(v, float) and k != "angle" else v for k, v in row.items()}


def _distribution(results: Sequence[Result], protocol: Protocol) -> Any:
    fig, axes = plots.figure()
    for count in protocol.variables:
        values = np.sort(list(factors(results, protocol, count).values()))
        share = (np.arange(len(values)) + 1) / len(values)
        axes.step(np.maximum(values, 1e-3), 100 * share, where="post", label=f"{count} variables")
    axes.axvline(1.0, color="0.5", linewidth=1)
    axes.set(xscale="log", xlabel="J of the best static lattice over adaptive",
             ylabel="targets at or below, %", ylim=(0, 100))  # fmt: skip
    axes.legend()
    return fig


def _curves(results: Sequence[Result], protocol: Protocol) -> Any:
    """Median of J/J0 against solves, of each method at the largest number of variables."""
    fig, axes = plots.figure()
    count = max(protocol.variables)
    solves = np.arange(1.0, 201.0)
    for name in (*protocol.rivals, ADAPTIVE):
        curves = [
            _curve(result["runs"][f"{name}-{count}"], result["start"], solves)
            for result in results
            if result.get("runs", {}).get(f"{name}-{count}", {}).get("path")
        ]
        if curves:
            style = {"linewidth": 2.5, "color": "black"} if name == ADAPTIVE else {}
            label = TITLES.get(name, name)
            axes.plot(solves, np.median(curves, axis=0), label=label, **style)
    axes.set(yscale="log", xlabel="solves, those of the metric included",
             ylabel=f"median of J/J0, {count} variables")  # fmt: skip
    axes.legend()
    return fig


def _curve(run: dict[str, Any], start: float, solves: Array) -> Array:
    steps, costs = np.array(run["path"], dtype=np.float64).T
    index = np.searchsorted(steps, solves, side="right") - 1
    return np.where(index < 0, 1.0, costs[np.maximum(index, 0)] / start)
