"""Metrics: one line for each, the default first."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from ffdstudio.errors import InputError
from ffdstudio.optimize.metrics.base import Metric
from ffdstudio.optimize.metrics.flow import Flow
from ffdstudio.optimize.metrics.h1 import H1
from ffdstudio.optimize.metrics.h2 import H2
from ffdstudio.optimize.metrics.l2 import L2
from ffdstudio.optimize.metrics.plain import Plain
from ffdstudio.optimize.metrics.suited import Suited
from ffdstudio.optimize.spec.words import near

METRICS: tuple[Metric, ...] = (
    Suited(),
    H1(),
    H2(),
    Flow(),
    L2(),
    Plain(),
)

if TYPE_CHECKING:
    MetricName = str
else:
    MetricName = Literal[tuple(metric.name for metric in METRICS)]


def metric_named(name: str) -> Metric:
    """Metric by its name; raises `InputError` if there is none."""
    for metric in METRICS:
        if metric.name == name:
            return metric
    words = [metric.name for metric in METRICS]
    raise InputError(
        f"the metric must be one of {', '.join(words)}, got {name!r}{near(name, words)}"
    )
