"""``ffdstudio optimize``: a study from a case file."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ffdstudio.aliases import Array
from ffdstudio.cli.morph import make_folder, measured
from ffdstudio.cli.output import emit, note
from ffdstudio.cli.parsing import named
from ffdstudio.cli.study_files import write_common, write_contour
from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.spaces import in_space_of
from ffdstudio.errors import InputError
from ffdstudio.exchange.morphed import write_morphed
from ffdstudio.files import refuse_source
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.following import METHOD
from ffdstudio.meshes.formats import suffix_of
from ffdstudio.meshes.ways import Way
from ffdstudio.optimize import plots
from ffdstudio.optimize.build.build import Built, read_case
from ffdstudio.optimize.consent import Consent
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.remembered import Remembered
from ffdstudio.optimize.runs.record import Record, RunHistory
from ffdstudio.optimize.spec.codec import schema
from ffdstudio.optimize.spec.reference import reference

PACKAGE = Path(__file__).parents[1]
PLACES = [place / "resources" / "cases" for place in (PACKAGE, PACKAGE.parent)]  # wheel, checkout
EXAMPLES = next((place for place in PLACES if place.is_dir()), "resources/cases of the sources")
MET = 1e-6  # largest violation of a constraint that counts as met


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = f"Example cases, one for each kind of objective: {EXAMPLES}"
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("case", metavar="CASE", nargs="?", help="case file, TOML")
    what.add_argument("--schema", action="store_true", help="print the JSON schema of case files")
    what.add_argument(
        "--reference", action="store_true", help="print every key of case files, as Markdown"
    )
    parser.add_argument(
        "-o", "--output", type=named, metavar="DIR", help="folder for log and results"
    )
    parser.add_argument("--resume", action="store_true", help="go on where the log in DIR ends")
    parser.add_argument(
        "--trust",
        action="store_true",
        help="let programs and functions run that came inside a project or a folder of a record; "
        "those of a case file that you name need no leave",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Run the case, write everything, say where it ended."""
    if args.schema or args.reference:
        print(json.dumps(schema(), indent=1) if args.schema else reference(), end="")
        return 0
    folder = None if args.output is None else Path(args.output)
    if folder is not None:
        make_folder(folder)
    case = read_case(args.case, folder, args.resume, Consent(everything=args.trust))
    meshes = list(case.followers())
    if folder is not None:
        for name in outputs(meshes, Path(args.case).stem):
            refuse_source(folder / name)
    history = _ran(case, args.case)
    result = figures(history) | _recalled(case.memory)
    if folder is not None:
        result["files"] = write(case, history, folder, Path(args.case).stem, meshes)
        result |= _morphed(case, meshes, history.lattice(-1), folder, result["files"])
    emit(result, _text(result, args.output), args.json)
    failed = (history.ending is not None and history.ending.failed) or result["violation"] > MET
    torn = any(one.get("inverted") for one in [result.get("mesh", {}), *result.get("meshes", [])])
    return 1 if failed or torn else 0


def _text(result: dict[str, Any], folder: str | None) -> str:
    """Figures for people."""
    lines = [
        f"{key:<12} {value:.4g}" if isinstance(value, float) else f"{key:<12} {value}"
        for key, value in result.items()
        if value is not None and key not in ("history", "files", "measures", "mesh", "meshes")
    ]
    parts = {**result["measures"], **result.get("mesh", {})}
    lines += [
        f"  {key} {value:.6g}" for key, value in parts.items() if isinstance(value, int | float)
    ]
    if folder is not None:
        lines.append(f"results in {folder}: {', '.join(result['files'])}")
    return "\n".join(lines)


def _ran(case: Built, path: str) -> RunHistory:
    """Run a study; what goes wrong at its start is told with the case's name."""
    try:
        return case.study.run(_tell)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _tell(record: Record) -> None:
    if record.kind == "iterate":
        note(f"iteration {record.iteration}, {record.variables} variables: cost {record.cost:.6e}")
    if record.kind == "refinement":
        note(f"knot {record.note}")
    if record.kind == "end":
        note(f"ended: {record.note}")


def figures(history: RunHistory) -> dict[str, Any]:
    """What is printed."""
    rows = [_row(record) for record in history.iterates]
    last = history.iterates[-1]
    missed = [v for k, v in last.measures.items() if k.startswith("violation")]
    return {
        **rows[-1],
        "first_cost": history.iterates[0].cost,
        "violation": max(missed, default=0.0),
        "ended": history.records[-1].note,
        "history": rows,
    }


def _recalled(memory: Remembered | None) -> dict[str, int]:
    """How many answers came from an earlier run, of an objective that is remembered."""
    if memory is None:
        return {}
    if memory.recalled:
        note(f"{memory.recalled} evaluations were known from {memory.folder}")
    return {"recalled": memory.recalled}


def _row(record: Record) -> dict[str, Any]:
    names = ("cost", "variables", "evaluation", "iteration", "flow", "adjoint", "seconds")
    row = {name: getattr(record, name) for name in names}
    row["gradient"] = None if math.isnan(record.gradient) else record.gradient
    row["measures"] = record.measures
    return row


def outputs(meshes: Sequence[Mesh], name: str) -> list[str]:
    """Files that a study writes on when it is over; what it draws has names of its own."""
    fixed = [f"{name}.lattice.json", f"{name}.ffdproj", "history.csv", "contour.dat", "log.jsonl"]
    return [*fixed, *(_mesh_name(mesh, meshes) for mesh in meshes)]


def write(
    case: Built, history: RunHistory, folder: Path, name: str, meshes: Sequence[Mesh]
) -> list[str]:
    """Write lattice, project, CSV, plots and contour; returns the names of the files."""
    current = history.lattice(-1)
    rest = in_space_of(case.rest, current)
    plotted = ["cost", "variables"]
    ways = [Way.WALLS if _walls(case, mesh) is not None else Way.LATTICE for mesh in meshes]
    common = write_common(folder, name, rest, current, history, plotted, meshes, ways)
    files = [*common, "log.jsonl"]
    points = embed(rest, case.shape.points).deform(current)
    if case.shape.triangles is None and case.shape.mesh is None:
        files.append(write_contour(folder / "contour.dat", name, points))
        curves = {"start": case.shape.points, "end": points}
        files += plots.save(plots.outlines(curves, current.control_points), folder, "sections")
    files += _pressures(case.task.objective, case.shape.points, points, folder)
    return files


def _pressures(objective: Objective, start: Array, end: Array, folder: Path) -> list[str]:
    files, after = [], objective.pressures(end)
    for name, before in objective.pressures(start).items():
        curves = {"start": before["shape"], "end": after[name]["shape"]}
        if "target" in before:
            curves["target"] = before["target"]
        files += plots.save(plots.pressures(curves, "target"), folder, f"pressure_{name}")
    return files


def _mesh_name(mesh: Mesh, meshes: Sequence[Mesh]) -> str:
    path = Path(str(mesh.path))
    suffix = suffix_of(path)
    own = "" if len(meshes) == 1 else f"_{path.name.removesuffix(suffix)}"
    return f"morphed{own}{suffix}"


def _morphed(
    case: Built, meshes: Sequence[Mesh], current: Lattice, folder: Path, files: list[str]
) -> dict[str, Any]:
    """All meshes follow the lattice; returns figures of the first, and of all if several do."""
    rest, figures = in_space_of(case.rest, current), []
    for mesh in meshes:
        body, walls = case.body_of(mesh), _walls(case, mesh)
        points = embed(rest, case.before(mesh)).deform(current)
        if body is not None:
            points = body.at(current)
        name = _mesh_name(mesh, meshes)
        write_morphed(mesh, folder / name, points, [(rest, current)])
        files.append(name)
        follow = None if walls is None else {"method": METHOD, "walls": walls}
        figures.append({"file": name, **measured(mesh, points), "follow": follow})
    first = {"mesh": {k: v for k, v in figures[0].items() if k != "file"}} if figures else {}
    return first | ({"meshes": figures} if len(figures) > 1 else {})


def _walls(case: Built, mesh: Mesh) -> list[str] | None:
    """Walls that a mesh followed; None if the lattice carried it."""
    body = case.body_of(mesh)
    return None if body is None or body.walls is None else [str(wall) for wall in body.walls]
