"""How a study ends while a refinement asks for derivatives.

Finite differences are evaluations like others: they cost, fail and are stopped. What was
reached before is the end then.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ffdstudio.optimize.budget import BudgetSpent
from ffdstudio.optimize.control import Stopped
from ffdstudio.optimize.ending import STOPPED, Ending, Reason
from ffdstudio.optimize.objectives.failures import EvaluationError


class Over(Exception):
    """What a refinement asks cannot be answered: the study has ended."""

    def __init__(self, ending: Ending) -> None:
        super().__init__(str(ending))
        self.ending = ending


@contextmanager
def asking() -> Iterator[None]:
    """Turn whatever ends the evaluations into `Over`."""
    try:
        yield
    except BudgetSpent as spent:
        raise Over(spent.ending) from spent
    except Stopped as stop:
        raise Over(STOPPED) from stop
    except EvaluationError as failed:
        raise Over(Ending(Reason.FAILED, str(failed))) from failed
