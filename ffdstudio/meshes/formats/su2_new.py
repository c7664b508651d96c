"""A new SU2 file from any mesh, for meshes that come from another format."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats.patch import shortest
from ffdstudio.meshes.formats.su2 import CODES
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import Cells, dimension

NUMBERS = {name: number for number, name in CODES.items()}


def write_new(mesh: Mesh, path: Path) -> None:
    """Write a mesh with its boundary markers as SU2.

    Raises
    ------
    InputError
        If it has cells that SU2 does not know.
    """
    cells = {kind: n for kind, n in mesh.cells.items() if dimension(kind) == mesh.dimension}
    unknown = [kind for kind in cells if kind not in NUMBERS]
    if unknown or not cells:
        what = ", ".join(unknown) or "no volume cells of its own"
        raise InputError(f"{path}: SU2 cannot hold this mesh: it has {what}")
    write_bytes(path, "\n".join([*_lines(mesh, cells), ""]).encode())


def _lines(mesh: Mesh, cells: Cells) -> Iterator[str]:
    yield f"NDIME= {mesh.dimension}"
    yield f"NELEM= {sum(map(len, cells.values()))}"
    yield from _elements(cells)
    yield f"NPOIN= {len(mesh.points)}"
    for point in mesh.points[:, : mesh.dimension].tolist():
        yield " ".join(shortest(point))
    boundaries = {name: _boundary(mesh, name) for name in mesh.boundaries}
    boundaries = {name: found for name, found in boundaries.items() if found}
    yield f"NMARK= {len(boundaries)}"
    for name, found in boundaries.items():
        yield f"MARKER_TAG= {name.replace(' ', '_')}"
        yield f"MARKER_ELEMS= {sum(map(len, found.values()))}"
        yield from _elements(found)


def _boundary(mesh: Mesh, name: str) -> Cells:
    """Elements of a marker that SU2 takes for a boundary: one dimension below the cells."""
    return {
        kind: nodes
        for kind, nodes in mesh.markers[name].items()
        if kind in NUMBERS and dimension(kind) == mesh.dimension - 1
    }


def _elements(cells: Cells) -> Iterator[str]:
    for kind, nodes in cells.items():
        for row in nodes.tolist():
            yield " ".join(map(str, [NUMBERS[kind], *row]))
