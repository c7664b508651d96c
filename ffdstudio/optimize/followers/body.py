"""A mesh that follows a study's lattice, and whether its cells stay valid.

1. Valid is what `meshes.inverted` says: no cell turned inside out that was not when the study
   began.
2. A mesh that reaches out of the lattice follows its walls, which the lattice moves: first layers
   keep their heights however thick, tight or coarse the lattice is. Carried by the lattice they
   become half as high, or invert. A mesh within the lattice (a structure) is carried.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.engine import Embedding, Lattice, embed
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.ways import Way

if TYPE_CHECKING:
    from ffdstudio.meshes.following import Follower

ENOUGH = 0.95  # of the exact amplitude: cells keep some volume


@dataclass(eq=False)
class FollowingMesh:
    """A mesh bound to a study's lattice.

    Attributes
    ----------
    mesh : Mesh
        Undeformed: it tells the sign of each cell.
    embedding : Embedding
        Of its nodes, in the lattice at rest.
    name : str
    way : Way
        With "walls" its volume follows its walls if it reaches out of the lattice.
    walls : tuple of str, numpy.ndarray or None
        Boundaries, or nodes, that the lattice moves while the volume follows them; None if it
        carries all nodes.
    in_one_step : bool
        Whether the surface must not turn so far that the volume follows in several steps, for
        their derivative is not known.
    """

    mesh: Mesh
    embedding: Embedding
    name: str = ""
    way: Way = Way.WALLS
    walls: tuple[str, ...] | Indices | None = None
    in_one_step: bool = False
    _before: NDArray[np.bool_] | None = field(default=None, repr=False)
    _latest: Embedding | None = field(default=None, repr=False)
    _follower: Follower | None = field(default=None, repr=False)

    @classmethod
    def of(
        cls,
        mesh: Mesh,
        rest: Lattice,
        points: Array | None = None,
        name: str = "",
        way: Way = Way.WALLS,
    ) -> FollowingMesh:
        """Bind a mesh, whose nodes may be elsewhere (points) when the study begins."""
        start = mesh.points if points is None else points
        return cls(mesh, embed(rest, start), name, way)

    @property
    def start(self) -> Array:
        """(n, 3) nodes in the lattice at rest."""
        return self.embedding.points

    def begin(self, current: Lattice) -> None:
        """Note which cells are inverted already where the study begins."""
        from ffdstudio.meshes import inverted

        self._before = None
        self._before = inverted(self.mesh, self.at(current)).mask

    def at(self, current: Lattice) -> Array:
        """(n, 3) nodes under a lattice, in any refinement of the space at rest."""
        return self.followed(self._bound(current).deform(current))

    def followed(self, carried: Array) -> Array:
        """(n, 3) nodes, given where the lattice takes all of them."""
        if self.walls is None:
            return carried
        follower = self.follower
        points = follower((carried - self.start)[follower.moving])
        points[follower.moving] = carried[follower.moving]
        return points

    def pull(self, gradient: Array, carried: Array) -> Array:
        """(n, 3) derivative by where the lattice takes the nodes, from that by the nodes."""
        if self.walls is None:
            return gradient
        moving, out = self.follower.moving, np.zeros_like(gradient)
        out[moving] = self.follower.pull(gradient, (carried - self.start)[moving])
        return out

    def valid(self, current: Lattice) -> bool:
        """Whether no cell is inverted under a lattice that was not when the study began."""
        carried = self._bound(current).deform(current)
        if self.walls is not None and self.in_one_step:
            step = (carried - self.start)[self.follower.moving]
            if self.follower.steps(step) > 1:
                return False
        return self.broken(self.followed(carried)) == 0

    def broken(self, points: Array) -> int:
        """Cells that are inverted at (n, 3) nodes and were not when the study began."""
        from ffdstudio.meshes import inverted

        mask = inverted(self.mesh, points).mask
        return int((mask if self._before is None else mask & ~self._before).sum())

    def reach(self, here: Array, there: Array) -> float:
        """Share of the way between two places of the nodes that leaves all cells valid."""
        from ffdstudio.meshes import safe_amplitude

        return ENOUGH * min(safe_amplitude(self.mesh, there - here, here), 1 / ENOUGH)

    def _bound(self, current: Lattice) -> Embedding:
        latest = self._latest or self.embedding
        if not latest.lattice.same_space(current):
            latest = self.embedding.refined(_in_space_of(self.embedding.lattice, current))
        self._latest = latest
        return latest

    @property
    def follower(self) -> Follower:
        """What the volume follows its walls by."""
        from ffdstudio.meshes.following import Follower

        if self._follower is None:
            mesh = (
                self.mesh
                if np.array_equal(self.start, self.mesh.points)
                else (self.mesh.with_points(self.start))
            )
            assert self.walls is not None
            self._follower = Follower(mesh, self.walls)
        return self._follower


def _in_space_of(rest: Lattice, current: Lattice) -> Lattice:
    """The lattice at rest with the knots of a finer one."""
    for axis in range(rest.dimension):
        values, counts = np.unique(current.knots[axis], return_counts=True)
        have = np.array([(rest.knots[axis] == value).sum() for value in values])
        extra = np.repeat(values, np.maximum(counts - have, 0))
        if len(extra):
            rest = rest.insert_knots(axis, extra)
    return rest


def crosses(embedding: Embedding, edges: Indices) -> bool:
    """Whether edges (m, 2) of a mesh lead out of the lattice that its nodes are bound to."""
    return bool((embedding.inside[edges].sum(axis=1) == 1).any())


def moved_walls(
    mesh: Mesh, embedding: Embedding, current: Lattice
) -> tuple[str, ...] | Indices | None:
    """Boundaries that a lattice moves as walls, or their nodes; None if nothing could follow."""
    from ffdstudio.meshes.following.roles import has_volume, moved_boundaries, outer_nodes

    if not has_volume(mesh):
        return None
    nodes = outer_nodes(mesh)
    step = np.zeros_like(mesh.points)
    step[nodes] = (embedding.deform(current) - embedding.points)[nodes]
    if mesh.boundaries:
        return moved_boundaries(mesh, step) or None
    nodes = np.flatnonzero((step != 0).any(axis=1))
    return nodes if len(nodes) else None
