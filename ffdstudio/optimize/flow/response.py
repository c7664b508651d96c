"""How the pressures about a section answer to its points: a metric for any flow about it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.flow.panel import JACOBIAN_SOLVES, flow_about, is_solved
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
