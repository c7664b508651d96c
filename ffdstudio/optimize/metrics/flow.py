"""The flow's own metric."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.errors import InputError
from ffdstudio.optimize.metrics.h1 import H1

if TYPE_CHECKING:
    from ffdstudio.optimize.variables.metrics import Surface

SHARE = 1e-2  # of H1, each scaled by its 2-norm: what the pressures do not feel stays smooth


class Flow(H1):
    """What a displacement does to the pressures at the start, by a panel method, and some H1."""

    name = "flow"
    title = "Flow (its own)"
    responds = True

    def measure(self, surface: Surface, coordinates: NDArray[np.intp]) -> Any:
        """See `Metric`: the response above, a share of H1 below."""
        from scipy.sparse import csr_array, vstack

        if surface.response is None:
            raise InputError(
                "the metric flow needs an objective with a flow about a section, or the angles "
                "of one"
            )
        smooth = super().measure(surface, coordinates)
        count = surface.response.shape[1] // 3
        which = (3 * np.arange(count)[:, None] + coordinates).ravel()
        response = csr_array(surface.response)[:, which]
        if not response.nnz:
            raise InputError("the design variables do not move the section in its plane")
        scale = SHARE * two_norm(response) / two_norm(smooth)
        return vstack([response, scale * smooth]).tocsr()


def two_norm(matrix: Any) -> float:
    """Largest singular value of a sparse matrix.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> round(two_norm(csr_array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])), 9)
    4.0
    """
    from scipy.sparse.linalg import eigsh

    square = matrix.T @ matrix
    if min(square.shape) < 3:
        return float(np.linalg.norm(matrix.toarray(), 2))
    start = np.random.default_rng(0).standard_normal(square.shape[0])
    return float(np.sqrt(eigsh(square, k=1, v0=start, return_eigenvectors=False)[0]))
