"""Fair sections: little distance to a target, and a curvature that varies little.

Curvature is that of the circle through three neighbouring points, 4 area / (abc); what it varies
by is its difference over the arc between. The nose is left alone: it is there to be curved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from msgspec import Meta

from ffdstudio.aliases import Array, Indices, Mask
from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request
from ffdstudio.optimize.objectives.distance import ContourDistance
from ffdstudio.optimize.spec.fields import Text, Weight, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape


class Curvature(NamedTuple):
    """(n,) signed curvatures, and (n, 3, 2) derivatives by the points before, at and behind."""

    values: Array
    rows: Array

    @classmethod
    def of(cls, points: Array) -> Curvature:
        """Curvature at the inner points of an (n + 2, 2+) polygon.

        Examples
        --------
        >>> angle = np.linspace(0, 1, 5)
        >>> circle = 2 * np.column_stack([np.cos(angle), np.sin(angle)])
        >>> Curvature.of(circle).values.round(12)
        array([0.5, 0.5, 0.5])
        """
        a, b, c = points[:-2, :2], points[1:-1, :2], points[2:, :2]
        sides = (b - a, c - b, a - c)
        cross = sides[0][:, 0] * sides[1][:, 1] - sides[0][:, 1] * sides[1][:, 0]
        squares = [np.einsum("ij,ij->i", side, side) for side in sides]
        product = np.sqrt(squares[0] * squares[1] * squares[2])
        values = 2 * cross / product
        rows = np.empty((len(b), 3, 2))
        for k in range(3):
            ahead, behind = (b, c, a)[k], (c, a, b)[k]  # of corner k, around the triangle
            by_cross = np.column_stack([ahead[:, 1] - behind[:, 1], behind[:, 0] - ahead[:, 0]])
            leaving, coming = sides[k] / squares[k][:, None], sides[k - 1] / squares[k - 1][:, None]
            by_log = coming - leaving  # derivative of the logarithm of the product of the sides
            rows[:, k] = 2 * by_cross / product[:, None] - values[:, None] * by_log
        return cls(values, rows)


class FairContour(Objective):
    """Half the mean squared distance to a contour, and weight times that of d curvature / d s.

    Parameters
    ----------
    target : Contour
    upper : array_like
        (n,) whether a point belongs to the upper surface.
    weight : float
    aft_of : float
        Abscissa behind which the curvature is looked at.
    """

    abilities = Abilities(residuals=True)

    def __init__(self, target: Contour, upper: Mask, weight: float, aft_of: float) -> None:
        self.distance = ContourDistance(target, upper)
        self.root, self.aft_of = float(np.sqrt(weight)), aft_of

    def distances(self, points: Array) -> tuple[Array, Array]:
        """See `ContourDistance.distances`."""
        return self.distance.distances(points)

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        from scipy.sparse import vstack

        near = self.distance.answer(request)
        fair, rows = self.variation(request.points)
        residuals = np.concatenate([near.residuals, fair])
        sensitivity = vstack([near.sensitivity, rows]).tocsr()
        return Evaluation(
            0.5 * float(residuals @ residuals),
            np.asarray(residuals @ sensitivity).reshape(-1, 3),
            residuals,
            sensitivity,
            measures={"roughness": float(np.sqrt(fair @ fair) / (self.root or 1.0))},
        )

    def variation(self, points: Array) -> tuple[Array, Any]:
        """Weighted root mean squares of d curvature / d s, and sparse derivatives."""
        from scipy.sparse import csr_array

        bend = Curvature.of(points)
        first = self._aft(points)  # number of the inner point before each pair
        arc = np.linalg.norm(np.diff(points[1:-1, :2], axis=0), axis=1)[first]
        scale = self.root / np.sqrt(max(1, len(first)))
        values = scale * (bend.values[first + 1] - bend.values[first]) / arc
        entries: list[tuple[Array, Indices]] = []
        for k in range(3):
            entries += [(scale * bend.rows[first + 1, k] / arc[:, None], first + 1 + k)]
            entries += [(-scale * bend.rows[first, k] / arc[:, None], first + k)]
        along = np.diff(points[1:-1, :2], axis=0)[first] / arc[:, None] ** 2
        entries += [(-values[:, None] * along, first + 2), (values[:, None] * along, first + 1)]
        number = np.repeat(np.arange(len(first)), 2)
        parts = [
            csr_array((block.ravel(), (number, _coordinates(nodes))), (len(first), points.size))
            for block, nodes in entries
        ]
        return values, sum(parts[1:], parts[0])

    def _aft(self, points: Array) -> Indices:
        x = points[:, 0]
        both = np.minimum(x[1:-2], x[2:-1]) >= self.aft_of
        return np.flatnonzero(both)


def _coordinates(nodes: Indices) -> Indices:
    """Numbers of x and y of nodes among all coordinates."""
    found: Indices = (3 * nodes[:, None] + np.array([0, 1])).ravel()
    return found


class FairContourSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="fair-contour"):
    """Match a contour fairly: the distance, and a weight times the variation of the curvature.

    The cost is half the mean squared distance plus half the weight times the mean of the squared
    d curvature / d s aft of a place, all in chords.
    """

    title = "Match a contour fairly"
    needs = "section"
    residuals = True
    by_points = True

    target: Annotated[
        Text, says("Target", "section: a file, or a name such as naca2412", file=True)
    ]
    weight: Annotated[Weight, says("Weight", "of the variation of the curvature")] = 1e-10
    aft_of: Annotated[
        Annotated[float, Meta(ge=0, lt=1)],
        says("Aft of", "abscissa behind which the curvature is looked at", "chords"),
    ] = 0.05

    @property
    def aim(self) -> str:
        """See `ObjectiveSpec`."""
        return self.target

    def contour(self, place: Place) -> Contour:
        """See `ObjectiveSpec`."""
        return place.contour(self.target)

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`."""
        upper = upper_side(shape.local)
        return FairContour(self.contour(place), upper, self.weight, self.aft_of)
