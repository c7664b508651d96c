"""The guard of everything that is no drag by one vector: turning, scaling, soft, mirrored, weights.

1. Such a motion is a path with one parameter: an angle, a factor, a part of what was typed. The
   first inversion along it is found exactly (`meshes.safety.first_inversion`), from where the
   path was known to be safe on; so a drag pays for what is new since the last event.
2. Meshes of many cells are asked in a worker. Until the answer has come a drag that has to stop
   at the limit stays where it is known to be safe; it never runs ahead.
3. As for drags by a vector, there is none while a later lattice deforms.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Embedding, Lattice
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.safety.along import first_inversion
from ffdstudio.meshes.safety.limits import Stop
from ffdstudio.project.checks.guarding import MARGIN, DragGuard, Verdict, is_last
from ffdstudio.project.running import Progress, no_progress
from ffdstudio.project.view.volume import countable

if TYPE_CHECKING:
    from ffdstudio.project.document import Document
    from ffdstudio.project.edit import Edit
    from ffdstudio.project.model import Body, Model

AT_ONCE = 60_000  # cells that are asked without a worker
NOTHING = np.zeros(3)
_Part = tuple[str, Mesh, Embedding, Array]  # name, mesh, embedding, nodes at the beginning


@dataclass(frozen=True, eq=False)
class Motion:
    """A path of the active lattice.

    Attributes
    ----------
    key : hashable
        What makes two motions the same path: kind, axis, lock.
    asked : float
        Where on it the cursor is; 0 is the beginning.
    at : callable
        From a place on the path to the lattice there.
    step : float
        Length of path on which nodes move straight, near enough; infinity if they do.
    """

    key: Hashable
    asked: float
    at: Callable[[float], Lattice]
    step: float = np.inf


@dataclass
class _Known:
    """What is known of one direction of a path."""

    safe: float = 0.0
    limit: float = np.inf  # size of the place of the first inversion
    body: str = ""


@dataclass
class _Bodies:
    """Embeddings of all nodes of the guarded bodies in the active lattice."""

    model: Model
    wanted: list[Body] = field(default_factory=list)
    parts: list[_Part] = field(default_factory=list)

    @property
    def cells(self) -> int:
        """Number of cells in all."""
        return sum(sum(body.mesh.counts.values()) for body in self.wanted)


class MotionGuard:
    """Says how far along its path a motion may go.

    `ready` of the drag guard is emitted when a worker has found out more.
    """

    def __init__(self, document: Document, drags: DragGuard) -> None:
        self._document, self._drags = document, drags
        self._bodies: _Bodies | None = None
        self._known: dict[tuple[Hashable, bool], _Known] = {}
        self._asking: Hashable | None = None

    def judge(self, motion: Motion) -> tuple[float, Verdict]:
        """Where on its path a motion is to be, and what to say of it."""
        free = motion.asked, Verdict(NOTHING, NOTHING)
        if self._drags.mode == "free" or motion.asked == 0 or not self._prepare():
            return free
        known = self._known.setdefault((motion.key, motion.asked > 0), _Known())
        size = abs(motion.asked)
        if size > known.safe and not np.isfinite(known.limit):
            self._ask(motion, known)
        held = min(size, known.limit * (1 - MARGIN))
        waiting = size > known.safe and not np.isfinite(known.limit)
        if waiting:
            held = min(size, known.safe)
        stop = self._drags.mode == "stop"
        share = known.limit / size
        reason = Stop(share, "inversion") if np.isfinite(share) else Stop(np.inf)
        state = "waiting" if waiting else "ready"
        verdict = Verdict(
            NOTHING,
            NOTHING,
            reason,
            known.body,
            state,
            place=known.limit,
            held=stop and held < size,
        )
        return (np.sign(motion.asked) * held if stop else motion.asked), verdict

    # ---- asking the cells -----------------------------------------------------------------

    def _ask(self, motion: Motion, known: _Known) -> None:
        bodies = self._bodies
        if bodies is None or not bodies.parts:
            return
        if bodies.cells <= AT_ONCE:
            self._take(known, motion, _first(bodies, motion, known.safe, no_progress))
            return
        if self._asking is not None:
            return
        self._asking = motion.key
        safe = known.safe

        def work(progress: Progress) -> tuple[float, str]:
            return _first(bodies, motion, safe, progress)

        def done(found: tuple[float, str]) -> None:
            self._asking = None
            self._take(known, motion, found)
            self._drags.ready.emit()

        def failed(error: Exception) -> None:
            self._asking = None
            raise error

        def cancelled() -> None:
            self._asking = None

        runner = self._document.runner
        runner.start("Looking ahead", work, done, failed, "motion guard", cancelled=cancelled)

    def _take(self, known: _Known, motion: Motion, found: tuple[float, str]) -> None:
        limit, body = found
        if np.isfinite(limit):
            known.limit, known.body = abs(limit), body
            known.safe = max(known.safe, abs(limit) * (1 - MARGIN))
        else:
            known.safe = max(known.safe, abs(motion.asked))

    def _prepare(self) -> bool:
        """Have the embeddings of all nodes at hand; False where there is nothing to guard."""
        document = self._document
        model = document.settled_model
        if self._bodies is not None and self._bodies.model is model:
            return bool(self._bodies.wanted)
        self._known = {}
        item = model.active_lattice
        self._bodies = bodies = _Bodies(model)
        if item is None or not is_last(model, item):
            return False
        bodies.wanted = [body for body in model.bodies if countable(body.mesh)]
        if bodies.cells <= AT_ONCE:
            bodies.parts = self._parts(bodies, item.key, no_progress)
        elif bodies.wanted:
            self._set_up(bodies, item.key)
        return bool(bodies.wanted)

    def _parts(self, bodies: _Bodies, key: str, progress: Progress) -> list[_Part]:
        nodes = [self._document.nodes(body.key) for body in bodies.wanted]
        steps = bodies.model.steps
        bound = [follower.bound(steps, key, progress) for follower in nodes]
        return [
            (body.name, body.mesh, embedding, start)
            for body, (embedding, start) in zip(bodies.wanted, bound, strict=True)
        ]

    def _set_up(self, bodies: _Bodies, key: str) -> None:
        def done(parts: list[_Part]) -> None:
            bodies.parts = parts
            self._drags.ready.emit()

        def cancelled() -> None:
            if self._bodies is bodies:
                self._bodies = None

        def failed(error: Exception) -> None:
            bodies.wanted = []
            raise error

        self._document.runner.start(
            "Setting up the guard", lambda progress: self._parts(bodies, key, progress),
            done, failed, "motion guard", cancelled=cancelled,
        )  # fmt: skip

    # ---- what is typed ----------------------------------------------------------------------

    def shorten(self, edit: Edit) -> None:
        """End an edit that is about to be committed before the first cell inverts."""
        if self._drags.mode != "stop" or not self._prepare():
            return
        bodies = self._bodies
        if bodies is None or not bodies.parts or bodies.cells > AT_ONCE:
            return  # said by the count of inverted cells, once that has come
        whole = edit.state
        step = np.inf if (whole[1] == edit.weights).all() else 0.05
        motion = Motion(None, 1.0, lambda s: edit.lattice_at(s, whole), step)
        limit, body = _first(bodies, motion, 0.0, no_progress)
        if limit * (1 - MARGIN) < 1:
            edit.go_to(limit * (1 - MARGIN), whole)
            self._document.told.emit(
                f"Stopped at {100 * limit:.3g} % of what was asked: a cell of {body} inverts"
            )


def _first(bodies: _Bodies, motion: Motion, safe: float, progress: Progress) -> tuple[float, str]:
    """First inversion of any body, and its name."""
    best, name = np.inf, ""
    sign = 1.0 if motion.asked >= 0 else -1.0
    for number, (body, mesh, embedding, start) in enumerate(bodies.parts):
        progress(number / len(bodies.parts), f"looking ahead in {body}")

        def at(place: float, embedding: Embedding = embedding, start: Array = start) -> Array:
            return start if place == 0 else embedding.deform(motion.at(place))

        asked = sign * min(abs(motion.asked), best)
        found = abs(first_inversion(mesh, at, asked, sign * safe, motion.step))
        if found < best:
            best, name = found, body
    return best, name
