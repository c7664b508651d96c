"""``ffdstudio convert``: a lattice from one file format to another."""

from __future__ import annotations

import argparse
from typing import Any

from ffdstudio.cli.output import emit, note, sized
from ffdstudio.errors import InputError
from ffdstudio.exchange import read_lattice_file, write_lattice


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("lattice", metavar="LATTICE", help="file to read")
    parser.add_argument(
        "out",
        metavar="OUT",
        help="file to write: .lattice.json, .xyz, .fmt, .su2 (an existing mesh gets the box), "
        ".cfg, .g2, .prm, .geomdl.json, .splinepy.json",
    )
    parser.add_argument("--block", metavar="B", help="which of several lattices: index or name")
    parser.add_argument(
        "--adapt",
        choices=("refuse", "exact", "resample"),
        default="refuse",
        help="what to do where the format cannot express the lattice (default refuse)",
    )
    parser.add_argument("--tag", help="name of the box in an SU2 file")
    parser.add_argument(
        "--marker", action="append", metavar="NAME", help="markers whose nodes SU2 embeds (all)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Read, write, and say what is exact."""
    content = read_lattice_file(args.lattice, args.block)
    if len(content.blocks) > 1 and args.block is None:
        names = ", ".join(content.blocks)
        note(f"{args.lattice} holds {len(content.blocks)} lattices ({names}); the first is taken")
    for text in content.notes:
        note(f"warning: {args.lattice}: {text}")
    exactness = write_lattice(
        args.out,
        content.rest,
        content.current,
        frozen=content.frozen,
        open_faces=content.open_faces,
        units=content.units,
        adapt=args.adapt,
        **_options(args),
    )
    result = {
        "lattice": args.out,
        "shape": content.rest.shape,
        "degrees": content.rest.degrees,
        "blocks": content.blocks,
        "notes": content.notes,
        "import": vars(content.exactness),
        "export": vars(exactness),
    }
    lines = [
        f"read {args.lattice}: {sized(content.rest.shape)}, {content.exactness}",
        f"wrote {args.out}: {exactness}",
    ]
    emit(result, "\n".join(lines), args.json)
    return 0


def _options(args: argparse.Namespace) -> dict[str, Any]:
    """Options that only SU2 files have."""
    options = {"tag": args.tag, "markers": args.marker}
    given = {key: value for key, value in options.items() if value is not None}
    allowed = {".su2": {"tag", "markers"}, ".cfg": {"tag"}}.get(args.out[-4:].lower(), set())
    if not given.keys() <= allowed:
        raise InputError(f"--tag and --marker are for SU2 files, not for {args.out}")
    return given
