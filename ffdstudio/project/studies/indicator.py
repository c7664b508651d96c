"""Where a refinement would pay: the indicator of each knot interval, for the eye."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from ffdstudio.optimize.budget import Counts
from ffdstudio.optimize.catalog.indicators import indicator_named
from ffdstudio.optimize.catalog.metrics import metric_named
from ffdstudio.optimize.consent import Consent
from ffdstudio.optimize.methods.descent import Lbfgs
from ffdstudio.optimize.refine.candidates import candidates
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.runs.responding import responding
from ffdstudio.optimize.runs.solver import LevelProblem
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.optimize.variables.level import EmbeddedBody as Shape
from ffdstudio.optimize.variables.level import Level
from ffdstudio.optimize.variables.space import DesignSpace
from ffdstudio.project.model import LatticeItem, Model
from ffdstudio.project.studies.starting import on_lattice, prepare


@dataclass(frozen=True)
class Bar:
    """One knot interval.

    Attributes
    ----------
    axis : int
    low, high : float
        Ends of the interval.
    knot : float or None
        The best place in it; None where the guards allow none.
    score : float
        What the indicator says of that place.
    """

    axis: int
    low: float
    high: float
    knot: float | None
    score: float


def bars(
    study: StudySpec,
    model: Model,
    item: LatticeItem,
    indicator: str,
    folder: Path | None = None,
    source: Path | None = None,
    consent: Consent | None = None,
) -> list[Bar]:
    """Indicator of all knot intervals of a lattice as it is; the shape is evaluated once.

    Parameters
    ----------
    indicator : str
        Its name.
    folder : path, optional
        Where a program that is asked gets its folders.
    source, consent : optional
        Project that the study came inside, and what may run of it.

    Raises
    ------
    InputError
        As `prepare`.
    """
    axes = tuple(range(item.rest.dimension))
    settings = Refinement(indicator, axes, variables=2**31)
    still = msgspec.structs.replace(on_lattice(study, item.key), refinement=None)
    task = prepare(still, model, folder, source, consent).task
    space = DesignSpace.of(item.rest, task.rules, task.current)
    metric = metric_named(task.metric)
    level = Level.first(Shape(task.embedding, task.surface), space)
    surface, _ = responding(task, task.surface, level.points)
    level = Level.first(Shape(task.embedding, surface, metric), space)
    method = Lbfgs() if study.method.largest else study.method
    problem = LevelProblem(level, task, Counts(), method)
    found = candidates(level, axes, settings.positions, False, settings.guards)
    scores = np.zeros(0)
    if found:
        sensitivity = problem.sensitivity(problem.gradient(np.zeros(level.size)))
        scores = indicator_named(settings.indicator).scores(level, sensitivity, found)
        scores = scores / [c.size for c in found]
    best: dict[tuple[int, int], tuple[float, float]] = {}
    for candidate, score in zip(found, scores.tolist(), strict=True):
        place, knot = (candidate.insertion.axis, candidate.span), candidate.insertion.knot
        best[place] = max(best.get(place, (-1.0, 0.0)), (float(score), knot))
    return [bar for axis in axes for bar in _of_axis(item, axis, best)]


def _of_axis(
    item: LatticeItem, axis: int, best: dict[tuple[int, int], tuple[float, float]]
) -> list[Bar]:
    knots, made = item.rest.knots[axis], []
    ends = np.unique(knots)
    for low, high in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        span = int(np.searchsorted(knots, 0.5 * (low + high)))
        score, knot = best.get((axis, span), (0.0, None))
        made.append(Bar(axis, low, high, knot, score))
    return made
