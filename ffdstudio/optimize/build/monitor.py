"""How far a shape is from its target, measured on points of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.embedding import Embedding
from ffdstudio.engine.spaces import in_space_of
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.geometry.sections import kulfan_tolerance
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.objectives.distance import ContourDistance, Distance

Array = NDArray[np.float64]


@dataclass
class ErrorMonitor:
    """Measures the errors of a lattice on points that the objective does not see.

    Attributes
    ----------
    shape : Shape
    embedding : Embedding
        Of the points in the lattice at rest.
    distance : Distance or None
        To the target shape, if there is one.
    """

    shape: Shape
    embedding: Embedding
    distance: Distance | None = None
    _latest: Embedding | None = field(default=None, repr=False)

    @classmethod
    def of(cls, shape: Shape, rest: Lattice, target: Contour | Distance | None) -> ErrorMonitor:
        """Monitor of a shape in a lattice at rest."""
        if isinstance(target, Contour):
            target = ContourDistance(target, upper_side(shape.in_chords(shape.dense)))
        points = shape.dense if target is not None else shape.points[:0]
        return cls(shape, embed(rest, points), target)

    def rest_of(self, current: Lattice) -> Lattice:
        """The lattice at rest in the space of a refined one."""
        return in_space_of(self.embedding.lattice, current)

    def deformed(self, current: Lattice) -> Array:
        """(n, 3) points under a lattice."""
        latest = self._latest
        if latest is None or not latest.lattice.same_space(current):
            latest = self._latest = self.embedding.refined(self.rest_of(current))
        return latest.deform(current)

    def errors(self, current: Lattice) -> Array:
        """(n,) signed orthogonal errors, in chords if it is a section."""
        assert self.distance is not None
        return self.distance.distances(self.shape.in_chords(self.deformed(current)))[0]

    def figures(self, current: Lattice) -> dict[str, float]:
        """RMS and largest error, and Kulfan's ratio of a section."""
        if self.distance is None:
            return {}
        points = self.shape.in_chords(self.deformed(current))
        error = np.abs(self.distance.distances(points)[0])
        found = {"rms": float(np.sqrt(np.mean(error**2))), "max_error": float(error.max())}
        if self.shape.flat:
            found["kulfan_ratio"] = float((error / kulfan_tolerance(points[:, 0])).max())
        return found
