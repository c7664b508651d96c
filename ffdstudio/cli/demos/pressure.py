"""The pressures of the RAE 2822 by the panel method; the volume mesh follows the same lattice.

1. The lattice reaches into the field and its outer layers are frozen, so surface and volume
   are moved by one map; two rows of control points are free.
2. All lattices have 40 variables at the end, and all studies the same budget. Costs are
   compared after the flow and adjoint solves of the adaptive study; a static study that has
   converged before is taken at its end.
3. The cost sees the surface alone: a column that barely reaches it may run away and tear the
   mesh. So the inverted cells of each study are told beside its cost.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.cli.demos.common import FROZEN, Clock, copied_mesh, rendered, save_project
from ffdstudio.cli.morph import measured
from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.spaces import in_space_of
from ffdstudio.exchange import write_lattice
from ffdstudio.files import write_bytes
from ffdstudio.meshes import Mesh, inverted, read_mesh, write_mesh
from ffdstudio.optimize import plots
from ffdstudio.optimize.build.build import Built, build
from ffdstudio.optimize.build.place import Pair, Place, given
from ffdstudio.optimize.objectives.flow import FlowSpec
from ffdstudio.optimize.runs.record import Record, RunHistory
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.samples import sample

ANGLE = 2.0  # degrees
VARIABLES = 40
ADAPTIVE, TARGET = "adaptive", "RAE 2822, the target"
LOWER, UPPER = (-0.3, -0.15), (1.3, 0.15)
START = 9  # columns of the adaptive lattice
NOSE, TAIL = -0.01, 1.01  # outermost knots of the cosine columns
DETAIL = (-0.35, 1.35, -0.5, 0.5)


def run(folder: Path, evaluations: int = 60) -> dict[str, Any]:
    """Match the pressures, let the mesh follow, write everything, return the figures."""
    clock = Clock()
    source = copied_mesh(folder)
    mesh, rests = read_mesh(source), lattices()
    built = {name: study(mesh, rest, evaluations, name == ADAPTIVE) for name, rest in rests.items()}
    studies = {name: clock(name, one.study.run) for name, one in built.items()}
    one, current = built[ADAPTIVE], studies[ADAPTIVE].lattice(-1)
    rest = in_space_of(one.rest, current)
    files = _write(folder, source, mesh, rest, current)
    points = embed(rest, mesh.points).deform(current)
    figures = {**compared(studies, rests, mesh), "lattice": list(rest.shape)}
    files += _convergence(folder, studies, figures["studies"])
    files += _pressures(folder, one, embed(rest, one.shape.points).deform(current))
    files += clock("pictures", partial(_picture, folder, mesh, points, current, figures))
    return figures | measured(mesh, points) | {"seconds": clock.seconds, "files": files}


def told(figures: dict[str, Any]) -> str:
    """One line for people."""
    best, rows = figures["best_static"], figures["studies"]
    return (
        f"Cp of the RAE 2822 at {ANGLE:g} degrees (inviscid), {figures['solves']} solves: cost "
        f"over the first {rows[ADAPTIVE]['cost_ratio']:.2e} adaptively, {figures['nodes']} nodes "
        f"follow, {figures['inverted']} inverted cells; best static lattice ({best}) "
        f"{rows[best]['cost_ratio']:.2e}, {rows[best]['inverted']} inverted cells"
    )


# ---- the lattices --------------------------------------------------------------------------


def lattice(knots: list[float]) -> Lattice:
    """Cubic lattice in the vicinity of the airfoil with inner knots in x.

    Examples
    --------
    >>> lattice([0.0, 0.5, 1.0]).shape
    (7, 6)
    """
    box = Lattice.box(LOWER, UPPER, shape=(4, 6), degrees=(3, 3))
    return box.insert_knots(0, knots)


def lattices() -> dict[str, Lattice]:
    """Two that stay as they are, and the one that the adaptive study begins with."""
    count = VARIABLES // 2  # in two rows; the four columns of a box without knots are frozen
    share = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, count)))
    return {
        "equally spaced": lattice(_inner(count)),
        "cosine": lattice((NOSE + (TAIL - NOSE) * share).tolist()),
        ADAPTIVE: lattice(_inner(START - 4)),
    }


def _inner(count: int) -> list[float]:
    return list(np.linspace(LOWER[0], UPPER[0], count + 2)[1:-1].tolist())


# ---- the studies ---------------------------------------------------------------------------


def study(mesh: Mesh, rest: Lattice, evaluations: int, adaptive: bool) -> Built:
    """The study of one lattice, built."""
    spec = StudySpec(
        shape=ShapeSpec(source=given("mesh"), marker="airfoil"),
        lattice=LatticeSpec(file=given("lattice")),
        variables=VariablesSpec(frozen=FROZEN),
        objective=FlowSpec(angles=(ANGLE,), target=str(sample("rae2822.dat"))),
        refinement=RefinementSpec(variables=VARIABLES, slope=0.8) if adaptive else None,
        budget=BudgetSpec(evaluations=evaluations),
    )
    objects = {"mesh": mesh, "lattice": Pair(rest, rest)}
    return build(spec, Place(objects=objects))


def compared(
    studies: dict[str, RunHistory], rests: dict[str, Lattice], mesh: Mesh
) -> dict[str, Any]:
    """Each study after as many solves as the adaptive one has used, and the best static one."""
    limit = solves(studies[ADAPTIVE].iterates[-1])
    rows = {name: _row(history, limit, rests[name], mesh) for name, history in studies.items()}
    static = [name for name in rows if name != ADAPTIVE]
    best = min(static, key=lambda name: rows[name]["cost_ratio"])
    return {"solves": limit, "studies": rows, "best_static": best}


def _row(history: RunHistory, limit: int, rest: Lattice, mesh: Mesh) -> dict[str, Any]:
    within = [record for record in history.iterates if solves(record) <= limit]
    current = history.lattice(len(within) - 1)
    points = embed(in_space_of(rest, current), mesh.points).deform(current)
    return {
        "cost_ratio": within[-1].cost / within[0].cost,
        "variables": within[-1].variables,
        "solves": solves(within[-1]),
        "inverted": inverted(mesh, points).count,
    }


def solves(record: Record) -> int:
    """Flow and adjoint solves up to a record."""
    return record.flow + record.adjoint


# ---- the files -----------------------------------------------------------------------------


def _write(folder: Path, source: Path, mesh: Mesh, rest: Lattice, current: Lattice) -> list[str]:
    write_mesh(mesh, folder / "pressure_morphed.su2", embed(rest, mesh.points).deform(current))
    write_lattice(folder / "pressure.lattice.json", rest, current, frozen=FROZEN, units="chord")
    save_project(folder / "pressure.ffdproj", source, rest, current)
    return [source.name, "pressure_morphed.su2", "pressure.lattice.json", "pressure.ffdproj"]


def _convergence(folder: Path, studies: dict[str, RunHistory], rows: dict[str, Any]) -> list[str]:
    """Costs of the studies, named with the cells that each would invert: see 3."""
    named = {f"{name}, {_cells(rows[name]['inverted'])}": h for name, h in studies.items()}
    write_bytes(folder / "pressure_adaptive.csv", plots.table(studies[ADAPTIVE]))
    files = plots.save(plots.convergence(named), folder, "pressure_convergence")
    return [*files, "pressure_adaptive.csv"]


def _cells(count: int) -> str:
    return "no inverted cell" if count == 0 else f"{count} inverted cells"


def _pressures(folder: Path, built: Built, end: Array) -> list[str]:
    flow = built.task.objective
    begin, reached = (flow.pressures(xyz)[f"{ANGLE:g}"] for xyz in (built.shape.points, end))
    x = begin["shape"][0]
    curves = {
        "NACA 0012": begin["shape"],
        TARGET: (x, begin["target"][1]),
        "adaptive lattice": (x, reached["shape"][1]),
    }
    return plots.save(plots.pressures(curves, TARGET), folder, "pressure_cp")


def _picture(
    folder: Path, mesh: Mesh, points: Array, current: Lattice, figures: dict[str, Any]
) -> list[str]:
    def draw_it() -> list[str]:
        from ffdstudio.cli.pictures import draw

        rows, best = figures["studies"], figures["best_static"]
        title = (
            f"Cp of the RAE 2822, {current.shape[0]} columns where the cost asked: "
            f"{_cells(rows[ADAPTIVE]['inverted'])} ({best} lattice: {rows[best]['inverted']})"
        )
        draw(folder / "pressure_mesh.png", mesh, points, DETAIL, title, current)
        return ["pressure_mesh.png"]

    return rendered(draw_it)
