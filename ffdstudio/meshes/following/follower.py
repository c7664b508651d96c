"""The public object: made once from a mesh, called with displacements of its surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from threading import Lock

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.following.constraints import Constraints
from ffdstudio.meshes.following.path import SurfacePath, count_of
from ffdstudio.meshes.following.roles import moved_nodes, roles_of
from ffdstudio.meshes.following.stage import Sources, Stage
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import numbers

Told = Callable[[float, str], None]
MOST = np.radians(60)  # turn of a surface in one step


def quiet(fraction: float, text: str = "") -> None:
    """Tell nobody."""


class Follower:
    """Lets the volume of a mesh follow its surface.

    Parameters
    ----------
    mesh : Mesh
        With volume cells, or a plane mesh. It is the undeformed one.
    moving : sequence of str, or array_like of int, optional
        Markers or nodes that will be told where to go; by default the walls. Other boundaries
        stay, but for planes, in which nodes slide, and periodic ones, whose partners move alike.

    Raises
    ------
    InputError
        If the mesh has no volume, a marker is unknown, or nothing moves.

    Notes
    -----
    Inverse distance weighting with rotations (Luke, Collins, Blades: A fast mesh deformation
    method using explicit interpolation, J. Comput. Phys. 231, 2012), over a tree; why this one
    and how it was chosen is told in `ffdstudio.meshes.following`.

    Examples
    --------
    >>> grid = np.mgrid[0:5, 0:5].reshape(2, -1).T.astype(float)
    >>> i = np.arange(20).reshape(4, 5)[:, :4].ravel()
    >>> wall = {"line": [[k, k + 5] for k in (0, 5, 10, 15)]}
    >>> mesh = Mesh(
    ...     np.column_stack([grid, np.zeros(25)]),
    ...     {"quad": np.column_stack([i, i + 5, i + 6, i + 1])},
    ...     {"wall": wall},
    ...     dimension=2,
    ... )
    >>> follower = Follower(mesh)
    >>> step = np.zeros((5, 3))
    >>> step[2, 1] = 0.5
    >>> (follower(step) - mesh.points)[[10, 11, 12, 14], 1].round(2)
    array([0.5 , 0.32, 0.07, 0.  ])
    """

    def __init__(
        self, mesh: Mesh, moving: Sequence[str] | ArrayLike | None = None, told: Told = quiet
    ) -> None:
        told(0.0, "finding what moves and what stays")
        self.mesh, self.roles = mesh, roles_of(mesh, moving)
        self._sources = Sources.of(self.roles, mesh.points)
        self._constraints = Constraints(self.roles, len(mesh.points))
        self._lock = Lock()

    def fits(self, mesh: Mesh, moving: Sequence[str] | ArrayLike) -> bool:
        """Whether it is of this mesh, and told where the same markers or nodes go."""
        if mesh is not self.mesh:
            return False
        return np.array_equal(moved_nodes(mesh, moving), self.moving)

    @property
    def moving(self) -> Indices:
        """(k,) sorted indices of the nodes that are told where to go."""
        return self.roles.moving

    @cached_property
    def _first(self) -> Stage:
        return self._stage(self.mesh.points)

    def __call__(self, displacements: ArrayLike, told: Told = quiet) -> Array:
        """Places of all nodes.

        Parameters
        ----------
        displacements : array_like
            (k, 3) of the nodes `moving`, in the unit of the mesh.
        told : callable, optional
            Hears how far it is (0 to 1) and what is done; may raise to stop.

        Returns
        -------
        numpy.ndarray
            (n, 3). Moving nodes are where they were told to be and staying ones where they
            were, to the bit; the result does not depend on the number of cores.

        Raises
        ------
        InputError
            If the displacements do not fit.
        """
        step = self._step(displacements)
        goal = self.mesh.points + step
        if not step.any():
            return self.mesh.points.copy()
        count = self.steps(displacements)
        points, stage = self.mesh.points, self._stage_at_rest(told)
        for k, places in enumerate(self._ways(goal, count)):
            told((k + 0.5) / count, f"the volume follows: step {k + 1} of {count}")
            if k:
                stage = self._stage(points)
            step = np.zeros_like(points)
            step[self.moving] = places - points[self.moving]
            points = stage.moved(step)
            points[self.moving] = places
        points[self.roles.staying] = self.mesh.points[self.roles.staying]
        return points

    def steps(self, displacements: ArrayLike) -> int:
        """Number of steps these displacements take: one for turns up to 60 degrees."""
        step = self._step(displacements)
        return count_of(self._stage_at_rest(quiet).turned(step).largest, MOST)

    def pull(self, sensitivities: ArrayLike, displacements: ArrayLike) -> Array:
        """Sensitivities by the surface: the transpose of the derivative, times those by the volume.

        Parameters
        ----------
        sensitivities : array_like
            (n, 3) derivatives of a cost by the places of all nodes.
        displacements : array_like
            (k, 3) where the derivative is taken.

        Returns
        -------
        numpy.ndarray
            (k, 3) derivatives of the cost by the displacements of the nodes `moving`.

        Raises
        ------
        InputError
            If arrays do not fit, or the surface turns by more than one step allows.
        """
        gradient = numbers(sensitivities, "sensitivities")
        if gradient.shape != self.mesh.points.shape:
            raise InputError(
                f"this mesh has {len(self.mesh.points)} nodes, the sensitivities are of shape "
                f"{gradient.shape}"
            )
        if self.steps(displacements) > 1:
            raise InputError(
                "the surface turns by over 60 degrees: no derivative is known across several steps"
            )
        step = self._step(displacements)
        return np.asarray(self._stage_at_rest(quiet).pull(gradient, step)[self.moving])

    def _step(self, displacements: ArrayLike) -> Array:
        given = numbers(displacements, "displacements")
        if given.shape != (len(self.moving), 3):
            raise InputError(
                f"{len(self.moving)} nodes move, their displacements are of shape {given.shape}"
            )
        if not np.isfinite(given).all():
            raise InputError("a displacement is not a finite number")
        step = np.zeros_like(self.mesh.points)
        step[self.moving] = given
        return step

    def _stage_at_rest(self, told: Told) -> Stage:
        with self._lock:
            told(0.0, "weighing distances from the surface")
            return self._first

    def _stage(self, points: Array) -> Stage:
        return Stage(self.roles, self._sources, self._constraints, points)

    def _ways(self, goal: Array, count: int) -> list[Array]:
        """Places of the moving nodes after each step."""
        rest = self.mesh.points[self.moving]
        if count == 1:
            return [goal[self.moving]]
        return list(SurfacePath.of(rest, goal[self.moving], self._pieces()).steps(count))

    def _pieces(self) -> Indices:
        """(k,) number of the connected piece of each moving node."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        place = np.full(len(self.mesh.points), -1)
        place[self.moving] = np.arange(len(self.moving))
        rows = [np.stack([e, np.roll(e, -1, axis=1)], -1).reshape(-1, 2) for e in self._elements()]
        edges = place[np.concatenate(rows)] if rows else np.empty((0, 2), dtype=np.int64)
        many = len(self.moving)
        graph = coo_array((np.ones(len(edges)), edges.T), (many, many))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)

    def _elements(self) -> list[Indices]:
        moves = np.zeros(len(self.mesh.points), dtype=bool)
        moves[self.moving] = True
        return [e[moves[e].all(axis=1)] for e in self.roles.elements]
