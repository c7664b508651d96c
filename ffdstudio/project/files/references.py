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
from ffdstudio.paths import exists, inside, is_file
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


MOST_FILES = 200_000  # of a case, with all its decomposed and written times


def files_of(path: Path) -> dict[str, Path]:
    """Files of a mesh by name, each relative to the mesh's own folder."""
    if not path.is_dir():
        return {path.name: path}
    inside = sorted(_below(path))
    found = {f"{path.name}/{p.relative_to(path).as_posix()}": p for p in inside}
    if not found:
        raise InputError(f"{path}: a folder without an OpenFOAM polyMesh in it is no mesh")
    return found


def _below(folder: Path) -> Iterator[Path]:
    """Files in the ``polyMesh`` folders of a case, but for hidden ones, which a crash may leave.

    A path out of a project may be that of a whole disk, or of ``/proc``: no link is followed
    but that of a mesh to another case, no other disk is entered, and there is an end.
    """
    seen, disk = 0, _disk_of(folder.resolve())
    for place, folders, files in os.walk(folder, followlinks=True):
        here = Path(place)
        folders[:] = [name for name in folders if _is_entered(here / name, disk)]
        seen += len(folders) + len(files)
        if seen > MOST_FILES:
            raise InputError(f"{folder}: more than {MOST_FILES:,} files are no OpenFOAM case")
        if "polyMesh" in here.relative_to(folder).parts:
            yield from (here / n for n in files if not n.startswith(".") and is_file(here / n))


def _is_entered(folder: Path, disk: int) -> bool:
    if folder.is_symlink():
        return folder.name == "polyMesh" and "polyMesh" not in folder.parent.parts
    return _disk_of(folder) == disk


def _disk_of(path: Path) -> int:
    try:
        return path.lstat().st_dev
    except OSError:
        return -1


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
    if _is_elsewhere(body.path):
        return f"{body.name}: {body.path} lies on another computer, which is not asked for it"
    if not exists(body.path):
        return f"{body.name}: {body.path} is missing"
    try:
        same = fingerprint(contents(body)) == body.sha256
    except InputError as error:
        return f"{body.name}: {error}"
    return None if same else f"{body.name}: {body.path} has changed since the project was saved"


def _is_elsewhere(path: Path) -> bool:
    """Whether Windows would log in at another computer to look at a path."""
    return os.name == "nt" and os.fspath(path).startswith(("\\\\", "//"))


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
                target = inside(folder, name)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
        except OSError as error:
            cause = (error.strerror or str(error)).lower()
            raise InputError(f"cannot lay out the packed mesh {body.name}: {cause}") from error
        yield Path(folder, next(iter(body.packed)).split("/", 1)[0])
