"""Writing a morphed mesh whose file also holds FFD boxes: the boxes follow the shape.

Left as they were, SU2_DEF would move the shape back to them.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange import su2
from ffdstudio.meshes import Mesh, write_mesh
from ffdstudio.meshes.formats.su2 import ffd_sections, replace_ffd_sections

BOXES = ("update", "strip", "keep")


def write_morphed(
    mesh: Mesh,
    path: str | os.PathLike[str],
    points: Array,
    motions: Sequence[tuple[Lattice, Lattice]],
    boxes: str = "update",
) -> None:
    """Write a mesh with deformed points, as `write_mesh` does, and see to the boxes in its file.

    Parameters
    ----------
    mesh : Mesh
        The mesh before.
    path : path-like
        Where to write; an existing file is replaced atomically.
    points : numpy.ndarray
        (n, 3) its nodes after.
    motions : sequence of (Lattice, Lattice)
        What moved them, in order: lattices at rest and deformed.
    boxes : {"update", "strip", "keep"}
        FFD boxes inside an SU2 file follow the shape, are dropped, or stay with a warning.

    Raises
    ------
    InputError
        If the file cannot be written or the points do not fit its format.
    """
    sections = ffd_sections(mesh)
    if sections and boxes != "keep":
        follow = [] if boxes == "strip" else sections
        new = [_follow(section, mesh, points, motions) for section in follow]
        mesh = replace_ffd_sections(mesh, new)
    write_mesh(mesh, path, points)


def has_boxes(mesh: Mesh) -> bool:
    """Whether the file of a mesh holds FFD boxes."""
    return bool(ffd_sections(mesh))


def _follow(
    section: bytes, mesh: Mesh, points: Array, motions: Sequence[tuple[Lattice, Lattice]]
) -> bytes:
    try:
        return su2.follow(section, mesh, points, motions)
    except InputError as error:
        cause = str(error).removeprefix("the mesh: ")
        raise InputError(
            f"{mesh.path}: an FFD box in this file cannot follow the shape: {cause}; "
            "keep or strip the boxes (--boxes keep|strip)"
        ) from None
