"""The distance of a surface in 3D to another one, as a row of the catalog."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import msgspec
import numpy as np
from msgspec import Meta

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice, embed
from ffdstudio.optimize.geometry.surfaces import surface_of
from ffdstudio.optimize.objectives.base import Objective
from ffdstudio.optimize.objectives.distance import Distance, SurfaceDistance
from ffdstudio.optimize.spec.fields import Text, says
from ffdstudio.optimize.spec.goals import ObjectiveSpec, moved_file
from ffdstudio.optimize.spec.rows import Part

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.shapes import Shape

Counts = tuple[
    Annotated[int, Meta(ge=2, le=1000)],
    Annotated[int, Meta(ge=2, le=1000)],
    Annotated[int, Meta(ge=2, le=1000)],
]
Degree = Annotated[int, Meta(ge=1, le=20)]
Move = tuple[float, float, float, float, float, float]


class DeformedSpec(Part, frozen=True, kw_only=True):
    """A lattice around the target that deforms it first."""

    table: ClassVar[str] = "objective.deformed"

    shape: Annotated[Counts, says("Control points", "of each direction")]
    degrees: Annotated[
        tuple[Degree, Degree, Degree] | None,
        says("Degrees", "of each direction; without, 3 or what the control points allow"),
    ] = None
    moves: Annotated[
        Annotated[tuple[Move, ...], Meta(min_length=1)],
        says("Moves", "of control points, [[i, j, k, dx, dy, dz], ...]"),
    ]

    def __post_init__(self) -> None:
        for move in self.moves:
            index = tuple(map(int, move[:3]))
            inside = all(0 <= k < n for k, n in zip(index, self.shape, strict=True))
            if index != move[:3] or not inside:
                raise ValueError(f"moves: there is no control point {list(move[:3])}")

    def of(self, points: Array) -> Array:
        """(n, 3) points moved by the lattice."""
        rest = Lattice.around(points, self.shape, self.degrees)
        control = rest.control_points.copy()
        for *index, dx, dy, dz in self.moves:
            control[tuple(map(int, index))] += np.array([dx, dy, dz])
        return embed(rest, points).deform(rest.moved(control))


class SurfaceSpec(ObjectiveSpec, frozen=True, kw_only=True, tag="surface"):
    """Match a surface in 3D: half the mean squared distance of the points to it."""

    title = "Match a surface"
    needs = "surface"
    residuals = True

    target: Annotated[Text, says("Target", "mesh of triangles and quads", file=True)]
    deformed: Annotated[
        DeformedSpec | None,
        says("Deformed", "a lattice around the target deforms it first", form=False),
    ] = None

    def moved(self, change: Callable[[str], str]) -> Self:
        """See `ObjectiveSpec`."""
        return msgspec.structs.replace(self, target=moved_file(self.target, change))

    def build(self, shape: Shape, place: Place) -> Objective:
        """See `ObjectiveSpec`."""
        points, triangles = surface_of(place.found(self.target))
        if self.deformed is not None:
            points = self.deformed.of(points)
        return SurfaceDistance(points, triangles)

    def judged(self, objective: Objective, place: Place) -> Distance:
        """See `ObjectiveSpec`: the distance itself."""
        assert isinstance(objective, Distance)
        return objective
