"""How a lattice adapts itself."""

from __future__ import annotations

from typing import Annotated, ClassVar

from ffdstudio.optimize.catalog.indicators import INDICATORS, IndicatorName
from ffdstudio.optimize.spec.fields import Axis, Count, Positive, Weight, distinct, says
from ffdstudio.optimize.spec.rows import Part


class RefinementSpec(Part, frozen=True, kw_only=True):
    """How the lattice is refined; without it, it stays as it is."""

    table: ClassVar[str] = "refinement"
    title: ClassVar[str] = "Refinement"

    indicator: Annotated[
        IndicatorName, says("Indicator", "what says where a knot is worth most")
    ] = INDICATORS[0].name
    directions: Annotated[
        Annotated[tuple[Axis, ...], distinct()],
        says("Along", "directions of the lattice that may get knots; not mirrored or linked ones"),
    ] = ("i",)
    variables: Annotated[
        Count,
        says("Variables up to", "number of variables at which refinement ends, not fewer than the "
             "first lattice has"),
    ] = 70  # fmt: skip
    positions: Annotated[Count, says("Places a span", "tried in each knot span")] = 5
    insertions: Annotated[Count, says("Knots a cycle", "inserted at each refinement")] = 1
    rounds: Annotated[Count, says("Rounds a cycle", "of insertions, all by the same gradient")] = 1
    row_wise: Annotated[
        bool,
        says("Row by row", "whether a new knot frees one row of control points only; without "
             "fixed, linked or mirrored ones"),
    ] = False  # fmt: skip
    iterations: Annotated[
        Count | None, says("After iterations", "a cycle is due after so many")
    ] = None
    slope: Annotated[
        Positive | None,
        says("Or at a slope of", "a cycle is due when an iteration leaves more than this share "
             "of the cost"),
    ] = None  # fmt: skip
    share: Annotated[
        Positive | None,
        says("Or at a share of", "a cycle is due when the lattice holds less than this share of "
             "what it and the best knot hold"),
    ] = None  # fmt: skip
    relocate: Annotated[
        bool, says("Move knots at the end", "whether inserted knots are moved to better places")
    ] = False
    coarsen: Annotated[
        Weight | None,
        says("Take knots out for", "share of the cost that taking knots out at the end may add; "
             "the budget's cost to reach is allowed anyway"),
    ] = None  # fmt: skip
