"""A study: an objective, variables, a method and a refinement, run and recorded.

1. `run` works in any thread or process and tells a callback of each record; `pause`, `step`
   and `stop` may be called from another thread, for example the window's.
2. A study with a folder resumes by being run again: see `record`. What one run does is in `run`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.embedding import Embedding
from ffdstudio.errors import InputError
from ffdstudio.optimize.budget import Budget
from ffdstudio.optimize.catalog.methods import method_kind
from ffdstudio.optimize.constraints import Constraint
from ffdstudio.optimize.control import Control
from ffdstudio.optimize.followers.body import FollowingMesh
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.objectives.base import Objective, Response
from ffdstudio.optimize.refine.choice import Refinement
from ffdstudio.optimize.runs.record import RunHistory
from ffdstudio.optimize.runs.run import Listener, Run
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import Insertion

Monitor = Callable[[Lattice], dict[str, float]]


@dataclass
class Task:
    """What is optimized.

    Attributes
    ----------
    objective : Objective
    embedding : Embedding
        The points that the objective sees, in the lattice at rest.
    surface : Surface
        How they are connected.
    rules : Rules
    current : Lattice, optional
        Where the lattice is when the study begins; at rest by default.
    knots : sequence of Insertion
        Knots to insert before the study begins; a relocation may move them.
    metric : {"h1", "auto", "flow", "h2", "l2", "none"}
    constraints : sequence of Constraint
    penalty : float
        Factor of half the squared violation, for methods that know no constraints.
    monitor : callable, optional
        Figures for the record from the current lattice.
    response : callable, optional
        What gives the metric "flow" the response at the start, where the objective cannot.
    followers : tuple of FollowingMesh
        Meshes that no trial may turn inside out; see `followers.task`.
    seen : int, optional
        How many of the points the objective sees; those behind are of meshes that follow.
    """

    objective: Objective
    embedding: Embedding
    surface: Surface
    rules: Rules = field(default_factory=Rules)
    current: Lattice | None = None
    knots: Sequence[Insertion] = ()
    metric: str = "h1"
    constraints: Sequence[Constraint] = ()
    penalty: float = 1e3
    monitor: Monitor | None = None
    response: Callable[[Array], Response | None] | None = None
    followers: tuple[FollowingMesh, ...] = ()
    seen: int | None = None

    @property
    def seen_points(self) -> int:
        """Number of points that the objective sees."""
        return len(self.embedding.points) if self.seen is None else self.seen


class Study:
    """Runs a task and records it.

    Parameters
    ----------
    task : Task
    method : MethodSpec or str
        Of the catalog, with its settings, or by name.
    refinement : Refinement, optional
        Without it the lattice stays as it is.
    budget : Budget, optional
    folder : path, optional
        Where the log goes.
    resume : bool
        Go on where the log in that folder ends, instead of beginning anew.

    Raises
    ------
    InputError
        If a refinement is asked for with weights as variables.

    Examples
    --------
    >>> import numpy as np
    >>> import ffdstudio as ffd
    >>> from ffdstudio.optimize.objectives.distance import PointDistance
    >>> points = np.column_stack([np.linspace(0, 1, 41), np.zeros(41), np.zeros(41)])
    >>> target = points + np.column_stack([0 * points[:, 0], points[:, 0] ** 2, points[:, 0] * 0])
    >>> box = ffd.Lattice.box([0, -1, 0], [1, 1, 0], shape=(5, 2))
    >>> embedding = ffd.embed(box, points)
    >>> task = Task(PointDistance(target), embedding, Surface.curve(points))
    >>> bool(Study(task, "gauss-newton").run().iterates[-1].cost < 1e-25)
    True
    """

    def __init__(
        self,
        task: Task,
        method: MethodSpec | str = "lbfgs",
        refinement: Refinement | None = None,
        budget: Budget | None = None,
        folder: str | Path | None = None,
        resume: bool = False,
    ) -> None:
        if refinement is not None and task.rules.weights is not None:
            raise InputError("weights are variables only without a refinement")
        self.task, self.refinement, self.budget = task, refinement, budget or Budget()
        self.method = method_kind(method)() if isinstance(method, str) else method
        self.folder, self.resume = None if folder is None else Path(folder), resume
        self.history = RunHistory()
        self.control = Control()

    def pause(self) -> None:
        """Wait at the next iterate."""
        self.control.pause()

    def proceed(self) -> None:
        """Go on after a pause."""
        self.control.proceed()

    def step(self) -> None:
        """Go on for one iterate."""
        self.control.step()

    def stop(self) -> None:
        """End at the next evaluation; the study can be resumed."""
        self.control.stop()

    def run(self, listener: Listener | None = None) -> RunHistory:
        """Run until it has ended or is stopped; returns the history.

        Raises
        ------
        InputError
            If the objective fails at the start, or the log cannot be written.
        """
        self.history = RunHistory()
        try:
            Run(self, self.history, listener).to_the_end()
        finally:
            self.control.ended()
        return self.history


__all__ = ["Budget", "InputError", "Listener", "Refinement", "Rules", "Study", "Surface", "Task"]
