"""The metric that suits a study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.optimize.metrics.flow import Flow
from ffdstudio.optimize.metrics.h1 import H1

if TYPE_CHECKING:
    from ffdstudio.optimize.variables.metrics import Surface


class Suited(H1):
    """The flow's own where the objective has a flow by the panel method, and H1 elsewhere."""

    name = "auto"
    title = "Auto: the flow's own, or H1"
    responds = True

    def measure(self, surface: Surface, coordinates: NDArray[np.intp]) -> Any:
        """See `Metric`."""
        if surface.response is None:
            return super().measure(surface, coordinates)
        return Flow().measure(surface, coordinates)
