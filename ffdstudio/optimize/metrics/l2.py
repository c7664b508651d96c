"""Mean square on the surface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ffdstudio.optimize.metrics.base import Metric

if TYPE_CHECKING:
    from ffdstudio.optimize.variables.metrics import Surface


class L2(Metric):
    """The mean square of a displacement: suits fits with many variables."""

    name = "l2"
    title = "L2"

    def factor(self, surface: Surface) -> Any:
        """See `Metric`: roots of the points' shares."""
        from scipy.sparse import diags_array

        return diags_array(np.sqrt(surface.mass)).tocsr()
