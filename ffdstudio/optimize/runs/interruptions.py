"""How a study ends while a refinement asks for derivatives.

Finite differences are evaluations like others: they cost, fail and are stopped. What was
reached before is the end then.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ffdstudio.optimize.budget import BudgetSpent
from ffdstudio.optimize.control import Stopped
from ffdstudio.optimize.objectives.remembered import EvaluationError


class Over(Exception):
    """What a refinement asks cannot be answered; the message is how the study ended."""


@contextmanager
def asking() -> Iterator[None]:
    """Turn whatever ends the evaluations into `Over`."""
    try:
        yield
    except BudgetSpent as spent:
        raise Over(str(spent)) from spent
    except Stopped as stop:
        raise Over("stopped") from stop
    except EvaluationError as failed:
        raise Over(f"failed: {failed}") from failed
