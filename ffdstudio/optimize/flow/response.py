"""How the pressures about a section answer to its points: a metric for any flow about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.optimize.flow.panel import JACOBIAN_SOLVES, flow_about, is_solved
from ffdstudio.optimize.geometry.chord import UNIT, Chord
from ffdstudio.optimize.objectives.base import Response


def pressure_response(points: Array, angles: Sequence[float]) -> Response:
    """Derivatives of the pressures by the points, over the root of their number.

    Its square measures a displacement by the mean square of the change of Cp, so that the
    Hessian of half a mean square of Cp is the identity near its least value.

    Parameters
    ----------
    points : numpy.ndarray
        (n, 3) section of chord 1 in Selig order.
    angles : sequence of float
        Angles of attack in degrees.

    Examples
    --------
    >>> from ffdstudio.optimize.geometry.sections import sampled
    >>> pressure_response(sampled("naca0012", 41), [0.0, 2.0]).matrix.shape
    (80, 123)
    """
    new = not is_solved(points)
    by_nodes = flow_about(points, tuple(angles)).pressure_jacobian()
    angles_, panels, nodes, _ = by_nodes.shape
    matrix = np.zeros((angles_ * panels, nodes, 3))
    matrix[..., :2] = by_nodes.reshape(-1, nodes, 2) / np.sqrt(angles_ * panels)
    return Response(matrix.reshape(len(matrix), -1), JACOBIAN_SOLVES * angles_ + new)


@dataclass(frozen=True)
class SectionResponse:
    """Response of a section among other points, for objectives that have none of their own.

    Attributes
    ----------
    angles : tuple of float
        Angles of attack in degrees.
    chord : Chord
        Where the section lies.
    contour : numpy.ndarray, optional
        Numbers of its points in Selig order; all of them by default. The trailing edge may
        stand at both ends.
    """

    angles: tuple[float, ...]
    chord: Chord = UNIT
    contour: Indices | None = None

    def __call__(self, points: Array) -> Response:
        """Response at (n, 3) points, by their coordinates."""
        from scipy.sparse import coo_array, csr_array

        nodes = np.arange(len(points)) if self.contour is None else self.contour
        found = pressure_response(self.chord.local(points[nodes]), self.angles)
        own = coo_array(found.matrix / self.chord.length)
        places = (3 * nodes[:, None] + np.arange(3)).ravel()[own.coords[1]]
        shape = (own.shape[0], 3 * len(points))
        return Response(csr_array((own.data, (own.coords[0], places)), shape), found.solves)
