"""Methods that make a cost small; each is a function of a problem, a start and a memory.

A method asks the problem for trials and reports each iterate to it. The problem may end it at
a report by an exception (a refinement is due, the budget is spent, the user stops): methods
need no settings for that; by itself it returns why it ended. The memory outlives the
method: it is carried through refinements.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ffdstudio.errors import InputError
from ffdstudio.optimize.methods.descent import conjugate_gradients, lbfgs
from ffdstudio.optimize.methods.gauss_newton import gauss_newton
from ffdstudio.optimize.methods.minimax import minimax
from ffdstudio.optimize.methods.powell import conjugate_directions
from ffdstudio.optimize.methods.slsqp import slsqp

if TYPE_CHECKING:
    from ffdstudio.optimize.methods.problem import Array, Memory, Problem

METHODS: dict[str, Callable[[Problem, Array, Memory], str]] = {
    "cg": conjugate_gradients,
    "gauss-newton": gauss_newton,
    "lbfgs": lbfgs,
    "minimax": minimax,
    "powell": conjugate_directions,
    "slsqp": slsqp,
}


def method(name: str) -> Callable[[Problem, Array, Memory], str]:
    """Method by name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if name not in METHODS:
        raise InputError(f"the method must be one of {', '.join(METHODS)}, got {name!r}")
    return METHODS[name]
