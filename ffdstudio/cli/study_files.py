"""What `fit` and `optimize` leave in their folder."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.exchange import write_lattice
from ffdstudio.files import write_bytes
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.ways import Way
from ffdstudio.optimize import plots
from ffdstudio.optimize.runs.record import RunHistory
from ffdstudio.project import Project


def write_common(
    folder: Path,
    name: str,
    rest: Lattice,
    current: Lattice,
    history: RunHistory,
    figures: list[str],
    meshes: Sequence[Mesh] = (),
    ways: Sequence[Way] = (),
) -> list[str]:
    """Lattice, project, CSV and convergence plots; returns the names of the files.

    The project refers to the meshes as they were, for its lattice deforms them, in their ways.
    """
    write_lattice(folder / f"{name}.lattice.json", rest, current)
    project = Project()
    project.add_lattice(name, rest, current)
    for mesh, way in zip_longest(meshes, ways, fillvalue=Way.LATTICE):
        if isinstance(mesh, Mesh) and mesh.path is not None:
            project.add_mesh(mesh.path).settings["follows"] = str(way)
    project.save(folder / f"{name}.ffdproj")
    write_bytes(folder / "history.csv", plots.table(history))
    written = [f"{name}.lattice.json", f"{name}.ffdproj", "history.csv"]
    for figure in figures:
        if np.isfinite(history.column(figure)).any():
            fig = plots.convergence({name: history}, figure)
            written += plots.save(fig, folder, f"convergence_{figure}")
    return written


def write_contour(path: Path, title: str, points: Array) -> str:
    """Airfoil file in Selig's order, with decimals that give the same floats."""
    lines = [title, *(f"{x!r} {y!r}" for x, y in points[:, :2].tolist())]
    write_bytes(path, ("\n".join(lines) + "\n").encode())
    return path.name
