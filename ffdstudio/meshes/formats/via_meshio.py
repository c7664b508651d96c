"""Whatever meshio reads, and new files of some formats through it: never a morphed mesh's own.

1. meshio ends the process when one of its readers fails (``sys.exit``) and prints to stdout:
   both are caught here.
2. What it delivers is checked by `Mesh` like everything else.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a file through meshio; see `read_mesh`."""
    found = _read(path)
    try:
        points = _points(found.points)
        mesh = Mesh(points, _cells(found.cells), _sets(found), dimension=_dimension(found))
    except (TypeError, ValueError, AttributeError, IndexError) as error:
        raise InputError(f"{path}: what is in this file is no mesh: {error}") from error
    return mesh


NEW = {".vtu": "vtu", ".msh": "gmsh22", ".inp": "abaqus"}  # suffix -> meshio's name


def write_new(mesh: Mesh, path: Path) -> None:
    """Write a new file through meshio.

    Raises
    ------
    InputError
        If no such file can be made of this mesh.
    """
    import meshio

    name = NEW.get(path.suffix.lower())
    if name is None or not mesh.cells:
        raise InputError(f"{path}: no new file of this kind can be made of this mesh")
    try:
        with tempfile.TemporaryDirectory() as folder:
            draft = Path(folder) / path.name
            with contextlib.redirect_stdout(io.StringIO()):
                meshio.Mesh(mesh.points, mesh.cells).write(draft, file_format=name)
            data = draft.read_bytes()
    except (Exception, SystemExit) as error:
        raise InputError(f"{path}: meshio cannot write this mesh: {error}") from error
    write_bytes(path, data)


def _read(path: Path) -> Any:
    import meshio

    try:
        with (
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")
            return meshio.read(path)
    except SystemExit:
        raise InputError(f"{path}: no mesh format is known that reads this file") from None
    except Exception as error:
        raise InputError(f"{path}: {_cause(error, path)}") from error


def _cause(error: Exception, path: Path) -> str:
    """What meshio's reader stumbled over, in words for who does not know it."""
    words = str(error).strip().splitlines() or [type(error).__name__]
    if isinstance(error, UnicodeDecodeError) or "Could not deduce" in words[0]:
        return "no mesh format is known that reads this file"
    return f"this file cannot be read as a {path.suffix or 'mesh'} file: {words[0]}"


def _points(points: Any) -> Array:
    array = np.asarray(points, dtype=np.float64)
    flat = array.reshape(len(array), -1)[:, :3]
    return np.hstack([flat, np.zeros((len(flat), 3 - flat.shape[1]))])


def _dimension(found: Any) -> int:
    return 2 if np.shape(found.points)[-1] == 2 else 3


def _cells(blocks: Any) -> Cells:
    parts: dict[str, list[np.ndarray]] = {}
    for block in blocks:
        parts.setdefault(block.type, []).append(np.asarray(block.data))
    return {kind: np.concatenate(nodes) for kind, nodes in parts.items()}


def _sets(found: Any) -> Markers:
    markers: Markers = {}
    for name, by_block in found.cell_sets.items():
        cells: Cells = {}
        for block, chosen in zip(found.cells, by_block, strict=True):
            if chosen is not None and len(chosen):
                nodes = np.asarray(block.data)[chosen]
                old = cells.get(block.type)
                cells[block.type] = nodes if old is None else np.concatenate([old, nodes])
        markers[str(name)] = cells
    return markers
