"""``ffdstudio lattice``: a lattice around a mesh or one of its markers.

1. Where the mesh ends at a symmetry plane the lattice begins there, without a margin.
2. Where mesh lies on both sides of a face the outermost control points are frozen by default.
   What was done of both is said in a line each.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

from ffdstudio.cli.output import emit, sized
from ffdstudio.cli.parsing import axes, fraction, named, whole
from ffdstudio.engine import Lattice
from ffdstudio.engine.boxes import Frame
from ffdstudio.engine.frozen import leaves_some
from ffdstudio.errors import InputError
from ffdstudio.exchange import write_lattice
from ffdstudio.limits import check_control_points
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.planes import planes_of
from ffdstudio.project.checks.freezing import Face, advice, face_name, suggested
from ffdstudio.project.checks.plane_snapping import seat_sentence, seated

NEAR = 0.1  # of the shape's largest extent


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
        default=[0.05],
        metavar="F",
        help="room on each side as a fraction of the extent, one for all or one a direction "
        "(default 0.05); none beyond a symmetry plane",
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
    nodes = mesh.points[mesh.marker_nodes(*args.marker)] if args.marker else mesh.points
    shape = _shape(args.shape or (8, 6, 4)[: mesh.dimension])
    if not 1 <= len(shape) <= 3:
        raise InputError(f"--shape takes 1 to 3 numbers, got {len(shape)}")
    lattice, planes = around(mesh, nodes, shape, _degrees(args.degree, shape), args)
    frozen, faces = suggested(lattice, [(mesh, mesh.points)], planes)
    chosen = args.frozen is not None
    frozen = args.frozen if chosen else frozen
    if not leaves_some(shape, frozen, planes):
        raise InputError(f"--frozen {frozen} leaves nothing of {sized(shape)} control points")
    free = planes if frozen else ()
    exactness = write_lattice(
        args.output, lattice, frozen=frozen, units=args.units, open_faces=free
    )
    result = {
        "lattice": args.output,
        "shape": lattice.shape,
        "degrees": lattice.degrees,
        "domain": lattice.domain,
        "exact": exactness.exact,
        "nodes": len(nodes),
        "frozen": frozen,
        "crossed_faces": [face_name(face) for face in faces],
        "on_planes": {face_name(face): marker for face, marker in planes.items()},
    }
    degrees = ", ".join(map(str, lattice.degrees))
    text = f"{args.output}: {sized(shape)} control points of degree {degrees} ({exactness})"
    lines = [text, seat_sentence(planes), _freezing(faces, frozen, chosen, lattice, planes)]
    lines.append(_closeness(lattice, nodes, faces) if frozen else "")
    emit(result, "\n".join(line for line in lines if line), args.json)
    return 0


def _freezing(
    faces: list[Face], frozen: int, chosen: bool, lattice: Lattice, planes: dict[Face, str]
) -> str:
    """What is frozen and why, or why nothing is although mesh lies beyond."""
    line = advice(lattice.shape, faces, frozen, planes)
    if faces and not frozen and not chosen:
        where = line.partition(":")[0]
        return (
            f"{where}, but {sized(lattice.shape)} points leave none to freeze: nothing is frozen."
        )
    return line


def _closeness(lattice: Lattice, nodes: np.ndarray, faces: list[Face]) -> str:
    """A word where frozen faces lie so near the shape that little can move between them."""
    local = nodes @ lattice.axes.T
    extent = float(np.ptp(local, axis=0).max())
    ends = lattice.domain
    gaps = {
        face: abs(float((local.min(axis=0), local.max(axis=0))[face[1]][face[0]] - ends[face]))
        for face in faces
    }
    near = [face for face, gap in gaps.items() if gap < NEAR * extent]
    if not near:
        return ""
    least = min(gaps[face] for face in near)
    return (
        f"Frozen at {', '.join(map(face_name, near))}, as near as {least:.3g} to the shape, the "
        "lattice has little room to move it: a larger --margin gives more."
    )


def _shape(counts: Sequence[int]) -> tuple[int, ...]:
    try:
        check_control_points(counts)
    except InputError as error:
        raise InputError(f"--shape: {error}") from None
    return tuple(counts)


def around(
    mesh: Mesh,
    nodes: np.ndarray,
    shape: tuple[int, ...],
    degrees: list[int] | None,
    args: argparse.Namespace,
) -> tuple[Lattice, dict[Face, str]]:
    """Box lattice around the nodes, and the planes its faces lie on.

    A flat mesh gets one of thickness 1 in the third direction.
    """
    frame = Frame.of(args.axes, len(shape))
    bounds = frame.bounds(nodes, args.margin[0] if len(args.margin) == 1 else args.margin)
    lower, upper, planes = seated(frame, bounds, nodes, planes_of(mesh))
    if mesh.dimension == 2:
        normal = np.flatnonzero(frame.axes[:, 2])
        lower[normal], upper[normal] = -0.5, 0.5
    return Lattice.box(lower, upper, shape, degrees, args.axes, args.spacing), planes


def _degrees(given: list[int] | None, shape: tuple[int, ...]) -> list[int] | None:
    if given is not None and len(given) == 1:
        return given * len(shape)
    return given
