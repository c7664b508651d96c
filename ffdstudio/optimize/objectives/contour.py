"""The distance of a section to another one, as a row of the catalog."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Literal, Self

import msgspec

from ffdstudio.optimize.geometry.contour import Contour, upper_side
from ffdstudio.optimize.geometry.sections import kulfan_tolerance
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.distance import ContourDistance
from ffdstudio.optimize.spec.fields import Text, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec, moved_file

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape


class ContourSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="contour"):
    """Match a contour: half the mean squared distance to a section, upper side to upper side."""

    title = "Match a contour"
    needs = "section"
    residuals = True
    by_points = True

    target: Annotated[
        Text, says("Target", "section: a file, or a name such as naca2412", file=True)
    ]
    unit: Annotated[
        Literal["chord", "tolerance"],
        says("Unit", "of the distance: the chord, or Kulfan's tolerance, 4e-4 of the chord for "
             "x < 0.2 and 8e-4 aft of it"),
    ] = "chord"  # fmt: skip

    @property
    def aim(self) -> str:
        """See `ObjectiveSpec`."""
        return self.target

    def contour(self, place: Place) -> Contour:
        """See `ObjectiveSpec`."""
        return place.contour(self.target)

    def moved(self, change: Callable[[str], str]) -> Self:
        """See `ObjectiveSpec`."""
        return msgspec.structs.replace(self, target=moved_file(self.target, change))

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`."""
        local = shape.local
        unit = kulfan_tolerance(local[:, 0]) if self.unit == "tolerance" else None
        return ContourDistance(self.contour(place), upper_side(local), unit)
