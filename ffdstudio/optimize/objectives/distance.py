"""Distance to a target: an airfoil contour in 2D, a triangulated surface in 3D."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Mask
from ffdstudio.errors import InputError
from ffdstudio.optimize.geometry.contour import Contour
from ffdstudio.optimize.geometry.nearest import Triangles
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request


class Distance(Objective):
    """A cost that is made of distances."""

    abilities = Abilities(residuals=True)

    @abstractmethod
    def distances(self, points: Array) -> tuple[Array, Array]:
        """(n,) signed distances and (n, 3) their derivatives by the points."""


class ContourDistance(Distance):
    """Half the mean squared distance of points to the same surface of a contour.

    Parameters
    ----------
    target : Contour
    upper : array_like
        (n,) whether a point belongs to the upper surface.
    unit : array_like, optional
        (n,) lengths that the residuals are measured in, 1 by default.

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 60)
    >>> circle = Contour(0.5 + 0.5 * np.column_stack([np.cos(angle), np.sin(angle)]))
    >>> objective = ContourDistance(circle, [True])
    >>> round(objective.evaluate(np.array([[0.5, 1.1, 0.0]])).value, 6)
    0.005
    """

    abilities = Abilities(residuals=True)

    def __init__(self, target: Contour, upper: ArrayLike, unit: ArrayLike | None = None) -> None:
        self.target = target
        self.unit = None if unit is None else np.asarray(unit, dtype=np.float64)
        self.upper: Mask = np.asarray(upper, dtype=bool)

    def distances(self, points: Array) -> tuple[Array, Array]:
        """(n,) signed distances and (n, 3) their derivatives by the points."""
        foot = self.target.nearest(points, self.upper)
        return foot.distance, np.column_stack([foot.direction, np.zeros(len(points))])

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        distance, direction = self.distances(request.points)
        if self.unit is not None:
            distance, direction = distance / self.unit, direction / self.unit[:, None]
        return _half_mean_square(distance, direction)


class SurfaceDistance(Distance):
    """Half the mean squared distance of points to a triangulated surface.

    Parameters
    ----------
    points : array_like
        (m, 3) points of the target.
    triangles : array_like
        (k, 3) indices into them.
    """

    abilities = Abilities(residuals=True)

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        self.target = Triangles(points, triangles)

    def distances(self, points: Array) -> tuple[Array, Array]:
        """(n,) signed distances and (n, 3) their derivatives by the points."""
        return self.target.nearest(points)

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        return _half_mean_square(*self.distances(request.points))


class PointDistance(Objective):
    """Half the mean squared distance of points to given places, one for each.

    Parameters
    ----------
    target : array_like
        (n, 3).
    """

    abilities = Abilities(residuals=True)

    def __init__(self, target: ArrayLike) -> None:
        self.target = np.asarray(target, dtype=np.float64)

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        from scipy.sparse import identity

        points = request.points
        if points.shape != self.target.shape:
            raise InputError(
                f"the target has {len(self.target)} points, the shape has {len(points)}"
            )
        gap, scale = points - self.target, 1 / np.sqrt(len(points))
        residuals = gap.ravel() * scale
        sensitivity = identity(gap.size, format="csr") * scale
        return Evaluation(
            0.5 * float(residuals @ residuals), gap / len(gap), residuals, sensitivity
        )


def _half_mean_square(distance: Array, direction: Array) -> Evaluation:
    count = len(distance)
    residuals = distance / np.sqrt(count)
    return Evaluation(
        0.5 * float(residuals @ residuals),
        distance[:, None] * direction / count,
        residuals,
        _by_points(direction / np.sqrt(count)),
    )


def _by_points(rows: Array) -> Any:
    """Sparse (n, 3 n): row k has the three entries of point k."""
    from scipy.sparse import csr_array

    count = len(rows)
    return csr_array((rows.ravel(), np.arange(3 * count), 3 * np.arange(count + 1)))
