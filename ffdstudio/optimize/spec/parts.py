"""The tables of a description that are the same for every kind of study."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from msgspec import Meta

from ffdstudio.optimize.spec.fields import (
    Axis,
    Count,
    Index,
    Letter,
    Positive,
    Text,
    Weight,
    distinct,
    says,
)  # fmt: skip
from ffdstudio.optimize.spec.rows import Part

EACH = Meta(min_length=1, max_length=3)
Counts = Annotated[tuple[Annotated[int, Meta(ge=2, le=1000)], ...], EACH]
Degrees = Annotated[tuple[Annotated[int, Meta(ge=1, le=20)], ...], EACH]
Corner = Annotated[tuple[float, ...], Meta(min_length=2, max_length=3)]
ControlPoint = Annotated[tuple[Index, ...], Meta(min_length=1, max_length=3)]
Vector = tuple[float, float, float]


class ShapeSpec(Part, frozen=True, kw_only=True):
    """What is optimized.

    `source` in angle brackets, such as "<body1>", is an object that whoever builds the study
    has at hand: a body of a document, an array of a caller.
    """

    table: ClassVar[str] = "shape"
    title: ClassVar[str] = "Shape"

    source: Annotated[
        Text, says("Shape", "a NACA four-digit section, an airfoil file or a mesh", form=False)
    ]
    marker: Annotated[str, says("Marker", "of a mesh: the section or the surface", form=False)] = ""
    points: Annotated[
        Annotated[int, Meta(ge=5, le=20001)] | None,
        says(
            "Points",
            "cosine-spaced ones of a section, an odd number; without, 161 of a section by name "
            "or file, and the nodes of one in a mesh",
        ),
    ] = None
    trailing_edge: Annotated[
        Literal["match", "keep"],
        says(
            "Trailing edge",
            '"match": a section by name or file gets that of its target first, for a lattice '
            "cannot open a closed one; one in a mesh is kept",
            form=False,
        ),
    ] = "match"
    normalise: Annotated[
        bool,
        says("Chord 1", "whether an airfoil file is brought to a chord of 1, or stays where it "
             "lies", form=False),
    ] = True  # fmt: skip
    lattices: Annotated[
        tuple[Text, ...],
        says("Lattices before", "lattice files that deform a mesh before the study begins",
             form=False),
    ] = ()  # fmt: skip
    mesh: Annotated[
        str | tuple[Text, ...],
        says("Meshes that follow", "one or several that follow the lattice at the end; without, "
             "the source if it is one", form=False),
    ] = ""  # fmt: skip

    follow: Annotated[
        Literal["walls", "lattice"],
        says("How they follow", '"walls": the lattice moves the walls of a mesh and its volume '
             'follows them; "lattice": it carries all nodes, as always with a mesh wholly inside, '
             "and the metric feels their strain. No step turns a cell inside out", form=False),
    ] = "walls"  # fmt: skip

    @property
    def followers(self) -> tuple[str, ...]:
        """Meshes that follow."""
        return self.mesh if isinstance(self.mesh, tuple) else (self.mesh,) if self.mesh else ()


class LatticeSpec(Part, frozen=True, kw_only=True):
    """The lattice that a study begins with: a file, an object at hand, or a box by a rule."""

    table: ClassVar[str] = "lattice"
    title: ClassVar[str] = "Lattice"

    shape: Annotated[
        Counts | None, says("Control points", "of each direction, such as [5, 2]", form=False)
    ] = None
    degrees: Annotated[
        Degrees | None,
        says("Degrees", "of each direction; without, 3 or what the control points allow, and "
             "across a section the highest", form=False),
    ] = None  # fmt: skip
    lower: Annotated[Corner | None, says("Lower corner", "with upper", form=False)] = None
    upper: Annotated[Corner | None, says("Upper corner", "with lower", form=False)] = None
    margin: Annotated[
        Weight | Annotated[tuple[Weight, ...], Meta(min_length=1, max_length=3)],
        says("Margin", "room around the shape as a fraction of its extent, one for all "
             "directions or one for each", form=False),
    ] = 0.01  # fmt: skip
    room: Annotated[
        Weight,
        says("Room across", "how far the lattice reaches above and below a section, at least, in "
             "chords: more room lets a mesh around it follow without inverted cells", "chords"),
    ] = 0.0  # fmt: skip
    spacing: Annotated[
        Literal["greville", "uniform"],
        says("Spacing", "of the control points at rest", form=False),
    ] = "greville"
    movable: Annotated[
        bool,
        says("Movable knots", "whether the inner knots along i count as inserted, so that they "
             "can be moved or taken out at the end", form=False),
    ] = False  # fmt: skip
    file: Annotated[
        str, says("Lattice file", "instead of a box: a lattice as it is at the start", form=False)
    ] = ""

    def __post_init__(self) -> None:
        if self.file:
            return
        if self.shape is None:
            raise ValueError("lacks shape, or the name of a file")
        if (self.lower is None) != (self.upper is None):
            raise ValueError("lower: lower and upper go together")
        count = len(self.shape)
        if self.degrees is not None and len(self.degrees) != count:
            raise ValueError(f"degrees: {count} directions need as many, got {len(self.degrees)}")
        if isinstance(self.margin, tuple) and len(self.margin) != count:
            raise ValueError(f"margin: {count} directions need as many, got {len(self.margin)}")


class VariablesSpec(Part, frozen=True, kw_only=True):
    """What may move."""

    table: ClassVar[str] = "variables"
    title: ClassVar[str] = "Variables"

    directions: Annotated[
        Annotated[tuple[Letter, ...], distinct()] | None,
        says("Directions", "of displacements; without, y for a section and all for a surface"),
    ] = None  # fmt: skip
    frozen: Annotated[
        Index, says("Frozen layers", "outermost layers of control points that stay")
    ] = 0
    fixed: Annotated[
        tuple[ControlPoint, ...],
        says("Fixed points", "further control points that stay, [[i, j], ...]", form=False),
    ] = ()
    linked: Annotated[
        Annotated[tuple[Axis, ...], distinct(0)],
        says("Linked", "directions of the lattice along which control points move as one"),
    ] = ()
    mirror: Annotated[
        Axis | None,
        says("Mirrored", "direction of the lattice whose two ends move as mirror images"),
    ] = None
    mirror_normal: Annotated[
        Vector | None,
        says("Normal of the mirror", "of any length; without, the lattice's own direction",
             form=False),
    ] = None  # fmt: skip
    weights: Annotated[
        tuple[Positive, Positive] | None,
        says("Weights", "[lower, upper]: the weights of the control points are variables too, in "
             "a study without refinement", form=False),
    ] = None  # fmt: skip

    def __post_init__(self) -> None:
        if self.mirror_normal is not None and not any(self.mirror_normal):
            raise ValueError("mirror_normal: a normal has a length")
        if self.weights is not None and not self.weights[0] < self.weights[1]:
            raise ValueError(f"weights need bounds with lower < upper, got {self.weights}")


class BudgetSpec(Part, frozen=True, kw_only=True):
    """When a study ends at the latest."""

    table: ClassVar[str] = "budget"
    title: ClassVar[str] = "Budget"

    evaluations: Annotated[
        Count | None, says("Evaluations", "of the cost, finite differences counted, at most")
    ] = None
    iterations: Annotated[Count | None, says("Iterations", "at most")] = None
    tolerance: Annotated[
        Weight | None, says("Cost to reach", "cost at which the study has ended")
    ] = None
