"""A task with meshes that follow: its metric feels their strain, and no trial may invert a cell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.engine import Lattice, embed
from ffdstudio.meshes.ways import Way
from ffdstudio.optimize.constraints import Constraint
from ffdstudio.optimize.followers.body import FollowingMesh, crosses, moved_walls
from ffdstudio.optimize.followers.seen import SeenObjective, SeenQuantity, padded
from ffdstudio.optimize.followers.strain import CellEdges, edges_of
from ffdstudio.optimize.followers.through import ThroughWalls
from ffdstudio.optimize.objectives.base import Response
from ffdstudio.optimize.runs.study import Task
from ffdstudio.optimize.variables.rules import Rules

SHARE = 0.1  # of the strain energy, beside the surface's own terms


def with_followers(task: Task, bodies: Sequence[FollowingMesh], share: float = SHARE) -> Task:
    """Task that keeps bodies valid which follow, and whose metric feels their strain.

    Parameters
    ----------
    task : Task
    bodies : sequence of FollowingMesh
        Bound to the task's lattice at rest. The volume of one that reaches out of the lattice
        follows its walls if its way is "walls", and has no part in the metric; others are carried.
    share : float
        Of the scaled strain energy of what is carried; 0 leaves the metric as it is.
    """
    rest = task.embedding.lattice
    points, followers = [task.embedding.points], []
    strains: list[tuple[Any, int]] = []
    first, extent = len(task.embedding.points), _extent(task)
    for body in bodies:
        edges = edges_of(body.mesh)
        if not len(edges.nodes):
            continue
        followers.append(body)
        if body.way is Way.WALLS and crosses(body.embedding, edges.nodes):
            body.walls = moved_walls(body.mesh, body.embedding, _probed(rest, task.rules))
        if body.walls is not None:
            task = _through_walls(task, body)
            continue
        rows, nodes = _rows(edges, body, share * extent**2)
        strains.append((rows, first))
        points.append(body.start[nodes])
        first += len(nodes)
    task = replace(task, followers=tuple(followers))
    if not strains or share == 0:
        return task
    return _seen(task, np.concatenate(points), strains)


def _through_walls(task: Task, body: FollowingMesh) -> Task:
    """The task, whose objective sees the nodes as they follow if it sees all of the body."""
    if not np.array_equal(body.start, task.embedding.points):
        return task
    body.in_one_step = task.objective.abilities.gradient
    return replace(task, objective=ThroughWalls(task.objective, body))


def _probed(rest: Lattice, rules: Rules) -> Lattice:
    """The lattice with its movable points displaced a little, wherever it extends."""
    movable = np.asarray(rules.movable(rest.shape) & ~rules.held(rest.shape))
    extent = np.ptp(rest.control_points.reshape(-1, 3), axis=0)
    return rest.moved(rest.control_points + 1e-3 * movable[..., None] * extent)


def _extent(task: Task) -> float:
    seen = task.embedding.points[task.surface.mass > 0]
    return float(np.ptp(seen if len(seen) else task.embedding.points, axis=0).max())


def _rows(edges: CellEdges, body: FollowingMesh, scale: float) -> tuple[Any, Indices]:
    """Rows of the edges within the lattice, over the volume that they stand for."""
    near = edges.among(body.embedding.inside)
    volume = float((near.weights * near.lengths**2).sum()) / _directions(body)
    return near.sampled().rows(scale / volume if volume > 0 else 0.0)


def _directions(body: FollowingMesh) -> int:
    from ffdstudio.meshes.measures.blocks import blocks_of

    return blocks_of(body.mesh).dimension


def _seen(task: Task, points: Array, strains: list[tuple[Any, int]]) -> Task:
    """The task on its points and, behind them, those of the bodies that follow."""
    from scipy.sparse import csr_array, vstack

    count, total = len(task.embedding.points), len(points)

    def placed(rows: Any, first: int) -> Any:
        part = rows.tocoo()
        row, column = part.coords
        return csr_array((part.data, (row, column + first)), (part.shape[0], total))

    slopes = task.surface.slopes.tocsr(copy=True)
    slopes.resize(slopes.shape[0], total)
    strain = vstack([placed(rows, first) for rows, first in strains]).tocsr()
    mass = np.concatenate([task.surface.mass, np.zeros(total - count)])
    constraints: list[Constraint] = [
        replace(c, quantity=SeenQuantity(c.quantity, count)) for c in task.constraints
    ]
    return replace(
        task,
        objective=SeenObjective(task.objective, count, total),
        embedding=embed(task.embedding.lattice, points),
        surface=task.surface._replace(mass=mass, slopes=slopes, strain=strain),
        constraints=constraints,
        response=_response(task, count, total),
        seen=count,
    )


def _response(task: Task, count: int, total: int) -> Callable[[Array], Response | None] | None:
    given = task.response
    return None if given is None else lambda points: padded(given(points[:count]), total)
