"""The first layer of cells at walls: its height is the cell's volume over its wall area."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures import kernels
from ffdstudio.meshes.measures.recognise import ramps
from ffdstudio.meshes.measures.vectors import length
from ffdstudio.meshes.mesh import Faces, Mesh
from ffdstudio.meshes.topology import corners

OPEN = ("far", "sym", "inlet", "outlet", "inflow", "outflow", "empty", "period", "cyclic")
OPEN_KINDS = ("patch", "wedge", "processor")


def walls(mesh: Mesh) -> tuple[str, ...]:
    """Names of the markers that are walls: by their kind where the file tells, else by name.

    Examples
    --------
    >>> line = {"line": [[0, 1]]}
    >>> walls(Mesh([[0, 0, 0], [1, 0, 0]], {}, {"AIRFOIL": line, "FARFIELD": line}))
    ('AIRFOIL',)
    """
    if "wall" in mesh.kinds.values():
        return tuple(name for name in mesh.markers if mesh.kinds.get(name) == "wall")
    return tuple(name for name in mesh.markers if not _open(name, mesh.kinds.get(name, "")))


def _open(name: str, kind: str) -> bool:
    text = f"{name} {kind}".lower()
    return kind in OPEN_KINDS or any(word in text for word in OPEN)


class Walls:
    """The boundary faces on walls, with their cells and undeformed areas by cell.

    Attributes
    ----------
    names : tuple of str
        Markers that count as walls.
    """

    def __init__(self, mesh: Mesh, faces: Faces, cells: int) -> None:
        self.names, self.count = walls(mesh), cells
        self.chosen = _on_walls(mesh, self.names, faces)
        self.cells = faces.owner[self.chosen]
        size = np.diff(faces.offsets)[self.chosen]
        self._offsets = np.concatenate([[0], np.cumsum(size)])
        self._nodes = faces.nodes[np.repeat(faces.offsets[self.chosen], size) + ramps(size)]
        self.areas = self._areas(mesh.points)

    def ratio(self, volume_ratio: Array, points: Array) -> Array:
        """(cells,) height over its undeformed value; NaN away from walls."""
        return volume_ratio * self.areas / self._areas(points)

    def _areas(self, points: Array) -> Array:
        geometry = np.zeros((len(self.chosen), 8))
        everyone = np.arange(len(self.chosen))
        kernels.face_geometry(everyone, points, self._nodes, self._offsets, geometry)
        sizes = length(geometry[:, :3].T)
        total = np.bincount(self.cells, sizes, minlength=self.count)
        return np.where(total > 0, total, np.nan)


def _on_walls(mesh: Mesh, names: tuple[str, ...], faces: Faces) -> Indices:
    """Numbers of the boundary faces that are elements of these markers."""
    wanted = {
        row.tobytes()
        for name in names
        for kind, elements in mesh.markers[name].items()
        for row in np.sort(corners(kind, elements), axis=1)
    }
    boundary = np.flatnonzero(faces.neighbour < 0)
    loops = (np.sort(faces.nodes[faces.offsets[f] : faces.offsets[f + 1]]) for f in boundary)
    hits = np.fromiter((loop.tobytes() in wanted for loop in loops), bool, len(boundary))
    result: Indices = boundary[hits]
    return result
