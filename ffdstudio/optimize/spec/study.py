"""The description of a study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Union

from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.spec.fields import says
from ffdstudio.optimize.spec.goals import ObjectiveSpec
from ffdstudio.optimize.spec.limits import ConstraintSpec
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.rows import Part

if TYPE_CHECKING:
    AnyObjective = ObjectiveSpec
    AnyConstraint = ConstraintSpec
    AnyMethod = MethodSpec
else:
    AnyObjective = Union[OBJECTIVES]  # noqa: UP007
    AnyConstraint = Union[CONSTRAINTS]  # noqa: UP007
    AnyMethod = Union[METHODS]  # noqa: UP007


class StudySpec(Part, frozen=True, kw_only=True):
    """A study, whole: what the window, case files, Python and projects share.

    Examples
    --------
    >>> from ffdstudio.optimize.objectives.contour import ContourSpec
    >>> study = StudySpec(
    ...     shape=ShapeSpec(source="naca0012"),
    ...     lattice=LatticeSpec(shape=(5, 2)),
    ...     objective=ContourSpec(target="naca2412"),
    ... )
    >>> study.method.kind(), study.method.metric
    ('lbfgs', 'auto')
    """

    shape: Annotated[ShapeSpec, says("Shape", "what is optimized")]
    lattice: Annotated[LatticeSpec, says("Lattice", "where it begins")]
    variables: Annotated[VariablesSpec, says("Variables", "what may move")] = VariablesSpec()
    objective: Annotated[AnyObjective, says("Objective", "what is made small")]
    constraints: Annotated[
        tuple[AnyConstraint, ...], says("Constraints", "what has to be kept")
    ] = ()
    method: Annotated[AnyMethod, says("Method", "that makes it small")] = METHODS[0]()
    refinement: Annotated[
        RefinementSpec | None,
        says("Refinement", "how the lattice adapts itself; without, it stays as it is"),
    ] = None
    budget: Annotated[BudgetSpec, says("Budget", "when it ends at the latest")] = BudgetSpec()
