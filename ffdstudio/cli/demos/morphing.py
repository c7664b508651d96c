"""The paper's morphing case (its figures 6 to 8): a mesh follows a few control points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ffdstudio.aliases import Array
from ffdstudio.cli.demos.common import FROZEN, Clock, copied_mesh, rendered, save_project
from ffdstudio.cli.morph import measured
from ffdstudio.cli.output import sized
from ffdstudio.engine import Lattice, embed
from ffdstudio.exchange import write_lattice
from ffdstudio.meshes import Mesh, read_mesh, write_mesh

DETAIL = (-0.35, 1.35, -0.5, 0.5)
# control points (i, j) of the 9x7 lattice and how far each one goes in y, in chords
MOVES = {
    (3, 4): 0.12,
    (4, 4): 0.12,
    (5, 4): 0.12,
    (3, 2): 0.05,
    (4, 2): 0.05,
    (6, 3): -0.06,
}


def run(folder: Path) -> dict[str, Any]:
    """Morph the sample mesh, write mesh, lattice, project and pictures, return the figures."""
    clock = Clock()
    source = copied_mesh(folder)
    mesh = clock("read", lambda: read_mesh(source))
    rest, current = lattices()
    embedding = clock("embed", lambda: embed(rest, mesh.points))
    clock("first deform (compiles once)", lambda: embedding.deform(current))
    points = clock("deform", lambda: embedding.deform(current))
    clock("write", lambda: write_mesh(mesh, folder / "naca0012_morphed.su2", points))
    write_lattice(folder / "naca0012.lattice.json", rest, current, frozen=FROZEN, units="chord")
    save_project(folder / "naca0012.ffdproj", source, rest, current)
    files = [source.name, "naca0012_morphed.su2", "naca0012.lattice.json", "naca0012.ffdproj"]
    files += clock("pictures", lambda: _pictures(folder, mesh, points, rest, current))
    figures = {"lattice": list(rest.shape), **measured(mesh, points)}
    return figures | {"cells": mesh.counts, "seconds": clock.seconds, "files": files}


def told(figures: dict[str, Any]) -> str:
    """One line for people."""
    return (
        f"NACA 0012, {figures['nodes']} nodes, lattice {sized(tuple(figures['lattice']))}: "
        f"{figures['moved']} nodes moved by up to {figures['max_displacement']:.4g} chords, "
        f"{figures['inverted']} inverted cells"
    )


def lattices() -> tuple[Lattice, Lattice]:
    """Cubic 9x7 lattice in the vicinity of the airfoil, at rest and with the moves of the case.

    Examples
    --------
    >>> rest, current = lattices()
    >>> int((rest.control_points != current.control_points).any(axis=-1).sum())
    6
    """
    rest = Lattice.box([-0.3, -0.4], [1.3, 0.4], shape=(9, 7), degrees=(3, 3))
    points = rest.control_points.copy()
    for index, step in MOVES.items():
        points[index][1] += step
    return rest, rest.moved(points)


def _pictures(
    folder: Path, mesh: Mesh, points: Array, rest: Lattice, current: Lattice
) -> list[str]:
    """Draw figures 6, 7 and 8; return the names of the files."""

    def draw_all() -> list[str]:
        from ffdstudio.cli.pictures import draw

        (x0, y0, _), (x1, y1, _) = mesh.bounds.tolist()
        room = 0.03 * max(x1 - x0, y1 - y0)
        domain = (x0 - room, x1 + room, y0 - room, y1 + 4 * room)  # the title goes above
        size = f"{len(mesh.points)} nodes, {sum(mesh.counts.values())} cells"
        draw(folder / "figure6_domain.png", mesh, mesh.points, domain, f"Mesh domain: {size}")
        net = f"lattice {sized(rest.shape)}, cubic"
        title = f"NACA 0012 and its {net}, at rest"
        draw(folder / "figure7_lattice.png", mesh, mesh.points, DETAIL, title, rest)
        title = f"Deformed: {len(MOVES)} control points moved"
        draw(folder / "figure8_deformed.png", mesh, points, DETAIL, title, current, rest)
        return ["figure6_domain.png", "figure7_lattice.png", "figure8_deformed.png"]

    return rendered(draw_all)
