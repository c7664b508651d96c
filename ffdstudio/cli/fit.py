"""``ffdstudio fit``: the lattice that turns one shape into another."""

from __future__ import annotations

import argparse
from pathlib import Path

from ffdstudio.aliases import Array
from ffdstudio.cli.morph import make_folder
from ffdstudio.cli.output import emit, note
from ffdstudio.cli.parsing import fraction, named, whole
from ffdstudio.cli.study_files import write_common, write_contour
from ffdstudio.errors import InputError
from ffdstudio.optimize import FitResult, plots
from ffdstudio.optimize import fit as fit_shapes
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.metrics import METRICS
from ffdstudio.optimize.fits.fitting import NOTHING, extent
from ffdstudio.optimize.geometry.contour import upper_side
from ffdstudio.optimize.geometry.sections import kulfan_tolerance
from ffdstudio.optimize.runs.record import Record
from ffdstudio.paths import is_same

UNWRITTEN = "nothing written; -o DIR writes the lattice, a project, the log, a table and plots"
OUTPUTS = (
    "fit.lattice.json", "fit.ffdproj", "history.csv", "contour.dat", "log.jsonl",
)  # fmt: skip
"""Files that a fit writes on when it is over; what it draws has names of its own."""


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = (
        "Errors in 2D are also told in units of Kulfan's tolerance: 4e-4 of the chord for x < 0.2, "
        "8e-4 aft of it. Only results in a folder (-o) are kept."
    )
    parser.add_argument("source", metavar="SOURCE", help="file, or a section such as naca0012")
    parser.add_argument("target", metavar="TARGET", help="file or section")
    parser.add_argument(
        "--element", type=whole, metavar="N", help="element of a target with several, from 1"
    )
    parser.add_argument("--source-element", type=whole, metavar="N", help="the same of the source")
    parser.add_argument("--columns", type=whole, default=35, help="control points in x (35)")
    parser.add_argument("--rows", type=whole, default=2, help="control points in y (2)")
    parser.add_argument("--layers", type=whole, help="control points in z, 3D only (2)")
    parser.add_argument("--start", type=whole, help="columns at the beginning (5)")
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--regular", action="store_true", help="do not refine")
    way.add_argument(
        "--adaptive",
        choices=[one.name for one in INDICATORS],
        default="gain",
        help="indicator (gain)",
    )
    parser.add_argument(
        "--method",
        choices=_methods(),
        default="gauss-newton",
        help="of optimization (gauss-newton)",
    )
    parser.add_argument(
        "--norm",
        choices=("l2", "max"),
        default="l2",
        help="of the error: mean square or largest (l2)",
    )
    parser.add_argument(
        "--metric", choices=[one.name for one in METRICS], default=METRICS[0].name,
        help="in which the variables are orthonormal: that of the surface (l2), with its slopes "
        "(h1), or the control points as they are (none); default: h1",
    )  # fmt: skip
    parser.add_argument("--row-wise", action="store_true", help="a new knot frees one row only")
    parser.add_argument("--spacing", choices=("greville", "uniform"), default="greville")
    parser.add_argument("--directions", metavar="xyz", help="of displacements, 3D only (xyz)")
    parser.add_argument("--variables", type=whole, help="number of variables at the end")
    parser.add_argument("--evaluations", type=whole, help="budget of evaluations")
    parser.add_argument("--iterations", type=whole, help="budget of iterations")
    parser.add_argument("--tolerance", type=fraction, help="RMS to reach; exit code 1 if missed")
    parser.add_argument("-o", "--output", type=named, metavar="DIR", help="folder for results")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _methods() -> tuple[str, ...]:
    return tuple(kind.kind() for kind in METHODS if not kind.constraints and not kind.largest)


def run(args: argparse.Namespace) -> int:
    """Fit, write, and say what was reached."""
    folder = None if args.output is None else Path(args.output)
    if folder is not None:
        make_folder(folder)
    source, target = (
        named_element(args.source, args.source_element), named_element(args.target, args.element)
    )  # fmt: skip
    if folder is not None:
        for name in OUTPUTS:
            for read in (args.source, args.target):
                if is_same(folder / name, read):
                    raise InputError(f"{folder / name}: this would overwrite a file that is read")
    result = fit_shapes(
        source, target, columns=args.columns, rows=args.rows, layers=args.layers,
        adaptive=None if args.regular else args.adaptive, start=args.start, method=args.method,
        norm=args.norm, metric=args.metric, row_wise=args.row_wise, spacing=args.spacing,
        variables=args.variables, evaluations=args.evaluations, iterations=args.iterations,
        tolerance=args.tolerance, directions=args.directions, folder=folder, listener=_tell,
    )  # fmt: skip
    figures = result.to_json()
    if folder is not None:
        figures["files"] = write(result, folder, args.source, args.target)
    emit(figures, _text(result, folder), args.json)
    return 1 if args.tolerance is not None and result.rms > args.tolerance else 0


def named_element(path: str, element: int | None) -> str:
    """File with the number of one of its elements behind it, see `read_airfoil`.

    Examples
    --------
    >>> named_element("flap.dat", 2), named_element("flap.dat", None)
    ('flap.dat#2', 'flap.dat')
    """
    return path if element is None else f"{path}#{element}"


def _tell(record: Record) -> None:
    if record.kind == "refinement":
        note(f"{record.variables} variables, cost {record.cost:.3e}: knot {record.note}")


def _text(result: FitResult, folder: Path | None) -> str:
    net = " x ".join(str(count) for count in result.lattice.shape)
    lines = [
        f"RMS {result.rms:.3e}, largest error {result.max_error:.3e}"
        + (
            ""
            if result.kulfan_ratio is None
            else f", {result.kulfan_ratio:.3g} of Kulfan's tolerance"
        ),
        f"{result.variables} variables, {net} control points, "
        f"{result.evaluations} evaluations, {result.iterations} iterations, {result.seconds:.2f} s",
        f"ended: {result.ended}",
    ]
    if result.history[0]["rms"] <= NOTHING * extent(result.built.shape):
        lines.append("the source meets the target as it is: nothing to gain")
    return "\n".join([*lines, UNWRITTEN if folder is None else f"results in {folder}"])


def write(result: FitResult, folder: Path, source: str, target: str) -> list[str]:
    """Write everything about a fit; returns the names of the files."""
    figures = ["rms", "max_error", "variables"]
    files = write_common(folder, "fit", result.rest, result.lattice, result.study, figures)
    points = result.built.monitor.deformed(result.lattice)
    if not result.built.shape.flat:
        return [*files, "log.jsonl"]
    title = f"{Path(source).stem} fitted to {Path(target).stem}"
    files.append(write_contour(folder / "contour.dat", title, points))
    files += _section_plots(result, folder, points, (Path(source).stem, Path(target).stem))
    return [*files, "log.jsonl"]


def _section_plots(
    result: FitResult, folder: Path, deformed: Array, names: tuple[str, str]
) -> list[str]:
    built, dense = result.built, result.built.shape.dense
    target = built.spec.objective.contour(built.place)
    assert target is not None
    fine = target.sample(len(deformed))
    curves = {names[0]: dense, names[1]: fine, "fitted": deformed}
    net = result.lattice.control_points
    files = plots.save(plots.outlines(curves, net, names[1]), folder, "sections")
    x = deformed[:, 0]
    band = kulfan_tolerance(x)
    errors = built.monitor.errors(result.lattice)
    fig = plots.errors(x, errors, upper_side(dense), band)
    return files + plots.save(fig, folder, "errors")
