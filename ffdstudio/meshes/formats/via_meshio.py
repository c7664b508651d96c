"""Whatever meshio reads, and new files of some formats through it: never a morphed mesh's own.

1. meshio works in a process of its own, with limits of time and memory (see `confined`): it may
   hang, print or end that process, and a file may lead it astray, without harm to this one.
2. What it delivers is checked by `Mesh` like everything else.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import AnyArray, Array
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.confined.asking import ask
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.mesh import Markers, Mesh
from ffdstudio.meshes.topology import Cells
from ffdstudio.paths import is_file


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a file through meshio; see `read_mesh`."""
    unpacked = [] if is_file(path) else [np.frombuffer(data, dtype=np.uint8)]  # of a .gz file
    head = {"do": "read", "path": str(path.absolute())}
    said, arrays = ask(path, head, unpacked, _size(path, data), progress)
    try:
        points = arrays[0]
        blocks = [(kind, arrays[number]) for kind, number in said["blocks"]]
        dimension = 2 if points.shape[-1] == 2 else 3
        sets = _sets(said["sets"], blocks, arrays)
        return Mesh(_points(points), _cells(blocks), sets, dimension=dimension)
    except (TypeError, ValueError, AttributeError, IndexError, KeyError) as error:
        raise InputError(f"{path}: what is in this file is no mesh: {error}") from error


NEW = {".vtu": "vtu", ".msh": "gmsh22", ".inp": "abaqus"}  # suffix -> meshio's name


def write_new(mesh: Mesh, path: Path) -> None:
    """Write a new file through meshio.

    Raises
    ------
    InputError
        If no such file can be made of this mesh.
    """
    name = NEW.get(path.suffix.lower())
    if name is None or not mesh.cells:
        raise InputError(f"{path}: no new file of this kind can be made of this mesh")
    arrays: list[AnyArray] = [mesh.points, *mesh.cells.values()]
    blocks = [(kind, number) for number, kind in enumerate(mesh.cells, start=1)]
    size = sum(array.nbytes for array in arrays)
    head = {"do": "write", "format": name, "blocks": blocks}
    _, (content,) = ask(path, head, arrays, size, lambda fraction: None)
    write_bytes(path, content.tobytes())


def _size(path: Path, data: bytes) -> int:
    """Bytes of a file and of those beside it that have its name and another suffix."""
    try:
        beside = [p for p in path.parent.glob("*") if p.stem == path.stem and p.is_file()]
        return max(len(data), sum(p.stat().st_size for p in beside))
    except OSError:
        return len(data)


def _points(points: AnyArray) -> Array:
    array = np.asarray(points, dtype=np.float64)
    flat = array.reshape(len(array), -1)[:, :3]
    return np.hstack([flat, np.zeros((len(flat), 3 - flat.shape[1]))])


def _cells(blocks: list[tuple[str, AnyArray]]) -> Cells:
    parts: dict[str, list[AnyArray]] = {}
    for kind, nodes in blocks:
        parts.setdefault(kind, []).append(nodes)
    return {kind: np.concatenate(nodes) for kind, nodes in parts.items()}


def _sets(
    sets: dict[str, Any], blocks: list[tuple[str, AnyArray]], arrays: list[AnyArray]
) -> Markers:
    markers: Markers = {}
    for name, by_block in sets.items():
        cells: Cells = {}
        for (kind, nodes), number in zip(blocks, by_block, strict=True):
            if number is not None and len(arrays[number]):
                chosen = nodes[arrays[number]]
                old = cells.get(kind)
                cells[kind] = chosen if old is None else np.concatenate([old, chosen])
        markers[name] = cells
    return markers
