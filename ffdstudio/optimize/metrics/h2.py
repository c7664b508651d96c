"""Mean square, slopes and bending on the surface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ffdstudio.optimize.metrics.h1 import H1

if TYPE_CHECKING:
    from ffdstudio.optimize.variables.metrics import Surface


class H2(H1):
    """The mean square of a displacement, of its slopes and of its bending: very smooth steps."""

    name = "h2"
    title = "H2 (very smooth)"

    def factor(self, surface: Surface) -> Any:
        """See `Metric`: bending is the weak Laplacian, K / sqrt(mass) with K = slopes' slopes."""
        from scipy.sparse import diags_array, vstack

        root = np.sqrt(surface.mass)
        inverse = np.divide(1.0, root, out=np.zeros_like(root), where=root > 0)
        bending = diags_array(inverse) @ (surface.slopes.T @ surface.slopes)
        return vstack([super().factor(surface), bending]).tocsr()
