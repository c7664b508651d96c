"""Quality of a mesh: measures per cell, inverted cells, reports with the solvers' limits."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ffdstudio.meshes.measures.cell_coverage import Coverage, coverage
from ffdstudio.meshes.measures.inversion import Inverted, inverted
from ffdstudio.meshes.measures.standards import LIMITS, MEASURES, Limit, Measure

if TYPE_CHECKING:
    from ffdstudio.meshes.measures.evaluate import quality
    from ffdstudio.meshes.measures.report import Report

_LATER = {"quality": "evaluate", "Report": "report"}  # these load numba
__all__ = [
    "LIMITS",
    "MEASURES",
    "Coverage",
    "Inverted",
    "Limit",
    "Measure",
    "Report",
    "coverage",
    "inverted",
    "quality",
]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_LATER[name]}"), name)
    globals()[name] = value
    return value
