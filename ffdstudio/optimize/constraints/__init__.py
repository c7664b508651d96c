"""Constraints on the shape: one file for each quantity."""

from ffdstudio.optimize.constraints.area import Area
from ffdstudio.optimize.constraints.base import Constraint, Quantity, Relation, Values
from ffdstudio.optimize.constraints.displacement import Displacement
from ffdstudio.optimize.constraints.lift import Lift, Moment
from ffdstudio.optimize.constraints.nose_radius import NoseRadius
from ffdstudio.optimize.constraints.thickness import MaxThickness, Thickness
from ffdstudio.optimize.constraints.volume import Volume

__all__ = [
    "Area",
    "Constraint",
    "Displacement",
    "Lift",
    "MaxThickness",
    "Moment",
    "NoseRadius",
    "Quantity",
    "Relation",
    "Thickness",
    "Values",
    "Volume",
]
