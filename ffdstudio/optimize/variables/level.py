"""One level of refinement: the objective as a function of whitened variables.

With fixed weights the surface points follow the variables linearly (else see `weights`), so a
level holds one dense matrix from variables to displacements; nothing is embedded again when a
level is refined.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.embedding import Embedding
from ffdstudio.engine.jacobians import jacobian
from ffdstudio.optimize.metrics.base import Metric
from ffdstudio.optimize.metrics.h1 import H1
from ffdstudio.optimize.variables.metrics import Surface, Whitening, with_strain
from ffdstudio.optimize.variables.space import DesignSpace, Insertion

CONTROL_SHARE = 0.1  # of the displacements of control points, beside those of the surface
BENDING = 1e-4  # of second differences across rows: mild enough to leave the errors as they are


@dataclass(frozen=True)
class EmbeddedBody:
    """The points that an objective sees: bound to a lattice, and connected to a surface.

    Attributes
    ----------
    embedding : Embedding
        In the lattice at rest, before any refinement.
    surface : Surface
        Of the undeformed points.
    metric : Metric
    """

    embedding: Embedding
    surface: Surface
    metric: Metric = field(default_factory=H1)
    _known: dict[tuple[int, ...], Any] = field(default_factory=dict, repr=False, compare=False)

    def measure(self, coordinates: NDArray[np.intp]) -> Any:
        """Factor of the metric for displacements along some coordinates, made once."""
        key = tuple(coordinates.tolist())
        if key not in self._known:
            self._known[key] = self.strained(self.metric, coordinates)
        return self._known[key]

    def strained(self, metric: Metric, coordinates: NDArray[np.intp]) -> Any:
        """Factor of a metric, with the strain of bodies that follow below it."""
        factor = metric.measure(self.surface, coordinates)
        return with_strain(factor, metric, self.surface, coordinates)


class Level:
    """Variables z of one design space; z = 0 is the shape that the level began with."""

    def __init__(self, body: EmbeddedBody, space: DesignSpace, points: Array) -> None:
        self.body, self.space, self.points = body, space, points
        self.coordinates = self.moving()
        self.fields = self.tangent(np.zeros(space.size))
        self.factor = body.measure(self.coordinates)
        self.white = Whitening.of(self.factor @ self.fields, plain=body.metric.plain)
        self.shapes = self.fields @ self.white.matrix

    @classmethod
    def first(cls, body: EmbeddedBody, space: DesignSpace) -> Self:
        """Level of a space whose lattice may already be deformed."""
        shares = jacobian(space.lattice, body.embedding.parameters, body.embedding.inside)
        return cls(body, space, body.embedding.points + shares @ space.displacements)

    def refined(self, insertions: list[Insertion], z: Array) -> tuple[Self, Any]:
        """Level with knots inserted around z, and the map of z-steps into it."""
        space: DesignSpace = self.space.around(self.white.matrix @ z)
        carry: Any = None
        for new in insertions:
            space, matrix = space.refined(new)
            carry = matrix if carry is None else matrix @ carry
        finer = type(self)(self.body, space, self.at(z))
        return finer, finer.white.inverse @ (carry @ self.white.matrix)

    @cached_property
    def on_surface(self) -> NDArray[np.bool_]:
        """(n,) points that are of the surface, not of a body that follows."""
        mask = np.asarray(self.body.surface.mass > 0)
        return mask if mask.any() else np.ones(len(mask), dtype=bool)

    @cached_property
    def moves(self) -> Array:
        """(k, size) displacements of the surface's points by the variables."""
        return np.asarray(self.shapes[np.repeat(self.on_surface, len(self.coordinates))])

    @property
    def size(self) -> int:
        """Number of whitened variables."""
        return int(self.shapes.shape[1])

    def moving(self) -> NDArray[np.intp]:
        """Coordinates that the variables move."""
        moving = np.abs(np.array(self.space.rules.directions)).max(axis=0) > 0
        return np.flatnonzero(moving)

    def tangent(self, y: Array) -> Array:
        """(n * coordinates, N) derivatives of the points by the variables: the same at any y."""
        return self.moved_by(self.space.basis, self.space.lattice)

    def shapes_at(self, z: Array) -> Array:
        """(n * coordinates, size) derivatives of the points by z: the same at any z."""
        return self.shapes

    def moved_by(self, basis: Any, current: Lattice) -> Array:
        """(n * coordinates, N) displacements of the surface by columns of control points."""
        shares = jacobian(current, self.parameters, self.body.embedding.inside)
        parts = [(shares @ basis[k::3]).toarray() for k in self.coordinates]
        return np.stack(parts, axis=1).reshape(-1, basis.shape[1])

    @property
    def parameters(self) -> Array:
        """(n, d) parametric coordinates of the points."""
        return self.body.embedding.parameters

    @property
    def framed(self) -> Array:
        """(n * coordinates, r) displacements that are orthonormal in the metric."""
        if not self.body.metric.plain:
            return self.shapes
        coordinates = np.linalg.lstsq(self.factor @ self.fields, self.white.frame, rcond=None)[0]
        result: Array = self.fields @ coordinates
        return result

    @cached_property
    def displacement_cost(self) -> Array:
        """(k, size) factor of what displacements cost where nothing else fixes them.

        The squared displacement of the surface in H1, so that a patch rather moves as a whole
        than folds, and a tenth of the mean squared one of the control points, for some of them
        hardly move the surface.
        """
        metric = self.body.strained(H1(), self.coordinates)
        own = np.sqrt(CONTROL_SHARE / len(self.white.matrix)) * self.white.matrix
        return np.vstack([np.linalg.qr(metric @ self.shapes, mode="r"), own])

    @cached_property
    def bending_cost(self) -> Array:
        """(k, size) factor of what bending costs across the rows of a section's lattice.

        Root mean squares of second differences of displacements, over three rows or more: the
        two surfaces of a section hardly feel the rows between.
        """
        shape = self.space.rest.shape
        moves = (self.space.basis @ self.white.matrix).reshape(*shape, 3, -1)
        bends = np.diff(moves, n=2, axis=1)
        result: Array = np.sqrt(BENDING / len(self.white.matrix)) * bends.reshape(-1, self.size)
        return result

    def at(self, z: Array) -> Array:
        """(n, 3) points."""
        out = self.points.copy()
        out[:, self.coordinates] += (self.shapes @ z).reshape(-1, len(self.coordinates))
        return out

    def flat(self, vectors: Array) -> Array:
        """(n * coordinates,) of (n, 3) vectors: what the variables can feel."""
        return vectors[:, self.coordinates].ravel()

    def pull(self, gradient: Array, z: Array | None = None) -> Array:
        """Derivative by z, at z, from the (n, 3) derivative by the points."""
        return self.flat(gradient) @ self.shapes

    def columns(self, sensitivity: Any) -> Any:
        """Columns of an (m, 3 n) sparse matrix that belong to coordinates that move."""
        which = (3 * np.arange(len(self.points))[:, None] + self.coordinates).ravel()
        return sensitivity.tocsc()[:, which].tocsr()
