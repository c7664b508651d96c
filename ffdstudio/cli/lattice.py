"""``ffdstudio lattice``: a lattice around a mesh or one of its markers."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

import numpy as np

from ffdstudio.cli.output import emit, sized
from ffdstudio.cli.parsing import axes, fraction, named, whole
from ffdstudio.engine import Lattice
from ffdstudio.engine.boxes import Frame
from ffdstudio.errors import InputError
from ffdstudio.exchange import write_lattice
from ffdstudio.meshes import Mesh, read_mesh

MOST = 1_000_000  # control points; no file or solver has room for more


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", metavar="FILE", help="the mesh")
    parser.add_argument(
        "--shape",
        type=whole,
        nargs="+",
        metavar="N",
        help="control points in each direction, 1 to 3 numbers (default 8 6 4, in 2D 8 6)",
    )
    parser.add_argument(
        "--degree",
        type=whole,
        nargs="+",
        metavar="P",
        help="degrees, one for all or one a direction (default 3 where there are 4 points)",
    )
    parser.add_argument(
        "--marker", action="append", metavar="NAME", help="around this marker only (repeatable)"
    )
    parser.add_argument(
        "--margin",
        type=fraction,
        default=0.05,
        metavar="F",
        help="room on each side as a fraction of the extent (default 0.05)",
    )
    parser.add_argument(
        "--axes", type=axes, metavar="XYZ", help="directions of i, j, k, such as xz"
    )
    parser.add_argument(
        "--spacing", choices=("greville", "uniform"), default="greville", help="of control points"
    )
    parser.add_argument("--frozen", type=whole, default=0, metavar="K", help="frozen outer layers")
    parser.add_argument("--units", default="", help="unit of length, for the record")
    parser.add_argument(
        "-o", "--output", type=named, required=True, metavar="LATTICE", help="lattice file"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Make the lattice and write it."""
    mesh = read_mesh(args.file)
    nodes = mesh.points[mesh.marker_nodes(*args.marker)] if args.marker else mesh.points
    shape = _shape(args.shape or (8, 6, 4)[: mesh.dimension])
    if not 1 <= len(shape) <= 3:
        raise InputError(f"--shape takes 1 to 3 numbers, got {len(shape)}")
    lattice = around(mesh, nodes, shape, _degrees(args.degree, shape), args)
    if 2 * args.frozen >= min(shape):
        raise InputError(f"--frozen {args.frozen} leaves nothing of {sized(shape)} control points")
    exactness = write_lattice(args.output, lattice, frozen=args.frozen, units=args.units)
    result = {
        "lattice": args.output,
        "shape": lattice.shape,
        "degrees": lattice.degrees,
        "domain": lattice.domain,
        "exact": exactness.exact,
        "nodes": len(nodes),
    }
    degrees = ", ".join(map(str, lattice.degrees))
    text = f"{args.output}: {sized(shape)} control points of degree {degrees} ({exactness})"
    emit(result, text, args.json)
    return 0


def _shape(counts: Sequence[int]) -> tuple[int, ...]:
    points = math.prod(counts)
    if points > MOST:
        raise InputError(
            f"--shape {sized(tuple(counts))}: these are {points:,} control points, "
            f"more than the {MOST:,} that a lattice may have"
        )
    return tuple(counts)


def around(
    mesh: Mesh,
    nodes: np.ndarray,
    shape: tuple[int, ...],
    degrees: list[int] | None,
    args: argparse.Namespace,
) -> Lattice:
    """Box lattice around the nodes; a flat mesh gets one of thickness 1 in the third direction."""
    frame = Frame.of(args.axes, len(shape))
    lower, upper = frame.bounds(nodes, args.margin)
    if mesh.dimension == 2:
        normal = np.flatnonzero(frame.axes[:, 2])
        lower[normal], upper[normal] = -0.5, 0.5
    return Lattice.box(lower, upper, shape, degrees, args.axes, args.spacing)


def _degrees(given: list[int] | None, shape: tuple[int, ...]) -> list[int] | None:
    if given is not None and len(given) == 1:
        return given * len(shape)
    return given
