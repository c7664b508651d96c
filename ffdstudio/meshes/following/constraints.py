"""Nodes that slide in planes and partners that move alike: exact, and with their transpose."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.following.roles import Roles

Motion = tuple[Array, Array]  # (3, 3) turn and (3,) shift
SQUARE = 1e-6  # cosine below which planes count as at right angles


class Constraints:
    """What displacements of nodes that follow have to meet, applied in place."""

    def __init__(self, roles: Roles, count: int) -> None:
        free = np.ones(count, dtype=bool)
        free[roles.moving] = free[roles.staying] = False
        self._normals: list[tuple[Indices, Array]] = []
        basis = np.zeros((count, 0, 3)) if not roles.planes else np.zeros((count, 3, 3))
        rank = np.zeros(count, dtype=np.int64)
        for plane in roles.planes:
            nodes = plane.nodes[free[plane.nodes] & (rank[plane.nodes] < 3)]
            rest = np.tile(plane.normal, (len(nodes), 1))
            for k in range(3):  # what is left of the normal beside those of earlier planes
                known = basis[nodes, k]
                rest = rest - (rest * known).sum(axis=1, keepdims=True) * known
            size = np.linalg.norm(rest, axis=1)
            new = size > SQUARE
            nodes, rest = nodes[new], rest[new] / size[new, None]
            basis[nodes, rank[nodes]] = rest
            rank[nodes] += 1
            self._normals.append((nodes, rest))
        self._pairs = [
            (pair.first[free[pair.second]], pair.second[free[pair.second]], pair.turn)
            for pair in roles.pairs
        ]

    def apply(self, step: Array) -> None:
        """Make displacements (n, 3) meet planes and partners."""
        for nodes, normals in self._normals:
            step[nodes] -= (step[nodes] * normals).sum(axis=1, keepdims=True) * normals
        for first, second, turn in self._pairs + self._pairs[:-1]:
            step[second] = _turned(step[first], turn)

    def pull(self, gradient: Array) -> None:
        """Transpose of `apply`, in place."""
        for first, second, turn in reversed(self._pairs + self._pairs[:-1]):
            taken = gradient[second].copy()
            gradient[second] = 0.0
            np.add.at(gradient, first, taken @ turn)
        for nodes, normals in reversed(self._normals):
            gradient[nodes] -= (gradient[nodes] * normals).sum(axis=1, keepdims=True) * normals


def _turned(step: Array, turn: Array) -> Array:
    return step.copy() if np.array_equal(turn, np.eye(3)) else step @ turn.T


def images(roles: Roles) -> list[Motion]:
    """Motions under which the field is the same: none first, then mirrors and periods.

    Mirrors at right angles are combined, and those of an `empty` plane left out: what lies
    between two of them is a plane problem.
    """
    found: list[Motion] = [(np.eye(3), np.zeros(3))]
    planes = [] if roles.normal is not None else _distinct(roles)
    single = [_mirror(normal, offset) for normal, offset in planes]
    found += single
    for i, (normal, _) in enumerate(planes):
        for j in range(i):
            if abs(normal @ planes[j][0]) < SQUARE:
                found.append(_then(single[i], single[j]))
    for pair in roles.pairs:
        if not pair.opposite:
            found += [(pair.turn, pair.shift), (pair.turn.T, -pair.turn.T @ pair.shift)]
    return found


def mirrors(roles: Roles, nodes: Indices) -> list[tuple[Indices, Array]]:
    """Which of these nodes lie in each mirror, and its (3, 3) reflection."""
    if roles.normal is not None:
        return []
    found = []
    for normal, offset in _distinct(roles):
        members = [p.nodes for p in roles.planes if _same(p.normal, p.offset, normal, offset)]
        inside = np.isin(nodes, np.concatenate(members))
        found.append((np.flatnonzero(inside), _mirror(normal, offset)[0]))
    return found


def _same(n: Array, o: float, m: Array, q: float) -> bool:
    """Whether two planes are one; normals have their largest component positive."""
    return abs(float(n @ m)) > 1 - 1e-9 and abs(o - q) <= 1e-9 * (1 + abs(q))


def _distinct(roles: Roles) -> list[tuple[Array, float]]:
    found: list[tuple[Array, float]] = []
    for plane in roles.planes:
        if plane.kind == "empty" and roles.normal is not None:
            continue
        if not any(_same(plane.normal, plane.offset, n, o) for n, o in found):
            found.append((plane.normal, plane.offset))
    return found


def _mirror(normal: Array, offset: float) -> Motion:
    return np.eye(3) - 2 * np.outer(normal, normal), 2 * offset * normal


def _then(first: Motion, second: Motion) -> Motion:
    return second[0] @ first[0], second[0] @ first[1] + second[1]
