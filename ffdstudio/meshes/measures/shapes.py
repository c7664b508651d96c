"""Scaled Jacobian and corner signs by cell type, equiangle skewness of plane cells.

1. The scaled Jacobian is Verdict's: the least corner Jacobian of unit edges over its value in
   the ideal cell. Tetrahedra and triangles take the largest product of edges at their nodes,
   pyramids that of the tetrahedra at the four corners of their base, and are as much below 1
   as they exceed it.
2. It refers to the order that most cells of a type have: mirrored files are not bad meshes.
3. Verdict knows no polyhedra; theirs is the least over the corners where three edges meet.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures import corner_kernels, kernels
from ffdstudio.meshes.measures.bezier import HEX_EDGES
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.corners import jacobians, orientation, signs, unit
from ffdstudio.meshes.measures.vectors import dot, gathered, length
from ffdstudio.meshes.measures.work import shared
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import corners, dimension

IDEAL = {  # the Jacobian of unit edges in the ideal cell
    "triangle": np.sqrt(3) / 2,
    "quad": 1.0,
    "polygon": 1.0,
    "tetra": np.sqrt(0.5),
    "pyramid": 0.5,
    "wedge": np.sqrt(3) / 2,
    "hexahedron": 1.0,
    "polyhedron": 1.0,
}
TETRAHEDRA = ("tetra", "pyramid")


class CellShape:
    """Scaled Jacobians of one block, against the signs its corners had."""

    def __init__(self, block: CellBlock, points: Array, up: Array | None) -> None:
        self.block, self.up = block, up
        self.factor = orientation(block, points, up) / IDEAL[block.type]
        self.table = np.array(block.corners)
        self.signs = np.ascontiguousarray(signs(block, points, up).T.astype(np.int8))

    def at(self, points: Array, rows: Indices) -> tuple[Array, np.ndarray]:
        """Scaled Jacobians of these rows of the block, and whether a corner lost its sign."""
        if self.table.shape[1] == 3:
            return self._plane(self.block[rows], points, self.signs[rows].T)
        scaled, flipped = np.empty(len(rows)), np.empty(len(rows), dtype=bool)
        of_tetrahedra = self.block.type in TETRAHEDRA
        given = rows, points, self.block.nodes, self.table, of_tetrahedra, self.factor, self.signs
        shared(corner_kernels.corner_measures, np.arange(len(rows)), *given, scaled, flipped)
        if self.block.type == "pyramid":
            scaled = np.minimum(scaled, 2 - scaled)
        return scaled, flipped

    def doubtful(self, points: Array, rows: Indices) -> np.ndarray:
        """Which of these rows are not known to be of one sign inside by a bound (`bezier`, 3)."""
        doubt = np.ones(len(rows), dtype=bool)
        if self.block.type == "hexahedron":
            given = rows, points, self.block.nodes, np.array(HEX_EDGES)
            shared(corner_kernels.bounded, np.arange(len(rows)), *given, doubt)
        return doubt

    def _plane(self, part: CellBlock, points: Array, sign: np.ndarray) -> tuple[Array, np.ndarray]:
        values = jacobians(part, points, self.up)
        sizes = _products(gathered(points, part.nodes), part.type)
        scaled = values * self.factor / np.where(sizes > 0, sizes, np.inf)
        return scaled.min(axis=0), ((values * sign <= 0) & (sign != 0)).any(axis=0)


def _products(x: Array, kind: str) -> Array:
    """(corners, k) products of the two edges of plane cells; a triangle's largest alone."""
    side = length(np.roll(x, -1, axis=1) - x)
    product = side * np.roll(side, 1, axis=0)
    return product.max(axis=0, keepdims=True) if kind == "triangle" else product


class Polygons:
    """Plane cells as polygons: equiangle skewness and area."""

    def __init__(self, mesh: Mesh) -> None:
        loops = [corners(kind, nodes) for kind, nodes in mesh.cells.items() if dimension(kind) == 2]
        sizes = np.concatenate([np.full(len(nodes), nodes.shape[1]) for nodes in loops])
        self.nodes = np.concatenate([nodes.ravel() for nodes in loops])
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        self.geometry = np.zeros((len(sizes), 8))
        self.update(mesh.points, np.arange(len(sizes)))
        self.normals = unit(self.geometry[:, :3].T).copy()

    def update(self, points: Array, chosen: Indices) -> None:
        """Evaluate the chosen cells."""
        shared(kernels.face_geometry, chosen, points, self.nodes, self.offsets, self.geometry)

    @property
    def volumes(self) -> Array:
        """Areas, negative where the normal turned round."""
        return dot(self.geometry[:, :3].T, self.normals)

    @property
    def skewness(self) -> Array:
        """Equiangle skewness; 1 with a reflex angle."""
        least, most = self.geometry[:, 6:].T
        size = np.diff(self.offsets)
        ideal = np.pi * (size - 2) / size
        large = (np.arccos(np.clip(least, -1, 1)) - ideal) / (np.pi - ideal)
        small = (ideal - np.arccos(np.clip(most, -1, 1))) / ideal
        return np.where(least < -1.1, 1.0, np.clip(np.maximum(large, small), 0, 1))
