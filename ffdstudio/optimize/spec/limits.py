"""The limits that every constraint has, and how a constraint is made of its row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from ffdstudio.errors import InputError
from ffdstudio.optimize.constraints.base import Constraint, Quantity
from ffdstudio.optimize.constraints.placed import InChords, OnNodes
from ffdstudio.optimize.spec.fields import says
from ffdstudio.optimize.spec.rows import Row

if TYPE_CHECKING:
    from ffdstudio.optimize.geometry.shapes import Shape

LIMITS = ("lower", "upper", "equal")


class ConstraintSpec(Row, frozen=True, kw_only=True):
    """Base of all constraints: a quantity of the shape within limits."""

    table: ClassVar[str] = "constraints"

    lower: Annotated[float | None, says("At least", "lower limit")] = None
    upper: Annotated[float | None, says("At most", "upper limit")] = None
    equal: Annotated[float | None, says("Equal to", "instead of lower and upper")] = None

    def __post_init__(self) -> None:
        lower, upper, kind = self.lower, self.upper, self.kind()
        if self.equal is not None and (lower is not None or upper is not None):
            raise ValueError(f"{kind}: equal goes without lower and upper")
        if self.equal is None and lower is None and upper is None:
            raise ValueError(f"the constraint {kind} has no limit: give lower, upper or equal")
        if lower is not None and upper is not None and lower > upper:
            raise ValueError(f"the lower limit of {kind} exceeds the upper one")

    def quantity(self, shape: Shape) -> Quantity:
        """What is measured, of a section in chords."""
        raise NotImplementedError

    def constraint(self, shape: Shape) -> Constraint:
        """The constraint on a shape, wherever it lies.

        Raises
        ------
        InputError
            If it is about another kind of shape.
        """
        if self.needs != "any" and (self.needs == "section") != shape.flat:
            wanted = "a section" if self.needs == "section" else "a surface in 3D"
            raise InputError(f"[constraints] {self.kind()} needs {wanted}")
        quantity = self.quantity(shape)
        if shape.chord is not None and not shape.chord.unit:
            quantity = InChords(quantity, shape.chord)
        if shape.contour is not None:
            quantity = OnNodes(quantity, shape.contour)
        lower, upper = (self.equal,) * 2 if self.equal is not None else (self.lower, self.upper)
        return Constraint(quantity, lower, upper, self.kind())
