"""The surface with the response of its flow, where the metric of a task needs it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ffdstudio.aliases import Array
from ffdstudio.optimize.catalog.metrics import metric_named
from ffdstudio.optimize.metrics.flow import Flow
from ffdstudio.optimize.variables.metrics import Surface

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.study import Task


def responding(task: Task, surface: Surface, points: Array) -> tuple[Surface, int]:
    """Surface with the response at (n, 3) points, and the solves that it has cost.

    It stays as it is where the metric needs none, or nobody can tell it.
    """
    if not metric_named(task.metric).responds:
        return surface, 0
    known = task.objective.response(points)
    asked = known is None and task.response is not None and task.metric == Flow.name
    found = task.response(points) if asked and task.response else known
    if found is None:
        return surface, 0
    return surface._replace(response=found.matrix), found.solves
