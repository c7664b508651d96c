"""Radius of the nose of a section."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.limits import ConstraintSpec


class NoseRadius(Quantity):
    """Radius of the circle through the foremost point and its two neighbours.

    Circumscribed circle of a triangle: abc / (4 area); derivatives by the chain rule.
    """

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        nose = int(np.clip(np.argmin(points[:, 0]), 1, len(points) - 2))
        corner = points[nose - 1 : nose + 2, :2]
        rows = np.zeros_like(points)
        radius, rows[nose - 1 : nose + 2, :2] = _circle(corner)
        return Values(np.array([radius]), rows.reshape(1, -1))


def _circle(p: Array) -> tuple[float, Array]:
    edges = np.roll(p, -1, axis=0) - p  # from corner k to corner k + 1
    lengths = np.linalg.norm(edges, axis=1)
    twice = float(edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0])
    radius = float(lengths.prod() / (2 * abs(twice)))
    by_log = np.zeros((3, 2))
    for k in range(3):
        pull = edges[k] / lengths[k] ** 2
        by_log[k] -= pull
        by_log[(k + 1) % 3] += pull
        ahead, behind = p[(k + 1) % 3], p[(k + 2) % 3]
        by_log[k] -= np.array([ahead[1] - behind[1], behind[0] - ahead[0]]) / twice
    return radius, radius * by_log


class NoseRadiusLimit(ConstraintSpec, frozen=True, kw_only=True, tag="nose-radius"):
    """Radius of the nose of a section, through its foremost points."""

    title = "Nose radius"
    needs = "section"

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        return NoseRadius()
