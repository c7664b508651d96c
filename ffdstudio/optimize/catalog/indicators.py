"""Indicators of the refinement: one line for each, the default first."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from ffdstudio.errors import InputError
from ffdstudio.optimize.refine.indicators import GAIN, GRADIENT, INTERVAL, Indicator
from ffdstudio.optimize.spec.words import near

INDICATORS: tuple[Indicator, ...] = (
    GAIN,
    INTERVAL,
    GRADIENT,
)

if TYPE_CHECKING:
    IndicatorName = str
else:
    IndicatorName = Literal[tuple(indicator.name for indicator in INDICATORS)]


def indicator_named(name: str) -> Indicator:
    """Indicator by its name; raises `InputError` if there is none."""
    for indicator in INDICATORS:
        if indicator.name == name:
            return indicator
    words = [indicator.name for indicator in INDICATORS]
    raise InputError(
        f"the indicator must be one of {', '.join(words)}, got {name!r}{near(name, words)}"
    )
