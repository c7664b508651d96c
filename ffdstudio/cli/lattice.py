"""``ffdstudio lattice``: a lattice around a mesh or one of its markers.

1. Where the mesh ends at a symmetry plane the lattice begins there, without a margin.
2. Where mesh lies on both sides of a face the outermost control points are frozen by default.
3. The margin is chosen such that the skin can move by a sensible share of the shape; how far it
   can is said, and if it is little.
   What was done of each is said in a line.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

from ffdstudio.cli.output import emit, sized
from ffdstudio.cli.parsing import axes, fraction, named, whole
from ffdstudio.engine.frozen import leaves_some
from ffdstudio.errors import InputError
from ffdstudio.exchange import write_lattice
from ffdstudio.limits import check_control_points
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.project.checks.freezing import advice, face_name
from ffdstudio.project.checks.plane_snapping import seat_sentence
from ffdstudio.project.placing.placement import Placement, Site, placed
from ffdstudio.project.placing.reach import reach_sentence


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
        nargs="+",
        metavar="F",
        help="room on each side as a fraction of the largest extent, one for all or one a "
        "direction (default: enough for the skin to move by 8 %% of the chord, or by the "
        "thickness of a body); none beyond a symmetry plane",
    )
    parser.add_argument(
        "--axes", type=axes, metavar="XYZ", help="directions of i, j, k, such as xz"
    )
    parser.add_argument(
        "--spacing", choices=("greville", "uniform"), default="greville", help="of control points"
    )
    parser.add_argument(
        "--frozen",
        type=whole,
        metavar="K",
        help="frozen outer layers (default: 1 where mesh lies on both sides of a face, else 0)",
    )
    parser.add_argument("--units", default="", help="unit of length, for the record")
    parser.add_argument(
        "-o", "--output", type=named, required=True, metavar="LATTICE", help="lattice file"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Make the lattice and write it."""
    mesh = read_mesh(args.file)
    shape = _shape(args.shape or (8, 6, 4)[: 2 if is_plane(mesh) else 3])
    if not 1 <= len(shape) <= 3:
        raise InputError(f"--shape takes 1 to 3 numbers, got {len(shape)}")
    site = Site.of_mesh(mesh, args.marker or ())
    margin = args.margin[0] if args.margin and len(args.margin) == 1 else args.margin
    degrees = _degrees(args.degree, shape)
    found = placed(site, shape, degrees, args.axes, args.spacing, margin)
    chosen = args.frozen is not None
    frozen = args.frozen if chosen else found.frozen
    if not leaves_some(shape, frozen, found.planes):
        raise InputError(f"--frozen {frozen} leaves nothing of {sized(shape)} control points")
    free = found.planes if frozen else ()
    exactness = write_lattice(
        args.output, found.lattice, frozen=frozen, units=args.units, open_faces=free
    )
    reach = found.reach(site, frozen)
    result = {
        "lattice": args.output,
        "shape": found.lattice.shape,
        "degrees": found.lattice.degrees,
        "domain": found.lattice.domain,
        "exact": exactness.exact,
        "nodes": len(site.skin),
        "frozen": frozen,
        "crossed_faces": [face_name(face) for face in found.crossed],
        "on_planes": {face_name(face): marker for face, marker in found.planes.items()},
        "margin": found.room,
        "reach": reach if math.isfinite(reach) else None,
    }
    text = f"{args.output}: {sized(shape)} control points of degree "
    text += f"{', '.join(map(str, found.lattice.degrees))} ({exactness})"
    lines = [text, seat_sentence(found.planes), _freezing(found, frozen, chosen)]
    lines += [reach_sentence(reach, found.wanted), _walls_hint(mesh, args.marker)]
    emit(result, "\n".join(line for line in lines if line), args.json)
    return 0


def _freezing(found: Placement, frozen: int, chosen: bool) -> str:
    """What is frozen and why, or why nothing is although mesh lies beyond."""
    shape = found.lattice.shape
    line = advice(shape, found.crossed, frozen, found.planes)
    if found.crossed and not frozen and not chosen:
        where = line.partition(":")[0]
        return f"{where}, but {sized(shape)} points leave none to freeze: nothing is frozen."
    return line


def _walls_hint(mesh: Mesh, markers: Sequence[str] | None) -> str:
    """A word where the lattice lies around a far field and the walls in it are small."""
    names = () if markers else wall_markers(mesh)
    if not names:
        return ""
    return (
        f"The mesh reaches far beyond {', '.join(names)}: "
        f"{' '.join(f'--marker {name}' for name in names)} lays the lattice around that alone."
    )


def _shape(counts: Sequence[int]) -> tuple[int, ...]:
    try:
        check_control_points(counts)
    except InputError as error:
        raise InputError(f"--shape: {error}") from None
    return tuple(counts)


def _degrees(given: list[int] | None, shape: tuple[int, ...]) -> list[int] | None:
    if given is not None and len(given) == 1:
        return given * len(shape)
    return given
