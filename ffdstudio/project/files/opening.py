"""Reading a mesh for the document: work for a worker, from a path to all that is needed."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.exchange.morphed import BOXES
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.formats.openfoam import without_folder
from ffdstudio.meshes.planes import planes_of
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.meshes.ways import Way
from ffdstudio.project.commands import OpenMesh
from ffdstudio.project.files import references
from ffdstudio.project.files.records import BodyRecord
from ffdstudio.project.running import Progress, no_progress
from ffdstudio.project.view.surface import DisplaySurface, surface_of


@dataclass(frozen=True, eq=False)
class Opened:
    """A mesh that was read: the command that adds it, and what to draw of it."""

    command: OpenMesh
    surface: DisplaySurface


def open_body(path: str | os.PathLike[str], progress: Progress = no_progress) -> Opened:
    """Read a mesh to be added as a new body named after its file.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    source = Path(os.path.abspath(path))  # noqa: PTH100 - keeps symbolic links as they are
    return read_record(BodyRecord(source.stem, source, sha256=hash_of(source)), progress)


def read_record(record: BodyRecord, progress: Progress = no_progress) -> Opened:
    """Read the mesh of a stored body, from the disk or out of the project."""
    name = record.path.name
    with references.on_disk(record) as path:
        mesh = read_mesh(path, lambda fraction: progress(0.8 * fraction, f"reading {name}"))
        if record.packed is not None:
            mesh = without_folder(mesh)
    progress(0.8, f"preparing {name}")
    surface = surface_of(mesh)
    planes_of(mesh)  # known from now on: an edit asks for them
    wall_markers(mesh)
    return Opened(command_of(record, mesh), surface)


def command_of(record: BodyRecord, mesh: Mesh) -> OpenMesh:
    """Return the command that adds a stored body."""
    hidden, boxes = record.settings.get("hidden_markers"), record.settings.get("boxes")
    follows = record.settings.get("follows")
    names = [name for name in hidden if isinstance(name, str)] if isinstance(hidden, list) else []
    return OpenMesh(
        path=os.fspath(record.path),
        sha256=record.sha256,
        name=record.name,
        visible=record.visible,
        colour=record.colour,
        hidden_markers=tuple(name for name in names if name in mesh.markers),
        boxes=boxes if isinstance(boxes, str) and boxes in BOXES else "update",
        follows=follows if isinstance(follows, str) and follows in set(Way) else Way.LATTICE,
        mesh=mesh,
        packed=record.packed,
    )


def load(command: OpenMesh) -> OpenMesh:
    """Return the command with its mesh read and its hash checked: what a replay needs.

    Raises
    ------
    InputError
        If the mesh is missing, cannot be read or is not the one of the journal.
    """
    if command.sha256 and hash_of(Path(command.path)) != command.sha256:
        raise InputError(f"{command.path} is not the mesh it was: its content has changed")
    return replace(command, mesh=read_mesh(command.path))


def hash_of(path: Path) -> str:
    """SHA-256 of a mesh on the disk."""
    return references.fingerprint(references.contents(BodyRecord("", path)))
