"""Writing deformed bodies: the same function for the window and for a replay."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.exchange.morphed import write_morphed
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.formats.openfoam import folder_of
from ffdstudio.paths import is_same
from ffdstudio.project.model import Body, LatticeItem
from ffdstudio.project.running import Progress, no_progress
from ffdstudio.project.walls import deformed_body


@dataclass(frozen=True)
class Written:
    """A body that was written: its name, the file, how many nodes moved, what was lost."""

    name: str
    path: Path
    nodes: int
    moved: int
    losses: tuple[str, ...] = ()


def overwrites(body: Body, path: str | os.PathLike[str]) -> bool:
    """Whether a mesh written to a path takes the place of the one that a body came from.

    A mesh of OpenFOAM is its folder ``polyMesh``, by whatever name one gets there: the case, a
    ``.foam`` file in it, the folder itself.
    """
    if is_same(body.path, path):
        return True
    return body.mesh.format == "openfoam" and is_same(folder_of(body.path), folder_of(Path(path)))


def write_body(
    body: Body,
    lattices: Sequence[LatticeItem],
    path: str | os.PathLike[str],
    progress: Progress = no_progress,
) -> Written:
    """Write a body as the lattices deform it; FFD boxes in its file as `Body.boxes` says.

    Raises
    ------
    InputError
        If the file cannot be written, or a plane mesh would leave its plane.
    """
    mesh, target = body.mesh, Path(path)
    points = deformed_body(body, lattices, progress)
    if mesh.dimension == 2 and (points[:, 2] != mesh.points[:, 2]).any():
        raise InputError(f"{body.name} is a 2D mesh, but its lattice moves it in z")
    progress(0.8, f"writing {target.name}")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MeshWarning)
        motions = [(item.rest, item.current) for item in lattices if item.deformed]
        write_morphed(mesh, target, points, motions, body.boxes)
    losses = tuple(str(w.message) for w in caught if issubclass(w.category, MeshWarning))
    moved = int((points != mesh.points).any(axis=1).sum())
    return Written(body.name, target, len(points), moved, losses)
