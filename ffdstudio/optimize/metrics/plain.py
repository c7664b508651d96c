"""No metric: control points as they are."""

from __future__ import annotations

from ffdstudio.optimize.metrics.l2 import L2


class Plain(L2):
    """Variables are displacements of control points; what is measured is measured in L2."""

    name = "none"
    title = "None: plain control points"
    plain = True
