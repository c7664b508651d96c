"""One step: surfaces move from where they are, and the volume follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.following.constraints import Constraints, Motion, images, mirrors
from ffdstudio.meshes.following.field import Field
from ffdstudio.meshes.following.roles import Roles
from ffdstudio.meshes.following.rotations import Rotations, SurfaceEdges

LEAST_AREA = 1e-9  # of the mean area: for nodes of elements without extent
NEAR = 1 / 3  # of the extent of what moves
TOUCHING = 1e-100  # nearer nodes are at the same place
SHORT = 1e-12  # of the extent of all sources: edges no longer than that have no direction


@dataclass(frozen=True, eq=False)
class Sources:
    """Nodes that are told where to go, each place once.

    Attributes
    ----------
    nodes : numpy.ndarray
        (s,) one node of each place.
    areas : numpy.ndarray
        (s,) share of the surface.
    edges : numpy.ndarray
        (m, 2) indices into the sources.
    near : float
        Distance over which the volume moves with the nearest surface.
    """

    nodes: Indices
    areas: Array
    edges: Indices
    near: float

    @classmethod
    def of(cls, roles: Roles, points: Array) -> Sources:
        """Sources of a mesh at rest."""
        told = np.concatenate([roles.moving, roles.staying])
        flat = flattened(points, roles.normal)
        _, first, which = np.unique(flat[told], axis=0, return_index=True, return_inverse=True)
        place = np.full(len(points), -1)
        place[told] = which.ravel()
        areas = np.zeros(len(first))
        edges = []
        for nodes in roles.elements:
            share = _sizes(flat[nodes], roles.normal is not None) / nodes.shape[1]
            areas += np.bincount(place[nodes].ravel(), np.repeat(share, nodes.shape[1]), len(first))
            edges.append(np.stack([place[nodes], np.roll(place[nodes], -1, axis=1)], axis=-1))
        areas = np.maximum(areas, LEAST_AREA * (areas.mean() if areas.any() else 1.0))
        moving = flat[roles.moving]
        extent = float(np.ptp(moving, axis=0).max())
        whole = float(np.ptp(flat, axis=0).max())
        return cls(told[first], areas, _distinct(edges), NEAR * max(extent, 1e-3 * whole))


def flattened(points: Array, normal: Array | None) -> Array:
    """Points (n, 3) without what they are along the normal of a plane problem."""
    if normal is None:
        return points
    along = points @ normal
    return np.asarray(points - along[:, None] * normal)


class Stage:
    """A volume at rest with its surface, ready to follow a step of it.

    Parameters
    ----------
    roles : Roles
    sources : Sources
    constraints : Constraints
    points : numpy.ndarray
        (n, 3) where the step begins.
    """

    def __init__(
        self, roles: Roles, sources: Sources, constraints: Constraints, points: Array
    ) -> None:
        self._roles, self._sources, self._constraints = roles, sources, constraints
        self.points = points
        flat = flattened(points, roles.normal)
        self._places = flat[sources.nodes]
        edges, inside = self._long(sources.edges), mirrors(roles, sources.nodes)
        self._edges = SurfaceEdges(self._places, edges, roles.normal, inside)
        self._images: list[Motion] = images(roles)
        follows = np.ones(len(points), dtype=bool)
        follows[roles.moving] = follows[roles.staying] = False
        self._followers = np.flatnonzero(follows)
        targets, self._which = np.unique(flat[self._followers], axis=0, return_inverse=True)
        self._which = self._which.ravel()
        places = np.concatenate([self._places @ t.T + s for t, s in self._images])
        self._copies, self._of, self._apart = _coincident(places, targets)
        areas = np.tile(sources.areas, len(self._images))
        self._field = None
        if self._apart.any():
            self._field = Field(places, areas, targets[self._apart], sources.near)
        self._targets = len(targets)

    def _long(self, edges: Indices) -> Indices:
        if not len(edges):
            return edges
        length = np.abs(self._places[edges[:, 1]] - self._places[edges[:, 0]]).max(axis=1)
        return np.asarray(edges[length > SHORT * np.ptp(self._places, axis=0).max()])

    def turned(self, step: Array) -> Rotations:
        """Rotations of the sources by displacements (n, 3) of the told nodes."""
        return self._edges.rotations(self._places + self._flat_step(step))

    def moved(self, step: Array) -> Array:
        """(n, 3) places of all nodes, given displacements (n, 3) of those that are told."""
        at_sources, rotations = self._flat_step(step), self.turned(step)
        vectors = np.concatenate([at_sources @ t.T for t, _ in self._images])
        on_targets = np.zeros((self._targets, 3))
        if self._field is not None:
            turns = rotations.matrices - np.eye(3)
            matrices = np.concatenate([t @ turns @ t.T for t, _ in self._images])
            on_targets[self._apart] = self._field.displacements(matrices, vectors)
        on_targets[self._copies] = vectors[self._of]
        out = step.copy()
        out[self._followers] = on_targets[self._which]
        self._constraints.apply(out)
        return np.asarray(self.points + out)

    def pull(self, gradient: Array, step: Array) -> Array:
        """(n, 3) derivative by the displacements of the told nodes; zero at all others."""
        out = gradient.copy()
        self._constraints.pull(out)
        on_targets = np.column_stack([
            np.bincount(self._which, column, self._targets) for column in out[self._followers].T
        ])  # fmt: skip
        out[self._followers] = 0.0
        many = len(self._places)
        vectors = np.zeros((many * len(self._images), 3))
        np.add.at(vectors, self._of, on_targets[self._copies])
        at_sources = np.zeros_like(self._places)
        if self._field is not None:
            by_matrices, by_vectors = self._field.pull(on_targets[self._apart])
            vectors += by_vectors
            turns = np.zeros((many, 3, 3))
            for k, (t, _) in enumerate(self._images):
                turns += t.T @ by_matrices[k * many : (k + 1) * many] @ t
            at_sources += self.turned(step).pull(turns)
        for k, (t, _) in enumerate(self._images):
            at_sources += vectors[k * many : (k + 1) * many] @ t
        out[self._sources.nodes] += self._flat_step(at_sources, at_sources=True)
        return out

    def _flat_step(self, step: Array, at_sources: bool = False) -> Array:
        own = step if at_sources else step[self._sources.nodes]
        return flattened(own, self._roles.normal)


def _coincident(places: Array, targets: Array) -> tuple[Indices, Indices, np.ndarray]:
    """Targets that lie where a source is, its number, and the mask of all others."""
    from scipy.spatial import cKDTree

    if not len(targets):
        return np.empty(0, np.int64), np.empty(0, np.int64), np.zeros(0, dtype=bool)
    distance, nearest = cKDTree(places).query(targets, distance_upper_bound=TOUCHING)
    apart = ~np.isfinite(distance)
    return np.flatnonzero(~apart), np.asarray(nearest)[~apart], apart


def _sizes(corners: Array, plane: bool) -> Array:
    """(k,) lengths or areas of elements (k, corners, 3)."""
    if corners.shape[1] == 2 or plane:
        return np.asarray(np.linalg.norm(np.ptp(corners, axis=1), axis=1))
    fan = corners[:, 1:] - corners[:, :1]
    return np.asarray(np.linalg.norm(np.cross(fan[:, :-1], fan[:, 1:]).sum(axis=1), axis=1) / 2)


def _distinct(edges: list[Indices]) -> Indices:
    """SurfaceEdges, each once; those between one and the same source left out."""
    if not edges:
        return np.empty((0, 2), dtype=np.int64)
    every = np.sort(np.concatenate([part.reshape(-1, 2) for part in edges]), axis=1)
    return np.unique(every[every[:, 0] != every[:, 1]], axis=0)
