"""One target of a comparison: the same cost, start and method for everybody."""

from __future__ import annotations

import time
from collections.abc import Iterable
from itertools import accumulate
from typing import Any

from ffdstudio.aliases import Array
from ffdstudio.engine import embed
from ffdstudio.errors import InputError
from ffdstudio.optimize.compare.linear import LinearProblem, minimised
from ffdstudio.optimize.compare.protocol import ADAPTIVE, Case, Protocol
from ffdstudio.optimize.compare.rivals import LATTICES, Modes, cst_fields, lattice
from ffdstudio.optimize.geometry.sections import opened, sampled, target_contour, trailing_gap
from ffdstudio.optimize.objectives.flow import FlowTarget
from ffdstudio.optimize.runs.study import Budget, Study, Task
from ffdstudio.optimize.variables.metrics import Surface

Path_ = list[tuple[int, float]]


def result_of(case: Case, protocol: Protocol, modes: Modes | None = None) -> dict[str, Any]:
    """Everything about one target, ready for JSON; what fails is told, not raised."""
    told: dict[str, Any] = {
        "target": case.path.name, "panels": case.panels, "angle": case.angle,
        "digest": protocol.digest,
    }  # fmt: skip
    try:
        points, flow = _task(case, protocol)
    except InputError as error:
        return {**told, "refused": str(error)}
    told["start"] = flow.evaluate(points, False).value
    told["runs"] = {
        f"{name}-{count}": _run(name, count, points, flow, protocol, modes)
        for count in protocol.variables
        for name in (*protocol.rivals, ADAPTIVE)
    }
    return told


def _task(case: Case, protocol: Protocol) -> tuple[Array, FlowTarget]:
    """The start with the target's thickness at the trailing edge, and the cost."""
    target = target_contour(str(case.path))
    start = sampled(protocol.source, case.panels)
    gap = trailing_gap(target) - float(start[0, 1] - start[-1, 1])
    flow = FlowTarget.like(target.sample(case.panels), [case.angle])
    return opened(start, gap), flow


def _run(
    name: str, count: int, points: Array, flow: FlowTarget, protocol: Protocol, modes: Modes | None
) -> dict[str, Any]:
    began = time.process_time()
    try:
        if name == ADAPTIVE or name in LATTICES:
            path, variables, ended = _lattice_run(name, count, points, flow, protocol)
        else:
            fields = cst_fields(points, count) if modes is None or name == "cst" else (
                modes.fields(points, count)
            )  # fmt: skip
            problem = LinearProblem(flow, points, fields, protocol.metric)
            ended = str(minimised(problem, protocol.evaluations))
            path, variables = problem.path, problem.size
    except Exception as error:  # a failure of one is told by name and ends none of the others
        return {"error": f"{type(error).__name__}: {error}"}
    seconds = round(time.process_time() - began, 2)
    return {"variables": variables, "ended": ended, "seconds": seconds, "path": lowered(path)}


def _lattice_run(
    name: str, count: int, points: Array, flow: FlowTarget, protocol: Protocol
) -> tuple[Path_, int, str]:
    rows, adaptive = protocol.rows, name == ADAPTIVE
    columns = protocol.start if adaptive else count // rows
    net = lattice(points, columns, "greville" if adaptive else name, rows)
    task = Task(flow, embed(net, points), Surface.curve(points), metric=protocol.metric)
    refinement = protocol.refinement(count) if adaptive else None
    study = Study(task, "lbfgs", refinement, Budget(evaluations=protocol.evaluations))
    history = study.run()
    path = [
        (r.flow + r.adjoint, r.cost)
        for r in history.records
        if r.kind in ("evaluation", "iterate", "end")
    ]
    return path, history.iterates[-1].variables, history.records[-1].note


def lowered(path: Iterable[tuple[int, float]]) -> Path_:
    """Steps at which the least cost so far fell, and the last count of solves.

    Examples
    --------
    >>> lowered([(1, 4.0), (3, 5.0), (5, 2.0), (7, 2.0)])
    [(1, 4.0), (5, 2.0), (7, 2.0)]
    """
    steps = list(path)
    least = list(accumulate((cost for _, cost in steps), min))
    found = [
        (solves, low)
        for k, ((solves, cost), low) in enumerate(zip(steps, least, strict=True))
        if k == 0 or cost < least[k - 1]
    ]
    return [*found, (steps[-1][0], least[-1])] if found[-1][0] != steps[-1][0] else found
