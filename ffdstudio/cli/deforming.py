"""A mesh and a lattice: all nodes carried by it, or the walls alone with the volume following."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice, embed
from ffdstudio.errors import InputError
from ffdstudio.exchange.solver_motion import write_solver_motion
from ffdstudio.meshes import Mesh
from ffdstudio.paths import is_same

FARTHEST = 1e100  # beyond it lengths and volumes are no numbers any more


class Carrier:
    """A lattice that takes points along, and what that took.

    Attributes
    ----------
    inside : int
        Number of points inside at the last call.
    seconds : dict
        Of embedding and deforming them.
    """

    def __init__(self, rest: Lattice, current: Lattice) -> None:
        self._rest, self._current = rest, current
        self.inside, self.seconds = 0, {"embed": 0.0, "deform": 0.0}

    def __call__(self, points: Array) -> Array:
        """Where points (k, 3) go."""
        clock = [time.perf_counter()]
        embedding = embed(self._rest, points)
        clock.append(time.perf_counter())
        moved = embedding.deform(self._current)
        clock.append(time.perf_counter())
        self.inside = int(embedding.inside.sum())
        self.seconds = {"embed": clock[1] - clock[0], "deform": clock[2] - clock[1]}
        return moved


def deformed(
    mesh: Mesh,
    rest: Lattice,
    current: Lattice,
    follow: bool = False,
    walls: Sequence[str] | None = None,
) -> tuple[Array, dict[str, Any]]:
    """(n, 3) points of a mesh, and figures: inside, seconds, and what the volume followed."""
    carrier = Carrier(rest, current)
    if not follow:
        points = carrier(mesh.points)
        return points, {"inside": carrier.inside, "seconds": carrier.seconds, "follow": None}
    from ffdstudio.meshes.following import METHOD, carry_walls

    begin = time.perf_counter()
    found = carry_walls(mesh, _within_bounds(mesh, carrier), walls or None)
    took = time.perf_counter() - begin - sum(carrier.seconds.values())
    figures = {"method": METHOD, "walls": list(found.walls), "steps": found.steps}
    seconds = {**carrier.seconds, "follow": took}
    return found.points, {"inside": carrier.inside, "seconds": seconds, "follow": figures}


def _within_bounds(mesh: Mesh, carrier: Carrier) -> Any:
    def move(points: Array) -> Array:
        moved = carrier(points)
        if not (np.abs(moved) < FARTHEST).all():
            raise InputError(f"{mesh.path}: the lattice moves points beyond {FARTHEST:g}")
        return moved

    return move


def check_motion(path: str, others: Sequence[str | Path], meshes: int) -> None:
    """Refuse a file for the solver's motion that cannot be meant."""
    if meshes > 1:
        raise InputError("--solver-motion writes the motion of one mesh")
    for other in others:
        if Path(path).absolute() == Path(other).absolute() or is_same(Path(path), other):
            raise InputError(f"{path}: the solver's motion needs a file of its own")


def write_motion(mesh: Mesh, path: str, points: Array, walls: Sequence[str] | None) -> None:
    """Write where the walls go, for the solver's own deformation."""
    from ffdstudio.meshes.following.roles import moved_boundaries, sliding_beside

    names = tuple(walls or moved_boundaries(mesh, points - mesh.points))
    write_solver_motion(mesh, path, points, names, sliding_beside(mesh, names) if names else ())
