"""``ffdstudio morph``: meshes deformed by one lattice.

Everything is computed before anything is written, and put in place together: bad input in the
last mesh or a full disk leave no first one behind. A point's new place depends on the point and
the lattices alone; nodes of different meshes that coincide therefore stay coincident to the bit.
What a deformation does to planes, pairs and smoothness is said before anything is written.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.cli.deforming import FARTHEST, check_motion, deformed, write_motion
from ffdstudio.cli.output import emit, note
from ffdstudio.cli.parsing import assignment, named, shortened, whole
from ffdstudio.engine import Lattice
from ffdstudio.engine.folds import Folds, folds
from ffdstudio.engine.frozen import frozen_mask
from ffdstudio.engine.inversion.tangle import refuse_tangled
from ffdstudio.errors import InputError
from ffdstudio.exchange import LatticeFile, read_lattice_file
from ffdstudio.exchange.morphed import BOXES, write_morphed
from ffdstudio.exchange.text import naming
from ffdstudio.files import together
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.measures.cell_coverage import Coverage, coverage
from ffdstudio.meshes.writing import refuse_unwritable
from ffdstudio.paths import exists, is_folder, is_same
from ffdstudio.project.checks.deformation_warnings import remarks

SUMMED = ("nodes", "moved", "inverted", "unchecked")
MOST_NAMED = 4  # markers in the line of a mesh


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "files", nargs="+", metavar="MESH ... LATTICE", help="meshes, a lattice last"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=named,
        required=True,
        metavar="OUT",
        help="mesh file; a folder for several",
    )
    parser.add_argument(
        "--move",
        action="append",
        default=[],
        metavar="I,J,K=DX,DY,DZ",
        help="move a control point (repeatable; I,J and I for fewer directions)",
    )
    parser.add_argument(
        "--weight",
        action="append",
        default=[],
        metavar="I,J,K=W",
        help="set the weight of a control point (repeatable)",
    )
    parser.add_argument(
        "--frozen",
        type=whole,
        metavar="K",
        help="reset the K outermost layers on every face (default: what the lattice file says)",
    )
    parser.add_argument("--block", metavar="B", help="which of several lattices in the file")
    parser.add_argument(
        "--boxes",
        choices=BOXES,
        default="update",
        help="FFD boxes inside SU2 meshes: let them follow the shape (default), drop or keep them",
    )
    parser.add_argument(
        "--allow-unchecked",
        action="store_true",
        help="exit 0 although cells of unknown types were moved without being checked",
    )
    parser.add_argument(
        "--follow",
        action="store_true",
        help="the lattice moves the walls alone, and the volume follows them: boundary layers keep "
        "their heights, also where the lattice is tight or cuts the mesh",
    )
    parser.add_argument(
        "--walls",
        action="append",
        type=named,
        metavar="MARKER",
        help="a boundary that moves with --follow (repeatable; default: those that the lattice "
        "moves, but for symmetry, empty, periodic and flat neighbouring ones, which slide)",
    )
    parser.add_argument(
        "--solver-motion",
        type=named,
        metavar="FILE",
        help="also write where the walls go, for the solver's own deformation: SU2's SURFACE_FILE, "
        "or OpenFOAM's 0/pointDisplacement",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


@dataclass
class Morph:
    """One mesh on its way."""

    source: str
    target: Path
    mesh: Mesh
    points: Array
    result: dict[str, Any]


def run(args: argparse.Namespace) -> int:
    """Read, deform, then write; 1 if cells are inverted, or moved without being checked."""
    if len(args.files) < 2:
        raise InputError("morph needs at least one mesh and, last, a lattice")
    *sources, lattice_file = args.files
    content = read_lattice_file(lattice_file, args.block)
    if len(content.blocks) > 1 and args.block is None:
        note(f"{lattice_file} holds {len(content.blocks)} lattices; the first is taken (--block)")
    for text in content.notes:
        note(f"warning: {lattice_file}: {text}")
    with naming(lattice_file):
        refuse_tangled(content.rest)
    rest, current, held = edited(content, args.move, args.weight, args.frozen)
    for text in held:
        note(f"warning: {text}: this control point is frozen and stays; --frozen 0 frees all")
    targets = _targets(sources, Path(args.output))
    _check_kept(targets, sources, lattice_file)
    if args.walls and not (args.follow or args.solver_motion):
        raise InputError("--walls says which boundaries move with --follow or --solver-motion")
    if args.solver_motion:
        check_motion(args.solver_motion, [*targets, *sources, lattice_file], len(sources))
    morphs = [
        morphed(source, target, rest, current, args.follow, args.walls)
        for source, target in zip(sources, targets, strict=True)
    ]
    for morph in morphs:
        for warning in morph.result["warnings"]:
            note(f"warning: {morph.source}: {warning}")
    if len(sources) > 1:
        make_folder(Path(args.output))
    with together():
        for morph in morphs:
            write_morphed(morph.mesh, morph.target, morph.points, [(rest, current)], args.boxes)
        if args.solver_motion:
            write_motion(morphs[0].mesh, args.solver_motion, morphs[0].points, args.walls)
    folded = folds(current, rest)
    result = {
        **_together([morph.result for morph in morphs]), **_invertible(folded), "held": held,
    }  # fmt: skip
    lines = [*map(_line, morphs), _folds_line(folded)]
    emit(result, "\n".join(lines), args.json)
    unseen = result["unchecked"] and result["moved"] and not args.allow_unchecked
    return 1 if result["inverted"] or unseen else 0


def edited(
    content: LatticeFile, moves: list[str], weights: list[str], frozen: int | None
) -> tuple[Lattice, Lattice, list[str]]:
    """Lattice at rest, the deformed one, and the options that frozen points bring to nothing."""
    rest, current, told = content.rest, content.current, []
    points, values = current.control_points.copy(), current.weights.copy()
    for text in moves:
        index, vector = assignment(text, "--move", rest)
        if len(vector) not in ({2, 3} if rest.dimension == 2 else {3}):
            count = "two or three" if rest.dimension == 2 else "three"
            raise InputError(f"--move {shortened(text)}: {count} displacements are needed")
        points[index][: len(vector)] += vector
        told.append((index, f"--move {shortened(text)}"))
    for text in weights:
        index, value = assignment(text, "--weight", rest)
        if len(value) != 1 or value[0] <= 0:
            raise InputError(f"--weight {shortened(text)}: one positive number is needed")
        values[index] = value[0]
        told.append((index, f"--weight {shortened(text)}"))
    if frozen is None:
        mask = frozen_mask(rest.shape, content.frozen, content.open_faces)
    else:
        mask = frozen_mask(rest.shape, frozen, rest.seams)
    points[mask], values[mask] = rest.control_points[mask], rest.weights[mask]
    return rest, rest.moved(points, values), [text for index, text in told if mask[index]]


def morphed(
    source: str,
    target: Path,
    rest: Lattice,
    current: Lattice,
    follow: bool = False,
    walls: list[str] | None = None,
) -> Morph:
    """Read a mesh and deform it, all of it or its walls with the volume following."""
    mesh = read_mesh(source)
    refuse_unwritable(mesh, target)
    with naming(source):
        refuse_tangled(rest)
    points, result = deformed(mesh, rest, current, follow, walls)
    if mesh.dimension == 2 and (points[:, 2] != mesh.points[:, 2]).any():
        raise InputError(f"{source}: a 2D mesh cannot move in z")
    if not (np.abs(points) < FARTHEST).all():
        raise InputError(f"{source}: the lattice moves points beyond {FARTHEST:g}")
    result |= measured(mesh, points)
    result["warnings"] = remarks(mesh, points, rest, current, carried=not follow)
    return Morph(source, target, mesh, points, result)


def measured(mesh: Mesh, points: Array) -> dict[str, Any]:
    """Figures of a deformation."""
    from ffdstudio.meshes import inverted, safe_amplitude

    seen = coverage(mesh)
    step = points - mesh.points
    safe = safe_amplitude(mesh, step)
    moved = (points.view(np.int64) != mesh.points.view(np.int64)).any(axis=1)
    return {
        "nodes": len(points),
        "moved": int(moved.sum()),
        "max_displacement": _largest(step),
        "markers": {name: _largest(step[mesh.marker_nodes(name)]) for name in mesh.boundaries},
        "inverted": inverted(mesh, points).count,
        "safe_amplitude": safe if np.isfinite(safe) else None,  # None: nothing checked ever inverts
        "unchecked": seen.missing,
        "unchecked_types": seen.unchecked,
    }


def _largest(step: Array) -> float:
    return float(np.linalg.norm(step, axis=1).max(initial=0.0))


def _targets(sources: list[str], out: Path) -> list[Path]:
    """Where each mesh goes: the file OUT, or its name in the folder OUT."""
    if len(sources) == 1 and not is_folder(out):
        return [out]
    if exists(out) and not is_folder(out):
        raise InputError(f"{out}: several meshes need a folder, this is a file")
    names = [Path(source).name for source in sources]
    if len(set(names)) < len(names):
        raise InputError("two of the meshes have the same name: one folder cannot hold both")
    return [out / name for name in names]


def _check_kept(targets: list[Path], sources: list[str], lattice_file: str) -> None:
    """Refuse to overwrite what is read."""
    for target in targets:
        for path, what in (*((source, "mesh") for source in sources), (lattice_file, "lattice")):
            if is_same(target, path):
                raise InputError(f"{target}: this would overwrite the {what} that is read")


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, as far as they are missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make {folder}: {(error.strerror or '').lower()}") from None


def _together(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Totals over all meshes, and each of them when there are several."""
    total = {key: sum(result[key] for result in results) for key in SUMMED}
    total["max_displacement"] = max(result["max_displacement"] for result in results)
    safe = [r["safe_amplitude"] for r in results if r["safe_amplitude"] is not None]
    total["safe_amplitude"] = min(safe, default=None)
    total["warnings"] = list(dict.fromkeys(w for result in results for w in result["warnings"]))
    types = Counter[str]()
    for result in results:
        types.update(result["unchecked_types"])
    total["unchecked_types"] = dict(types)
    if len(results) == 1:
        return {**results[0], **total}
    return {**total, "meshes": results}


def _invertible(folded: Folds) -> dict[str, Any]:
    """Whether the lattice's map is locally invertible, how that was found, and where it is not."""
    return {
        "locally_invertible": folded.answer,
        "locally_invertible_method": folded.method,
        "not_invertible_in": folded.where,
    }


def _folds_line(folded: Folds) -> str:
    """One line on the lattice as a map; cells are counted by themselves."""
    where = folded.where
    if not where:
        return str(folded)
    ends = zip("ijk", where[0], strict=False)
    place = ", ".join(f"{name} {low:.4g} to {high:.4g}" for name, (low, high) in ends)
    return f"warning: {folded}, the first one at {place}"


def _line(morph: Morph) -> str:
    result = morph.result
    walls = [f"{name} by up to {step:.4g}" for name, step in result["markers"].items() if step > 0]
    follow = result["follow"]
    by = f"; the volume follows {', '.join(follow['walls']) or 'nothing'}" if follow else ""
    at = f" ({', '.join(walls[:MOST_NAMED])})" if walls else ""
    return (
        f"{morph.target}: {result['moved']} of {result['nodes']} nodes moved, by up to "
        f"{result['max_displacement']:.4g}{at}{by}; {_limit(result)}; "
        f"{result['inverted']} inverted cells"
    )


def _limit(result: dict[str, Any]) -> str:
    """How far the cells are safe; what was not checked is never called so."""
    safe = result["safe_amplitude"]
    limit = "safe at any multiple" if safe is None else f"safe up to {safe:.6g} times that"
    if not result["unchecked"]:
        return limit
    unseen = Coverage(unchecked=result["unchecked_types"])
    return str(unseen) if safe is None else f"{unseen}, the others {limit}"
