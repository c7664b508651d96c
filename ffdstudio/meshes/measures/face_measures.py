"""Measures that need the faces between cells, kept by face and by cell."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures import kernels
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.faces import Topology, topology_of
from ffdstudio.meshes.measures.work import shared
from ffdstudio.meshes.mesh import Mesh


class Fabric:
    """Geometry and measures of faces and cells of a volume mesh or a plane mesh.

    Attributes
    ----------
    geometry, by_face : numpy.ndarray
        (faces, 8) what the kernels know of a face, a line of the processor's cache each.
    volumes, aspects : numpy.ndarray
        By cell.
    worst : numpy.ndarray
        (5, cells): the worst of its faces' non-orthogonality in degrees, skewness, orthogonal
        quality, growth ratio and equiangle skewness.
    """

    def __init__(self, topology: Topology, flat: bool, directions: np.ndarray) -> None:
        self.faces, self.flat, self.directions = topology.faces, flat, directions
        self.of_cells = topology.cell_offsets, topology.cell_faces
        faces, cells = len(self.faces), len(topology.cell_offsets) - 1
        self.geometry, self.by_face = np.zeros((faces, 8)), np.zeros((faces, 8))
        self.volumes, self.aspects = np.zeros(cells), np.zeros(cells)
        self.middles, self.worst = np.zeros((cells, 3)), np.zeros((5, cells))

    @classmethod
    def of(cls, mesh: Mesh) -> Fabric:
        """Fabric of all cells of a mesh, not evaluated yet."""
        return cls(topology_of(mesh), blocks_of(mesh).flat, directions(mesh))

    def update(self, points: Array, moved: np.ndarray) -> Indices:
        """Evaluate the faces of the cells in the mask `moved`; the cells whose measures change."""
        faces = np.zeros(len(self.faces), dtype=bool)
        around = np.zeros(len(moved), dtype=bool)
        ends = self.faces.owner, self.faces.neighbour
        shared(kernels.faces_between, np.arange(len(faces)), *ends, moved, faces, around)
        chosen, cells = np.flatnonzero(faces), np.flatnonzero(around)
        loops = self.faces.nodes, self.faces.offsets
        shared(kernels.face_geometry, chosen, points, *loops, self.geometry)
        self._cells(np.flatnonzero(moved))
        self._measures(points, chosen, cells)
        return cells

    @property
    def areas(self) -> Array:
        """(faces, 3) area vectors."""
        return self.geometry[:, :3]

    @property
    def centres(self) -> Array:
        """(faces, 3) centres of faces."""
        return self.geometry[:, 3:6]

    def _cells(self, chosen: Indices) -> None:
        given = (*self.of_cells, self.faces.owner, self.geometry, self.directions, self.flat)
        out = self.volumes, self.middles, self.aspects
        shared(kernels.cell_geometry, chosen, *given, *out)

    def _measures(self, points: Array, chosen: Indices, cells: Indices) -> None:
        faces = self.faces
        loops = faces.nodes, faces.offsets, faces.owner, faces.neighbour
        geometry = self.geometry, self.volumes, self.middles
        shared(kernels.face_measures, chosen, points, *loops, *geometry, self.by_face)
        given = *self.of_cells, faces.owner, faces.offsets, self.by_face
        shared(kernels.worst_of_faces, cells, *given, self.worst)


def directions(mesh: Mesh) -> np.ndarray:
    """Axes in which the mesh is solved: those not across a plane mesh or an `empty` patch."""
    if blocks_of(mesh).flat:
        return np.array([True, True, False])
    empty = [name for name, kind in mesh.kinds.items() if kind == "empty" and name in mesh.markers]
    across = np.zeros(3)
    for name in empty:
        for nodes in mesh.markers[name].values():
            p = mesh.points[nodes]
            across += np.abs(np.cross(p[:, 2] - p[:, 0], p[:, -1] - p[:, 1])).sum(axis=0)
    result: np.ndarray = across <= 1e-3 * across.sum()
    return result
