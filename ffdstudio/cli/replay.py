"""``ffdstudio replay``: the journal of a window, repeated without it."""

from __future__ import annotations

import argparse

from ffdstudio.cli.output import emit, note
from ffdstudio.cli.parsing import named
from ffdstudio.project.files.replaying import export, replay


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("journal", metavar="JOURNAL", help="file with one command a line")
    parser.add_argument(
        "-o",
        "--output",
        type=named,
        default=".",
        metavar="DIR",
        help="folder for the meshes (default: here)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Repeat all commands, then write the meshes as they are deformed at the end."""
    model = replay(args.journal)
    written = export(model, args.output, note)
    result = {
        "meshes": [
            {"name": each.name, "path": str(each.path), "nodes": each.nodes, "moved": each.moved}
            for each in written
        ],
        "lattices": [
            {"name": item.name, "shape": item.rest.shape, "degrees": item.rest.degrees}
            for item in model.lattices
        ],
    }
    lines = [f"{each.path}: {each.moved} of {each.nodes} nodes moved" for each in written]
    emit(result, "\n".join(lines), args.json)
    return 0
