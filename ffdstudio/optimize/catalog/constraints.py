"""Constraints: one line for each."""

from __future__ import annotations

from ffdstudio.optimize.constraints.area import AreaLimit
from ffdstudio.optimize.constraints.displacement import DisplacementLimit
from ffdstudio.optimize.constraints.lift import LiftLimit, MomentLimit
from ffdstudio.optimize.constraints.nose_radius import NoseRadiusLimit
from ffdstudio.optimize.constraints.thickness import MaxThicknessLimit, ThicknessLimit
from ffdstudio.optimize.constraints.trailing_edge_angle import TrailingEdgeAngleLimit
from ffdstudio.optimize.constraints.volume import VolumeLimit
from ffdstudio.optimize.spec.limits import ConstraintSpec

CONSTRAINTS: tuple[type[ConstraintSpec], ...] = (
    LiftLimit,
    MomentLimit,
    ThicknessLimit,
    MaxThicknessLimit,
    AreaLimit,
    VolumeLimit,
    NoseRadiusLimit,
    TrailingEdgeAngleLimit,
    DisplacementLimit,
)
