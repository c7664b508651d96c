"""A surface that something else moves (a lattice), with the volume following it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.following.follower import Follower, Told, quiet
from ffdstudio.meshes.following.roles import has_volume, moved_boundaries, outer_nodes
from ffdstudio.meshes.mesh import Mesh

METHOD = "inverse distance weighting with rotations"


@dataclass(frozen=True, eq=False)
class Carried:
    """A mesh whose walls were moved.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3) where its nodes are.
    walls : tuple of str
        Boundaries that were moved; empty if the mesh has no volume or nothing moves.
    follower : Follower or None
        What the volume followed by.
    steps : int
        In how many steps.
    """

    points: Array
    walls: tuple[str, ...] = ()
    follower: Follower | None = None
    steps: int = 0


def carry_walls(
    mesh: Mesh,
    move: Callable[[Array], Array],
    walls: Sequence[str] | None = None,
    told: Told = quiet,
) -> Carried:
    """Move the walls of a mesh and let its volume follow; all of a mesh without a volume.

    Parameters
    ----------
    mesh : Mesh
        Undeformed.
    move : callable
        Takes points (k, 3) to where they go, such as the nodes of a lattice.
    walls : sequence of str, optional
        Boundaries that move; by default those with nodes that `move` moves, but for planes in
        which nodes slide, and periodic ones.
    told : callable, optional
        Hears how far it is; may raise to stop.

    Raises
    ------
    InputError
        If a wall is unknown.
    """
    if not has_volume(mesh):
        return Carried(move(mesh.points))
    nodes = outer_nodes(mesh) if walls is None else mesh.marker_nodes(*walls)
    goal = mesh.points.copy()
    goal[nodes] = move(mesh.points[nodes])
    return follow_walls(mesh, goal, walls, told)


def follow_walls(
    mesh: Mesh,
    goal: Array,
    walls: Sequence[str] | None = None,
    told: Told = quiet,
    known: Follower | None = None,
) -> Carried:
    """Let the volume of a mesh follow walls that are elsewhere; see `carry_walls`.

    Parameters
    ----------
    goal : numpy.ndarray
        (n, 3) nodes, of which those on the walls count; all of a mesh without a volume.
    known : Follower, optional
        Of an earlier call, taken if it is of the same mesh and walls: that saves its set-up.
    """
    if not has_volume(mesh):
        return Carried(goal.copy())
    step = np.zeros_like(goal)
    nodes = outer_nodes(mesh) if walls is None else mesh.marker_nodes(*walls)
    step[nodes] = goal[nodes] - mesh.points[nodes]
    if not step.any():
        return Carried(mesh.points.copy(), follower=known)
    names = tuple(walls) if walls is not None else moved_boundaries(mesh, step)
    moving: Sequence[str] | Indices = names
    if walls is None and not mesh.boundaries:
        moving = np.flatnonzero(step.any(axis=1))
    if not len(moving):  # what moves is planes alone, which slide in themselves
        return Carried(mesh.points.copy(), follower=known)
    follower = known if known is not None and known.fits(mesh, moving) else None
    follower = follower or Follower(mesh, moving, told)
    own = step[follower.moving]
    points = follower(own, told)
    points[follower.moving] = goal[follower.moving]
    return Carried(points, names, follower, follower.steps(own))
