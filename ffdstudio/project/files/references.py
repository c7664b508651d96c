"""How a project refers to meshes: relative POSIX paths, the files behind them, their hash.

A mesh is one file, or (OpenFOAM) a case folder of which only the ``polyMesh`` folders count.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.project.files.records import BodyRecord


def relative(path: Path, folder: Path) -> str:
    """Path as stored: relative to the project's folder, with ``/`` on every system.

    Examples
    --------
    >>> relative(Path("/work/meshes/a.su2"), Path("/work/projects"))
    '../meshes/a.su2'
    """
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # another drive on Windows
        return path.as_posix()


def absolute(stored: str, folder: Path) -> Path:
    """Inverse of `relative`."""
    return Path(os.path.normpath(folder / stored))


def files_of(path: Path) -> dict[str, Path]:
    """Files of a mesh by name, each relative to the mesh's own folder."""
    if not path.is_dir():
        return {path.name: path}
    files = (p for p in path.rglob("polyMesh/**/*") if p.is_file())
    inside = sorted(p for p in files if not p.name.startswith("."))  # what a crash has left
    found = {f"{path.name}/{p.relative_to(path).as_posix()}": p for p in inside}
    if not found:
        raise InputError(f"{path}: a folder without an OpenFOAM polyMesh in it is no mesh")
    return found


def contents(body: BodyRecord) -> dict[str, bytes]:
    """Files of a body by name, from the project or from the disk."""
    if body.packed is not None:
        return body.packed
    return {name: read_bytes(path) for name, path in files_of(body.path).items()}


def fingerprint(files: dict[str, bytes]) -> str:
    """SHA-256 of a mesh: of the file, or of the names and hashes of several.

    Examples
    --------
    >>> fingerprint({"a.su2": b"abc"})[:16]
    'ba7816bf8f01cfea'
    """
    if len(files) == 1:
        return hashlib.sha256(*files.values()).hexdigest()
    total = hashlib.sha256()
    for name in sorted(files):
        inner = name.split("/", 1)[-1]  # the case folder itself may be renamed
        total.update(f"{inner}\0{hashlib.sha256(files[name]).hexdigest()}\n".encode())
    return total.hexdigest()


def problem_with(body: BodyRecord) -> str | None:
    """Say what is wrong with the mesh a body refers to; None if nothing is."""
    if body.packed is not None:
        if fingerprint(body.packed) != body.sha256:
            return f"{body.name}: the mesh packed into the project is not the one saved"
        return None
    if not body.path.exists():
        return f"{body.name}: {body.path} is missing"
    try:
        same = fingerprint(contents(body)) == body.sha256
    except InputError as error:
        return f"{body.name}: {error}"
    return None if same else f"{body.name}: {body.path} has changed since the project was saved"


@contextmanager
def on_disk(body: BodyRecord) -> Iterator[Path]:
    """Path from which the body's mesh can be read; a packed one is laid out for the while."""
    if body.packed is None:
        yield body.path
        return
    with ExitStack() as stack:
        try:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="ffdstudio-"))
            for name, data in body.packed.items():
                target = Path(folder, name)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
        except OSError as error:
            cause = (error.strerror or str(error)).lower()
            raise InputError(f"cannot lay out the packed mesh {body.name}: {cause}") from error
        yield Path(folder, next(iter(body.packed)).split("/", 1)[0])
