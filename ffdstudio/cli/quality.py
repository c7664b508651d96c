"""``ffdstudio quality``: a table of the measures of a mesh, also against the undeformed one."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from ffdstudio.cli.output import emit
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, read_mesh

if TYPE_CHECKING:
    from ffdstudio.meshes.measures import Report

_HEAD = ("measure", "min", "1 %", "median", "mean", "99 %", "max", "worst cell", "at")


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", metavar="FILE", help="mesh")
    parser.add_argument("--against", metavar="FILE", help="the undeformed mesh, for the ratios")
    parser.add_argument(
        "--worst", type=int, default=5, metavar="N", help="worst cells listed in JSON (default 5)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Measure; 1 if cells are inverted against the undeformed mesh."""
    from ffdstudio.meshes.measures import quality
    from ffdstudio.meshes.measures.topology_checks import connections

    if args.worst < 0:
        raise InputError(f"--worst {args.worst}: a number of cells is at least 0")
    mesh = read_mesh(args.file)
    if args.against is None:
        report = quality(mesh)
    else:
        rest = read_mesh(args.against)
        check_same(rest, mesh, args.against, args.file)
        report = quality(rest, mesh.points)
    result = report.to_dict(args.worst)
    result["topology"] = connections(mesh).to_dict()
    if args.against is None:
        for name in ("volume_ratio", "first_layer_ratio"):
            result["measures"].pop(name, None)
    text = table(report, result, args.against is not None, str(connections(mesh)))
    emit(result, text, args.json)
    return 1 if result["inverted"] else 0


def check_same(rest: Mesh, mesh: Mesh, rest_name: str, name: str) -> None:
    """Refuse to compare meshes whose cells differ."""
    same = (
        len(rest.points) == len(mesh.points)
        and rest.cells.keys() == mesh.cells.keys()
        and all(np.array_equal(rest.cells[kind], mesh.cells[kind]) for kind in rest.cells)
        and (rest.faces is None) == (mesh.faces is None)
    )
    if same and rest.faces is not None and mesh.faces is not None:
        same = all(
            np.array_equal(getattr(rest.faces, part), getattr(mesh.faces, part))
            for part in ("nodes", "offsets", "owner", "neighbour")
        )
    if not same:
        raise InputError(f"{name} and {rest_name} are not the same mesh: nodes or cells differ")


def table(report: Report, result: dict[str, Any], compared: bool, topology: str) -> str:
    """Lay the report out for people."""
    rows = [_HEAD, *(_row(name, entry) for name, entry in result["measures"].items())]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEAD))]
    inverted = f"{result['inverted']} inverted, " if compared else ""
    counts = f"{inverted}{result['negative']} with a negative corner"
    if result["negative"] and not compared:
        counts += " (whether they were turned inside out, the undeformed mesh tells: --against)"
    counts += f"; {report.coverage}" if report.coverage.missing else ""
    lines = [f"{report.cells} cells, {counts}", f"topology as checkMesh has it: {topology}", ""]
    lines += [_aligned(row, widths) for row in rows]
    lines += ["", "beyond the limits of"]
    lines += [
        f"  {entry['preset']:<9} {entry['measure']} {entry['limit']}: {entry['cells']} cells"
        for entry in result["beyond"]
    ]
    lines += ["the solvers' own tests"] if result["solver_tests"] else []
    lines += [f"  {name}: {count}" for name, count in result["solver_tests"].items()]
    lines += ["definitions"]
    lines += [f"  {name}: {entry['standard']}" for name, entry in result["measures"].items()]
    return "\n".join(lines)


def _row(name: str, entry: dict[str, Any]) -> tuple[str, ...]:
    share = entry["percentiles"]
    values = [entry["min"], share["1"], share["50"], entry["mean"], share["99"], entry["max"]]
    cell, place = "", ""
    if entry["worst"]:
        cell = str(entry["worst"][0]["cell"])
        place = "(" + ", ".join(f"{x:.4g}" for x in entry["worst"][0]["place"]) + ")"
    return (name, *("-" if v is None else f"{v:.5g}" for v in values), cell, place)


def _aligned(row: tuple[str, ...], widths: list[int]) -> str:
    numbers = [f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)][1:-1]
    return "  ".join([f"{row[0]:<{widths[0]}}", *numbers, row[-1]]).rstrip()
