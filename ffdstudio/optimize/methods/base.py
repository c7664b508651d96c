"""What every method is: its settings, what it can do, and how it makes a cost small."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

from ffdstudio.optimize.catalog.metrics import METRICS, MetricName
from ffdstudio.optimize.spec.fields import Angle, Positive, says
from ffdstudio.optimize.spec.rows import Row

if TYPE_CHECKING:
    from ffdstudio.aliases import Array
    from ffdstudio.optimize.ending import Ending
    from ffdstudio.optimize.methods.problem import Memory, Problem


class Trigger(NamedTuple):
    """When a cycle of refinement pays with a method, if nothing is said; see `Refinement`."""

    iterations: int | None = None
    slope: float | None = None


class MethodSpec(Row, frozen=True, kw_only=True, tag_field="name"):
    """A method: a row of the catalog, and the object that does the work.

    Attributes
    ----------
    constraints : bool
        Whether it keeps constraints itself; else a penalty stands for them.
    residuals : bool
        Whether it needs residuals.
    largest : bool
        Whether it makes the largest residual small, not the cost.
    trigger : Trigger
    """

    table: ClassVar[str] = "method"
    constraints: ClassVar[bool] = False
    residuals: ClassVar[bool] = False
    largest: ClassVar[bool] = False
    trigger: ClassVar[Trigger] = Trigger(slope=0.8)

    metric: Annotated[MetricName, says("Metric", "in which the variables are made orthonormal")] = (
        METRICS[0].name
    )
    angle: Annotated[
        Angle,
        says("Angle of the metric", "of attack, for the metric flow of objectives without a flow "
             "of their own", form=False),
    ] = 0.0  # fmt: skip
    carry_memory: Annotated[
        bool,
        says("Carry memory on", "whether what the method has learned outlives a refinement"),
    ] = True
    penalty: Annotated[
        Positive,
        says("Penalty", "factor of half the squared violations, for methods that do not know "
             "constraints", form=False),
    ] = 1e3  # fmt: skip

    def minimise(self, problem: Problem, z: Array, memory: Memory) -> Ending:
        """Make the cost small, beginning at z; see the package."""
        raise NotImplementedError
