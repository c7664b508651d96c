"""Methods: one line for each, the default first."""

from __future__ import annotations

from ffdstudio.errors import InputError
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.methods.descent import ConjugateGradients, Lbfgs
from ffdstudio.optimize.methods.gauss_newton import GaussNewton
from ffdstudio.optimize.methods.minimax import Minimax
from ffdstudio.optimize.methods.powell import Powell
from ffdstudio.optimize.methods.slsqp import Slsqp
from ffdstudio.optimize.methods.trust_region import TrustRegion
from ffdstudio.optimize.spec.words import near

METHODS: tuple[type[MethodSpec], ...] = (
    Lbfgs,
    Slsqp,
    TrustRegion,
    GaussNewton,
    Minimax,
    ConjugateGradients,
    Powell,
)


def method_kind(name: str) -> type[MethodSpec]:
    """Method by its name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    for kind in METHODS:
        if kind.kind() == name:
            return kind
    words = [kind.kind() for kind in METHODS]
    raise InputError(
        f"the method must be one of {', '.join(words)}, got {name!r}{near(name, words)}"
    )
