"""``ffdstudio compare``: adaptive lattices against static ones on many sections."""

from __future__ import annotations

import argparse
from pathlib import Path

from ffdstudio.cli.morph import make_folder
from ffdstudio.cli.output import emit, note
from ffdstudio.cli.parsing import named, whole
from ffdstudio.errors import InputError
from ffdstudio.optimize.compare import report
from ffdstudio.optimize.compare.protocol import ADAPTIVE, Protocol
from ffdstudio.optimize.compare.session import compare, modes_of, sections_in


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = (
        "Each target gets a number of panels and an angle by the seed; everybody begins at the "
        "same section, matches the same pressures by L-BFGS in the same metric, and the solves of "
        "flows, adjoints and metrics are counted. A killed comparison goes on when it is called "
        "again. The folder gets settings.json, runs.csv, summary.md, plots, and each target's "
        "curves of cost against solves."
    )
    parser.add_argument(
        "case", nargs="?", metavar="CASE.toml", help="table [compare] with other settings"
    )
    parser.add_argument("--targets", required=True, metavar="DIR", help="folder of airfoil files")
    parser.add_argument("-o", "--output", type=named, required=True, metavar="DIR")
    parser.add_argument(
        "--exclude", action="append", default=[], metavar="DIR",
        help="folder of files whose names are not drawn, such as those settings were tuned on",
    )  # fmt: skip
    parser.add_argument(
        "--library", metavar="DIR",
        help="sections whose modes are a rival too; those drawn as targets are left out",
    )  # fmt: skip
    parser.add_argument("--count", type=whole, help="targets (100)")
    parser.add_argument("--seed", type=int, help="of panels, angles and the draw (2026)")
    parser.add_argument("--processes", type=whole, default=1, help="at the same time (1)")
    parser.add_argument("--minutes", type=whole, help="begin no further target after so long")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Compare, write, and say what was found."""
    protocol, folder = _protocol(args), Path(args.output)
    files = sections_in(Path(args.targets), [Path(other) for other in args.exclude])
    modes = None
    if "modes" in protocol.rivals:
        drawn_from = {path.stem.lower() for path in files}
        library = [p for p in sections_in(Path(args.library)) if p.stem.lower() not in drawn_from]
        modes = modes_of(library)
    make_folder(folder)
    results = compare(
        files, protocol, folder, args.processes, args.minutes and 60.0 * args.minutes, modes,
        lambda result: note(_line(result, protocol)),
    )  # fmt: skip
    names = report.write(results, protocol, folder)
    told = report.summary(results, protocol)
    emit({**told, "files": names}, report.text(told, protocol), args.json)
    return 0 if told["targets"] >= protocol.count else 1


def _protocol(args: argparse.Namespace) -> Protocol:
    protocol = Protocol() if args.case is None else Protocol.read(args.case)
    values = {**protocol.__dict__}
    values |= {k: v for k in ("count", "seed") if (v := getattr(args, k)) is not None}
    if args.library and "modes" not in protocol.rivals:
        values["rivals"] = (*protocol.rivals, "modes")
    elif "modes" in protocol.rivals and not args.library:
        raise InputError("the modes of a library need one: --library DIR")
    return Protocol(**values)


def _line(result: report.Result, protocol: Protocol) -> str:
    name = f"{result['target']}, {result['panels']} panels, {result['angle']:g} degrees"
    if "refused" in result:
        return f"{name}: {result['refused']}"
    found = {n: report.factors([result], protocol, n)[result["target"]] for n in protocol.variables}
    return f"{name}: " + ", ".join(
        f"{ADAPTIVE} {factor:.3g} times better at N = {n}" for n, factor in found.items()
    )
