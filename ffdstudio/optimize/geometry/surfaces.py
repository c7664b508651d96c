"""Surfaces of triangles in meshes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError

if TYPE_CHECKING:
    from ffdstudio.meshes.mesh import Mesh

SOLID = ("tetra", "hexahedron", "wedge")


def triangles_of(elements: Mapping[str, NDArray[np.integer]]) -> Indices:
    """(k, 3) triangles of a marker or of the cells of a mesh, quads split.

    Examples
    --------
    >>> triangles_of({"quad": np.array([[0, 1, 2, 3]])})
    array([[0, 1, 2],
           [0, 2, 3]])
    """
    parts = [np.asarray(elements.get("triangle", np.empty((0, 3), dtype=np.int64)))]
    if "quad" in elements:
        quads = np.asarray(elements["quad"])
        parts += [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    return np.concatenate(parts)


def surface_of(source: Mesh | str | os.PathLike[str]) -> tuple[Array, Indices]:
    """Points and triangles of the surface of a mesh or file; quads are split.

    Raises
    ------
    InputError
        If there are no triangles or quads, or volumes beside them.
    """
    from ffdstudio.meshes.mesh import Mesh
    from ffdstudio.meshes.reading import read_mesh

    mesh = source if isinstance(source, Mesh) else read_mesh(source)
    triangles = triangles_of(mesh.cells)
    if not len(triangles) or any(name in mesh.cells for name in SOLID):
        raise InputError(f"{mesh.path or 'the mesh'} is no surface of triangles and quads")
    used, compact = np.unique(triangles, return_inverse=True)
    return np.asarray(mesh.points)[used], compact.reshape(triangles.shape)
