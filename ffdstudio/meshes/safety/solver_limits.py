"""Limits in the solver's terms, evaluated on the cells that a drag strains most.

1. Non-orthogonality, skewness and the first layer's height are no linear functions of the
   drag, so they are followed along the direction asked for: a few steps, then bisection.
2. Candidates are the moved cells over which the influence varies most for their size, those
   nearest to a limit when the drag begins, and those that bound the region of inversion.
3. What is beyond a limit when the drag begins is not judged: it would forbid every move.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.evaluate import state_of
from ffdstudio.meshes.measures.face_measures import Fabric
from ffdstudio.meshes.measures.faces import Topology, topology_of
from ffdstudio.meshes.measures.incremental import QualityState
from ffdstudio.meshes.measures.vectors import length
from ffdstudio.meshes.mesh import Faces, Mesh
from ffdstudio.meshes.safety.halfspaces import Region
from ffdstudio.meshes.safety.limits import Limits, Stop

CANDIDATES = 300  # cells followed for each reason
STEPS, HALVINGS = 8, 16
FAR = 100.0  # candidate sizes a drag is followed for if no cell inverts
NAMES = ("non_orthogonality", "face_skewness", "first_layer")


class Strained:
    """The candidate cells with their neighbours, ready to be evaluated at any drag."""

    def __init__(
        self, mesh: Mesh, start: Array, influence: Array, region: Region, limits: Limits
    ) -> None:
        state, whole = state_of(mesh), topology_of(mesh)
        if state.fabric is None:
            raise InputError("limits of a solver need a volume mesh or a plane mesh")
        self.cells = _candidates(state, start, influence, region)
        near = whole.around(self.cells)
        part, nodes = _own_nodes(whole.part(near))
        self._fabric = Fabric(part, state.fabric.flat, state.fabric.directions)
        self._start, self._b = start[nodes], influence[nodes]
        self._place, self._all = np.searchsorted(near, self.cells), np.ones(len(near), dtype=bool)
        self._volumes = state.first["volume"][near]
        self._on_wall = np.empty(0, dtype=np.int64)
        if state.walls is not None:
            self._on_wall = np.flatnonzero(np.isin(whole.faces_of(near), state.walls.chosen))
            self._wall_areas = state.walls.areas[near]
        values = (limits.non_orthogonality, limits.face_skewness, limits.first_layer)
        self._bounds = np.array([np.inf if v is None else v for v in values])[:, None]
        self._judged = self._values(0.0, np.zeros(3)) <= self._bounds

    def stop(self, direction: Array, stop: Stop) -> Stop:
        """Earlier one of `stop` and the first limit met along the direction."""
        end = stop.amplitude if np.isfinite(stop.amplitude) else self._reach(direction)
        safe = 0.0
        for t in np.linspace(0, end, STEPS + 1)[1:].tolist():
            if self._beyond(t, direction) is not None:
                return self._bisected(direction, safe, t)
            safe = t
        return stop

    def _bisected(self, direction: Array, safe: float, bad: float) -> Stop:
        for _ in range(HALVINGS):
            middle = (safe + bad) / 2
            if self._beyond(middle, direction) is None:
                safe = middle
            else:
                bad = middle
        name, cell = self._beyond(bad, direction) or ("", -1)
        return Stop(safe, name, cell)

    def _beyond(self, t: float, direction: Array) -> tuple[str, int] | None:
        """Name of a limit that is passed at this amplitude, and a cell where."""
        over = (self._values(t, direction) > self._bounds) & self._judged
        if not over.any():
            return None
        which, where = np.argwhere(over)[0]
        return NAMES[which], int(self.cells[where])

    def _values(self, t: float, direction: Array) -> Array:
        """(3, candidates) values of the measures that have limits; -inf where there is none."""
        self._fabric.update(self._start + t * self._b[:, None] * direction, self._all)
        out = np.full((3, len(self.cells)), -np.inf)
        out[:2] = self._fabric.worst[:2, self._place]
        if len(self._on_wall):
            sizes = length(self._fabric.areas[self._on_wall].T)
            owner = self._fabric.faces.owner[self._on_wall]
            area = np.bincount(owner, sizes, minlength=len(self._all))[self._place]
            wall = np.flatnonzero(area > 0)
            cells = self._place[wall]
            height = self._fabric.volumes[cells] / self._volumes[cells]
            out[2, wall] = np.abs(height * self._wall_areas[cells] / area[wall] - 1)
        return out

    def _reach(self, direction: Array) -> float:
        """Amplitude that moves a candidate by `FAR` times the size of the candidates."""
        speed = np.abs(self._b).max(initial=0.0) * float(np.linalg.norm(direction))
        size = float(np.linalg.norm(np.ptp(self._start, axis=0))) if len(self._start) else 0.0
        return FAR * size / speed if speed > 0 else 0.0


def _candidates(state: QualityState, start: Array, influence: Array, region: Region) -> Indices:
    """Sorted numbers of the cells to follow."""
    with state.lock:
        state.move(start)
        measures = state.measures()
    moved = state.blocks.moved_cells(influence != 0)
    strain = _spread(state, influence) / np.abs(measures["volume"]) ** (1 / state.blocks.dimension)
    chosen = [np.unique(region.cells), _top(strain, moved)]
    chosen += [_top(measures[name], moved) for name in ("non_orthogonality", "face_skewness")]
    if state.walls is not None:
        wall = np.zeros(len(moved), dtype=bool)
        wall[state.walls.cells] = True
        chosen.append(_top(strain, moved & wall))
    return np.unique(np.concatenate(chosen))


def _top(values: Array, mask: np.ndarray) -> Indices:
    """Cells of the mask with the largest values."""
    cells = np.flatnonzero(mask)
    if len(cells) <= CANDIDATES:
        return cells
    return cells[np.argpartition(-values[cells], CANDIDATES)[:CANDIDATES]]


def _spread(state: QualityState, influence: Array) -> Array:
    """(cells,) difference of the largest and the least influence at the nodes of each cell."""
    b = state.blocks.extended(influence[:, None])[:, 0]
    out = np.zeros(state.blocks.count)
    for block in state.blocks.blocks:
        np.maximum.at(out, block.cells, np.ptp(b[block.nodes], axis=1))
    return out


def _own_nodes(topology: Topology) -> tuple[Topology, Indices]:
    """Topology with its nodes numbered by themselves, and which nodes these are."""
    faces = topology.faces
    nodes, own = np.unique(faces.nodes, return_inverse=True)
    new = Faces(own.ravel(), faces.offsets, faces.owner, faces.neighbour)
    return Topology(new, topology.cell_offsets, topology.cell_faces), nodes
