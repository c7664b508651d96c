"""``ffdstudio demo``: the paper's cases and a flow, without a display.

Everything that needs no graphics is written first in each case: where nothing can be rendered,
the results are there all the same and the demo says what is missing.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ffdstudio.cli.demos import contour, morphing, pressure
from ffdstudio.cli.morph import make_folder
from ffdstudio.cli.output import emit, note
from ffdstudio.cli.parsing import named
from ffdstudio.files import write_bytes

CASES: dict[str, Any] = {"morphing": morphing, "contour": contour, "pressure": pressure}
HELP = (
    "only this case: morphing (a mesh follows a few control points, the paper's figures 6 to 8), "
    "contour (regular against adaptive, figure 5), pressure (Cp of the RAE 2822, the mesh follows)"
)


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "-o",
        "--output",
        type=named,
        default="demo-results",
        metavar="DIR",
        help="folder (demo-results)",
    )
    parser.add_argument("--case", choices=tuple(CASES), help=HELP)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Run the cases, write everything, say what came out and where it lies."""
    folder = Path(args.output)
    make_folder(folder)
    figures = {}
    for name in [args.case] if args.case else CASES:
        note(f"case {name}")
        figures[name] = CASES[name].run(folder)
    write_bytes(folder / "figures.json", (json.dumps(figures, indent=1) + "\n").encode())
    lines = [f"{name}: {CASES[name].told(case)}" for name, case in figures.items()]
    files = sorted({file for case in figures.values() for file in case["files"]})
    lines.append(f"results in {folder}: {', '.join(files)}, figures.json")
    emit(figures, "\n".join(lines), args.json)
    return 1 if any(case.get("inverted") for case in figures.values()) else 0
