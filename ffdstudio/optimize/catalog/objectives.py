"""Objectives: one line for each."""

from __future__ import annotations

from ffdstudio.optimize.objectives.contour import ContourSpec
from ffdstudio.optimize.objectives.fairness import FairContourSpec
from ffdstudio.optimize.objectives.flow import FlowSpec
from ffdstudio.optimize.objectives.function import FunctionSpec
from ffdstudio.optimize.objectives.neural import NeuralFoilSpec
from ffdstudio.optimize.objectives.program import ProgramSpec
from ffdstudio.optimize.objectives.surface import SurfaceSpec
from ffdstudio.optimize.spec.goals import ObjectiveSpec

OBJECTIVES: tuple[type[ObjectiveSpec], ...] = (
    ContourSpec,
    FairContourSpec,
    FlowSpec,
    SurfaceSpec,
    NeuralFoilSpec,
    FunctionSpec,
    ProgramSpec,
)
