"""Inverted cells: a corner Jacobian changed sign, or the cell is negative inside.

1. The reference is the undeformed mesh, see `corners`.
2. A hexahedron or wedge with good corners can still be negative inside. That is decided by the
   Bezier coefficients of its Jacobian (`bezier`), for cells that were valid to begin with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.bezier import folded, has_inside
from ffdstudio.meshes.measures.blocks import CellBlock, blocks_of
from ffdstudio.meshes.measures.sweep import Sweep
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import numbers


@dataclass(frozen=True, eq=False)
class Inverted:
    """Inverted cells.

    Attributes
    ----------
    mask : numpy.ndarray
        (cells,) bool, numbered as in `mesh.cells` type after type.
    corners : int
        How many of them have a corner that changed sign; the others are negative inside.
    """

    mask: np.ndarray
    corners: int

    @property
    def count(self) -> int:
        """Number of inverted cells."""
        return int(self.mask.sum())

    @property
    def cells(self) -> Indices:
        """Numbers of the inverted cells."""
        return np.flatnonzero(self.mask)


def inverted(mesh: Mesh, points: ArrayLike | None = None) -> Inverted:
    """Cells that `points` turn inside out, against the undeformed `mesh.points`.

    Parameters
    ----------
    mesh : Mesh
    points : array_like, optional
        (n, 3) deformed coordinates. Without them nothing is inverted.

    Raises
    ------
    InputError
        If the number of points differs.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> inverted(mesh, [[0, 0, 0], [1, 0, 0], [0, -1, 0]]).count
    1
    """
    new = deformed(mesh, points)
    blocks = blocks_of(mesh)
    old, here = blocks.extended(mesh.points), blocks.extended(new)
    mask, corner = np.zeros(blocks.count, dtype=bool), np.zeros(blocks.count, dtype=bool)
    sweep = Sweep(old, blocks.moved(mesh.points, new), blocks.flat)
    for block in blocks.blocks:
        for flips, doubt in sweep.flipped(block, here):
            corner[block.cells[flips]] = True
            part = block[doubt]
            mask[part.cells[folded_since(part, old, here, np.zeros(len(doubt), dtype=bool))]] = True
    for block in blocks.curved:
        rows = np.flatnonzero(sweep.moved[block.nodes].any(axis=1) & ~corner[block.cells])
        part = block[rows]
        mask[part.cells[folded_since(part, old, here, np.zeros(len(rows), dtype=bool))]] = True
    return Inverted(mask | corner, int(corner.sum()))


def deformed(mesh: Mesh, points: ArrayLike | None) -> Array:
    """Coordinates as an array that fits the mesh."""
    if not hasattr(mesh, "points"):
        raise InputError(f"a mesh is needed, got {mesh!r}")
    new = mesh.points if points is None else numbers(points, "the points given")
    if new.shape != mesh.points.shape:
        raise InputError(f"this mesh has points {mesh.points.shape}, the points given {new.shape}")
    return new


def folded_since(block: CellBlock, old: Array, here: Array, skip: np.ndarray) -> np.ndarray:
    """Whether a cell is negative inside now and was not at the beginning; not asked of `skip`."""
    out = np.zeros(len(block.nodes), dtype=bool)
    if has_inside(block.type):
        suspect = np.flatnonzero(~skip)
        suspect = suspect[folded(block[suspect], here)]
        out[suspect[~folded(block[suspect], old)]] = True
    return out
