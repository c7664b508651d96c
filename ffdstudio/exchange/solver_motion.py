"""Motion of walls for a solver's own mesh deformation: SU2_DEF and OpenFOAM's moveDynamicMesh.

1. SU2 (``DV_KIND= SURFACE_FILE``, ``DV_FILENAME``): a line for each node with its number and its
   new coordinates, two in a plane, blanks between.
2. OpenFOAM (``0/pointDisplacement``): a displacement for each point of a moving patch, in the
   patch's own order. Patches that stay are fixed, planes in which points slide keep the type
   that their patch has, flat ones beside moving ones slip.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.files import write_bytes
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.formats.openfoam import patches_of
from ffdstudio.meshes.formats.su2 import zone_count

CONSTRAINED = (
    "empty", "wedge", "symmetry", "symmetryPlane", "cyclic", "cyclicAMI", "cyclicACMI",
    "cyclicSlip", "processor", "processorCyclic", "nonuniformTransformCyclic",
)  # fmt: skip
HEADER = """FoamFile
{
    version     2.0;
    format      ascii;
    class       pointVectorField;
    object      pointDisplacement;
}

dimensions      [0 1 0 0 0 0 0];

internalField   uniform (0 0 0);

boundaryField
{
"""


def write_solver_motion(
    mesh: Mesh,
    path: str | os.PathLike[str],
    points: Array,
    walls: Collection[str],
    slipping: Collection[str] = (),
) -> None:
    """Write where walls go, for the solver of the mesh's format.

    Parameters
    ----------
    mesh : Mesh
        Undeformed, read from an SU2 file or an OpenFOAM case.
    path : path-like
        Where to write; an existing file is replaced atomically, missing folders are made.
    points : numpy.ndarray
        (n, 3) its nodes as deformed; those of the walls count.
    walls : collection of str
        Markers that move.
    slipping : collection of str
        Markers in which points slide though the file calls them ordinary (OpenFOAM).

    Raises
    ------
    InputError
        If the format has no such file, a marker is unknown, or it cannot be written.
    """
    if not walls:
        raise InputError(f"{path}: no wall moves, so there is no motion to write")
    mesh.marker_nodes(*walls)
    text = _su2(mesh, points, walls) if mesh.format == "su2" else None
    if mesh.format == "openfoam":
        text = _openfoam(mesh, points, walls, slipping)
    if text is None:
        raise InputError(
            f"{mesh.path or 'the mesh'}: a motion for the solver's own deformer can be written for "
            "SU2 and OpenFOAM meshes"
        )
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make {Path(path).parent}: {error.strerror}") from None
    write_bytes(path, text.encode("utf-8"))


def _su2(mesh: Mesh, points: Array, walls: Collection[str]) -> str:
    if zone_count(mesh) > 1:
        raise InputError(
            f"{mesh.path}: SU2 reads the motion of one zone only, this file has {zone_count(mesh)}"
        )
    nodes = mesh.marker_nodes(*walls)
    rows = points[nodes, : mesh.dimension].tolist()
    lines = [f"{n} {_spaced(row)}" for n, row in zip(nodes.tolist(), rows, strict=True)]
    return "\n".join([*lines, ""])


def _openfoam(mesh: Mesh, points: Array, walls: Collection[str], slipping: Collection[str]) -> str:
    step, parts = points - mesh.points, [HEADER]
    for patch in patches_of(mesh):
        if patch.name in walls:
            rows = "\n".join(f"({_spaced(row)})" for row in step[patch.nodes].tolist())
            values = f"{len(patch.nodes)}\n(\n{rows}\n)"
            entry = f"type fixedValue;\nvalue nonuniform List<vector>\n{values};"
        elif patch.type in CONSTRAINED:
            entry = f"type {patch.type};"
        elif patch.name in slipping:
            entry = "type slip;"
        else:
            entry = "type fixedValue;\nvalue uniform (0 0 0);"
        parts.append(f"{patch.name}\n{{\n{entry}\n}}\n")
    return "".join([*parts, "}\n"])


def _spaced(row: Sequence[float]) -> str:
    return " ".join(repr(value + 0.0) for value in row)
