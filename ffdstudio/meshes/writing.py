"""Writing a mesh: its own file with other coordinates, or a new file in another format."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

from numpy.typing import ArrayLike

from ffdstudio.errors import InputError
from ffdstudio.meshes.compressed import inner, is_packed, write_packed
from ffdstudio.meshes.formats import FORMATS, candidates, suffix_of
from ffdstudio.meshes.mesh import Mesh, MeshWarning
from ffdstudio.meshes.topology import dimension
from ffdstudio.paths import as_path, is_folder

SURFACES = ("stl", "obj", "ply", "off")


def write_mesh(mesh: Mesh, path: str | os.PathLike[str], points: ArrayLike | None = None) -> None:
    """Write the file that a mesh came from, with its coordinates or other ones.

    The original file is the template: only the coordinates of nodes that moved change, and
    without a change the file has the same bytes. A path with the suffix of another format
    gets a new file instead, and a `MeshWarning` says what it loses (see `losses`).

    Parameters
    ----------
    mesh : Mesh
        As read by `read_mesh`.
    path : path-like
        Where to write; an existing file is replaced atomically.
    points : array_like, optional
        (n, 3) coordinates; by default those of `mesh`.

    Raises
    ------
    InputError
        If the file cannot be written or the coordinates do not fit the format.

    Examples
    --------
    >>> import tempfile
    >>> from ffdstudio import read_mesh
    >>> from ffdstudio.samples import sample
    >>> mesh = read_mesh(sample("naca0012.su2"))
    >>> path = Path(tempfile.mkdtemp()) / "moved.su2"
    >>> write_mesh(mesh, path, points=mesh.points + [0, 0.25, 0])
    >>> float(read_mesh(path).points[0, 1] - mesh.points[0, 1])
    0.25
    """
    target = as_path(path)
    if not hasattr(mesh, "template"):
        raise InputError(f"a mesh is needed, got {mesh!r}")
    if points is not None:
        mesh = mesh.with_points(points)
    if is_packed(target) and candidates(target):
        write_packed(mesh.template, target, partial(_write, mesh))
    else:
        _write(mesh, target)


def _write(mesh: Mesh, target: Path) -> None:
    if mesh.template is not None and _same_format(mesh, target):
        mesh.template.write(target, mesh.points)
        return
    _new_format(target)(mesh, target)
    for loss in losses(mesh, target):
        warnings.warn(f"{target.name}: {loss}", MeshWarning, stacklevel=2)


def refuse_unwritable(mesh: Mesh, path: str | os.PathLike[str]) -> None:
    """Raise if a mesh cannot be written to a path: before the work, not after it.

    Raises
    ------
    InputError
        If the format of the mesh can only be read, or no such file can be made.

    Examples
    --------
    >>> refuse_unwritable(Mesh([[0, 0, 0]], {"vertex": [[0]]}), "a.su2")
    """
    target = as_path(path)
    if mesh.template is not None and _same_format(mesh, target):
        return
    if mesh.path is not None and not any(row.new for row in candidates(target)):
        known = ", ".join(row.suffixes[0] for row in FORMATS if row.new)
        if suffix_of(inner(mesh.path)) == suffix_of(inner(target)):
            raise InputError(
                f"{mesh.path}: a {suffix_of(mesh.path) or 'mesh'} file can only be read; write one "
                f"of {known}"
            )
    _new_format(target)


def losses(mesh: Mesh, path: str | os.PathLike[str]) -> list[str]:
    """List what is lost when a mesh is written to that path; empty if it is the mesh's own format.

    Examples
    --------
    >>> losses(Mesh([[0, 0, 0]], {"vertex": [[0]]}), "a.su2")
    ['a new file is made: comments, numbering and settings of the original are lost']
    """
    target = as_path(path)
    if mesh.template is not None and _same_format(mesh, target):
        return []
    found = ["a new file is made: comments, numbering and settings of the original are lost"]
    row = next((row for row in candidates(target) if row.new), None)
    name = row.name if row else ""
    volume = sum(n for kind, n in mesh.counts.items() if dimension(kind) == 3)
    if name in SURFACES and volume:
        found.append(f"only the surface is written, {volume} volume cells are lost")
    if name == "stl":
        found.append("coordinates are rounded to single precision (float32)")
    kept = mesh.boundaries if name == "su2" else []
    gone = [marker for marker in mesh.markers if marker not in kept]
    if gone:
        found.append(f"these markers are lost: {', '.join(gone)}")
    return found


def _same_format(mesh: Mesh, target: Path) -> bool:
    if mesh.format == "openfoam" and (is_folder(target) or not candidates(target)):
        return True
    if mesh.path is not None and suffix_of(inner(mesh.path)) == suffix_of(inner(target)):
        return True
    if mesh.format == "ugrid":  # its suffix tells byte order and type
        return False
    return any(row.name == mesh.format for row in candidates(target))


def _new_format(target: Path) -> Callable[[Mesh, Path], None]:
    for row in candidates(target):
        if row.new:
            write: Callable[[Mesh, Path], None] = row.load(row.new).write_new
            return write
    known = ", ".join(row.suffixes[0] for row in FORMATS if row.new)
    raise InputError(
        f"{target}: a mesh of another format can be written as {known}, not {target.suffix!r}"
    )
