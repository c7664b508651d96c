"""What a study may spend, and what it has spent."""

from __future__ import annotations

from dataclasses import dataclass

from ffdstudio.optimize.ending import Ending, Reason


class BudgetSpent(Exception):
    """A limit of the budget is reached."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(str(reason))
        self.ending = Ending(reason)


@dataclass(frozen=True)
class Budget:
    """Limits of a study.

    Attributes
    ----------
    evaluations, iterations : int, optional
    tolerance : float, optional
        The study has ended when the cost is at or below it.

    Examples
    --------
    >>> Budget(evaluations=5).allowed(8, spent=2)
    3
    """

    evaluations: int | None = None
    iterations: int | None = None
    tolerance: float | None = None

    def check_iterate(self, iterations: int, cost: float) -> None:
        """Raise `BudgetSpent` at the limit of iterations or at the tolerance."""
        self.check_cost(cost)
        if self.iterations is not None and iterations >= self.iterations:
            raise BudgetSpent(Reason.ITERATIONS)

    def check_cost(self, cost: float) -> None:
        """Raise `BudgetSpent` at the tolerance."""
        if self.tolerance is not None and cost <= self.tolerance:
            raise BudgetSpent(Reason.TOLERANCE)

    def check_evaluation(self, evaluations: int) -> None:
        """Raise `BudgetSpent` if no further evaluation is allowed."""
        if self.evaluations is not None and evaluations >= self.evaluations:
            raise BudgetSpent(Reason.EVALUATIONS)

    def allowed(self, wanted: int, spent: int) -> int:
        """How many of the evaluations that are wanted may be made."""
        if self.evaluations is None:
            return wanted
        return max(0, min(wanted, self.evaluations - spent))


@dataclass
class Counts:
    """What has been spent so far."""

    evaluations: int = 0
    flow: int = 0
    adjoint: int = 0
