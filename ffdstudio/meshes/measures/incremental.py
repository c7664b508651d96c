"""The measures of a mesh, kept so that only what moved is evaluated again.

1. "Moved" refers to the points evaluated last: a drag that goes on costs what it moves.
2. Cells of a surface in space have no neighbours in their plane: the measures of faces are left
   out there, and volume is area.
3. It holds no mesh, so that a mesh nobody else holds can go and take its state along.
4. The measures handed out are copies: they stay as they are when the state moves on.
"""

from __future__ import annotations

from threading import Lock

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.bezier import INSIDE
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.cell_coverage import coverage
from ffdstudio.meshes.measures.face_measures import Fabric
from ffdstudio.meshes.measures.inversion import folded_since
from ffdstudio.meshes.measures.layers import Walls
from ffdstudio.meshes.measures.shapes import CellShape, Polygons
from ffdstudio.meshes.mesh import Mesh

FACED = ("non_orthogonality", "face_skewness", "orthogonal_quality", "growth_ratio")

FANS = ("polygon", "polyhedron")  # several rows of a block are one cell


class QualityState:
    """Measures per cell at the points evaluated last; at first those of the mesh."""

    def __init__(self, mesh: Mesh) -> None:
        self.undeformed, self.blocks, self.lock = mesh.points, blocks_of(mesh), Lock()
        if self.blocks.count == 0:
            unseen = f": {coverage(mesh)}" if coverage(mesh).missing else ""
            raise InputError(
                f"{mesh.path or 'the mesh'} has no cells whose quality could be told{unseen}"
            )
        self.points = mesh.points.copy()
        self.rest = self.blocks.extended(mesh.points)
        up = self.blocks.upright(self.rest)
        corners = [self.blocks.trihedra] if self.blocks.trihedra is not None else []
        blocks = [*self.blocks.blocks, *corners]
        self.shapes = [CellShape(block, self.rest, up) for block in blocks]
        surface = self.blocks.dimension == 2
        self.polygons = Polygons(mesh) if surface else None
        self.fabric = None if surface and not self.blocks.flat else Fabric.of(mesh)
        count = self.blocks.count
        self.scaled, self.inverted = np.full(count, np.nan), np.zeros(count, dtype=bool)
        self._evaluate(np.ones(count, dtype=bool))
        self.first = self.measures()
        found = Walls(mesh, self.fabric.faces, count) if self.fabric is not None else None
        self.walls = found if found is not None and len(found.chosen) else None

    def move(self, points: Array) -> None:
        """Evaluate what differs from the points evaluated last; under the lock."""
        moved = differ(points, self.points)
        if moved.any():
            self.points = points.copy()
            self._evaluate(self.blocks.moved_cells(moved))

    def places(self, points: Array, cells: Indices) -> Array:
        """(k, 3) means of the nodes of cells."""
        here, out = self.blocks.extended(points), np.zeros((len(cells), 3))
        for block in self.blocks.blocks:
            order = np.argsort(block.cells, kind="stable")
            first = np.searchsorted(block.cells, cells, sorter=order)
            for i in np.flatnonzero(first < len(order)):
                row = order[first[i]]
                if block.cells[row] == cells[i]:
                    mean = block.type in FANS  # its last node
                    nodes = block.nodes[row, -1:] if mean else block.nodes[row]
                    out[i] = here[nodes].mean(axis=0)
        return out

    def measures(self) -> dict[str, Array]:
        """Copies of the measures."""
        out = {"scaled_jacobian": self.scaled.copy()}
        if self.polygons is not None:
            out |= {"skewness": self.polygons.skewness, "volume": self.polygons.volumes}
        if self.fabric is not None:
            out |= {"skewness": self.fabric.worst[4].copy()} if self.polygons is None else {}
            out |= {"volume": self.fabric.volumes.copy()}
            out |= {"aspect_ratio": self.fabric.aspects.copy()}
            out |= {name: self.fabric.worst[i].copy() for i, name in enumerate(FACED)}
        return out

    def _evaluate(self, moved: np.ndarray) -> None:
        here = self.blocks.extended(self.points)
        if self.fabric is not None:
            self.fabric.update(self.points, moved)
        if self.polygons is not None:
            self.polygons.update(self.points, np.flatnonzero(moved))
        self.inverted[moved] = False
        self.scaled[moved] = np.inf
        for shape in self.shapes:
            self._judge(shape, here, moved)
        for block in self.blocks.curved:
            part = block[moved[block.cells] & ~self.inverted[block.cells]]
            skip = np.zeros(len(part.cells), dtype=bool)
            self.inverted[part.cells[folded_since(part, self.rest, here, skip)]] = True
        self.scaled[moved & np.isinf(self.scaled)] = np.nan  # a polyhedron without such a corner

    def _judge(self, shape: CellShape, here: Array, moved: np.ndarray) -> None:
        """Scaled Jacobians and inversion of the moved cells of one block."""
        block = shape.block
        rows = np.flatnonzero(moved[block.cells])
        cells = block.cells[rows]
        scaled, flipped = shape.at(here, rows)
        if block.type not in FANS:
            self.scaled[cells] = scaled
        elif block is self.blocks.trihedra or block.type == "polygon":
            np.minimum.at(self.scaled, cells, scaled)
        if block is not self.blocks.trihedra:
            self.inverted[cells[flipped]] = True
        if block.type in INSIDE:
            doubt = rows[shape.doubtful(here, rows) & ~flipped]
            part = block[doubt]
            inside = folded_since(part, self.rest, here, np.zeros(len(doubt), dtype=bool))
            self.inverted[part.cells[inside]] = True


def differ(a: Array, b: Array) -> np.ndarray:
    """Mask of the points (n, 3) that are not the same."""
    result: np.ndarray = (a[:, 0] != b[:, 0]) | (a[:, 1] != b[:, 1]) | (a[:, 2] != b[:, 2])
    return result
