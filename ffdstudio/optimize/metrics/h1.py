"""Mean square and slopes on the surface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ffdstudio.optimize.metrics.l2 import L2

if TYPE_CHECKING:
    from ffdstudio.optimize.variables.metrics import Surface


class H1(L2):
    """The mean square of a displacement and of its slopes: steps stay smooth, as flows need."""

    name = "h1"
    title = "H1 (smooth)"
    slopes = True

    def factor(self, surface: Surface) -> Any:
        """See `Metric`."""
        from scipy.sparse import vstack

        return vstack([super().factor(surface), surface.slopes]).tocsr()
