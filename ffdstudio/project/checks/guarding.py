"""The live guard of a drag: how far it may go before a cell inverts or a limit is met.

1. A guard belongs to one state of the lattices, one set of control points and one choice of
   limits. It is made in a worker as soon as points are selected, so that it is usually there
   before they are dragged; until it is, a drag runs without (`Verdict.state`).
2. Nodes follow a common motion of control points by x0 + b D exactly while the active lattice
   is the last one that deforms. Where a later one does, there is no guard.
3. Only meshes whose cells can be inverted are guarded: volumes, and plane meshes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from psygnal import Signal

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.cell_coverage import Coverage, together
from ffdstudio.meshes.safety.limits import PRESETS, Stop
from ffdstudio.meshes.ways import Way
from ffdstudio.project.model import Index, LatticeItem, Model
from ffdstudio.project.running import Progress
from ffdstudio.project.view.volume import countable

if TYPE_CHECKING:
    from ffdstudio.meshes.safety.guard import Guard
    from ffdstudio.project.document import Document

MODES = ("stop", "warn", "free")
MARGIN = 1e-3  # a drag that is stopped ends this fraction before the limit
NOWHERE = Stop(np.inf)
REASONS = {
    "inversion": "a cell inverts",
    "non_orthogonality": "non-orthogonality",
    "face_skewness": "face skewness",
    "first_layer": "first-layer height",
}


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the guard says of a drag.

    Attributes
    ----------
    vector : numpy.ndarray
        (3,) the drag as it is to be carried out.
    asked : numpy.ndarray
        (3,) the drag as the cursor has it.
    stop : Stop
        The limit as a multiple of `asked`.
    body : str
        Name of the body that the limit comes from.
    state : str
        ``ready``; ``waiting`` while the guard is being made; ``none`` where there is none.
    unseen : Coverage
        Cells that the guard does not know, of all guarded bodies.
    place, held : float, bool
        Of a motion that is no drag by a vector: where on its path the limit is, and whether it
        is held back.
    """

    vector: Array
    asked: Array
    stop: Stop = NOWHERE
    body: str = ""
    state: str = "none"
    unseen: Coverage = field(default_factory=Coverage)
    place: float = np.nan
    held: bool = False

    @property
    def beyond(self) -> bool:
        """Whether the cursor has passed the limit."""
        return bool(self.stop.amplitude <= 1)

    @property
    def reason(self) -> str:
        """Why the drag has to end there, for people."""
        return REASONS.get(self.stop.reason, self.stop.reason)


@dataclass(frozen=True, eq=False)
class Watched:
    """Guards that were made for some points of one state."""

    model: Model
    points: tuple[Index, ...]
    limits: str
    guards: tuple[tuple[str, Guard], ...] | None = None

    def fits(self, other: Watched) -> bool:
        """Whether it answers the same question."""
        same = self.points == other.points and self.limits == other.limits
        return same and _shape(self.model) == _shape(other.model)


class DragGuard:
    """Has the guard ready for the next drag of a document.

    Attributes
    ----------
    mode : str
        ``stop``: a drag ends at the limit; ``warn``: it is said; ``free``: no guard.
    limits : str
        Name in `ffdstudio.meshes.safety.PRESETS`.

    Notes
    -----
    Signals: ``ready()`` when a guard has been made; ``changed()`` when mode or limits have.
    """

    ready = Signal()
    changed = Signal()

    def __init__(self, document: Document, mode: str = "warn", limits: str = "inversion") -> None:
        self._document = document
        self.mode = mode if mode in MODES else "warn"
        self.limits = limits if limits in PRESETS else "inversion"
        self._watched: Watched | None = None
        self._signals = (document.selection_changed, document.moved, document.volume_changed)
        for signal in self._signals:
            signal.connect(self._on_changed)

    def close(self) -> None:
        """Stop listening."""
        for signal in self._signals:
            signal.disconnect(self._on_changed)

    def set(self, mode: str | None = None, limits: str | None = None) -> None:
        """Choose what happens at the limit, or what the limit is.

        Raises
        ------
        InputError
            If there is no such choice.
        """
        mode, limits = mode or self.mode, limits or self.limits
        if mode not in MODES or limits not in PRESETS:
            raise InputError(f"a guard knows {', '.join(MODES)} and {', '.join(PRESETS)}")
        if (mode, limits) != (self.mode, self.limits):
            self.mode, self.limits = mode, limits
            self._on_changed()
            self.changed.emit()

    # ---- a drag -----------------------------------------------------------------------------

    def judge(self, points: Iterable[Index], vector: Array) -> Verdict:
        """What to do with a drag of control points by one vector."""
        if self.mode == "free":
            return Verdict(vector, vector)
        self.prepare(points)
        watched = self._watched
        if watched is None:
            return Verdict(vector, vector)
        if watched.guards is None:
            return Verdict(vector, vector, state="waiting")
        return self._weighed(watched.guards, vector)

    def _weighed(self, guards: Sequence[tuple[str, Guard]], vector: Array) -> Verdict:
        stops = [(guard.stop(vector), name) for name, guard in guards]
        if not stops:
            return Verdict(vector, vector)
        stop, name = min(stops, key=lambda pair: pair[0].amplitude)
        allowed = vector
        if self.mode == "stop" and stop.amplitude * (1 - MARGIN) < 1:
            allowed = vector * (stop.amplitude * (1 - MARGIN))
        unseen = together(guard.coverage for _, guard in guards)
        return Verdict(allowed, vector, stop, name, "ready", unseen)

    # ---- making guards ------------------------------------------------------------------------

    def prepare(self, points: Iterable[Index]) -> None:
        """Have a guard made for these points, unless it is there or on its way."""
        document = self._document
        model, item = document.settled_model, document.settled_model.active_lattice
        chosen = () if item is None else _free(item, points)
        wanted = Watched(model, chosen, self.limits)
        if self._watched is not None and self._watched.fits(wanted):
            return
        self._watched = None
        carried = [body for body in model.bodies if body.follows != Way.WALLS]
        bodies = [body for body in carried if countable(body.mesh)]
        if item is None or not chosen or not bodies or not is_last(model, item):
            return
        self._watched = wanted
        flat = np.ravel_multi_index(tuple(np.array(chosen).T), item.rest.shape).tolist()
        making = [(body.name, body.mesh, document.nodes(body.key)) for body in bodies]
        limits = PRESETS[self.limits]

        def work(progress: Progress) -> tuple[tuple[str, Guard], ...]:
            from ffdstudio.meshes.safety.guard import Guard

            guards = []
            for number, (name, mesh, nodes) in enumerate(making):
                progress(number / len(making), f"setting up the guard of {name}")
                embedding, start = nodes.bound(model.steps, item.key, progress)
                drag = embedding.drag(item.current, flat)
                guards.append((name, Guard(mesh, start, drag.influence, drag.rows, limits)))
            return tuple(guards)

        def done(guards: tuple[tuple[str, Guard], ...]) -> None:
            if self._watched is wanted:
                self._watched = Watched(model, chosen, wanted.limits, guards)
                self.ready.emit()

        def failed(error: Exception) -> None:
            if not isinstance(error, InputError):
                raise error
            done(())
            document.told.emit(f"No guard: {error}")

        def cancelled() -> None:
            if self._watched is wanted:  # the next drag of these points asks for it again
                self._watched = None

        label = "Setting up the guard"
        document.runner.start(label, work, done, failed, "guard", cancelled=cancelled)

    def _on_changed(self, _key: str = "") -> None:
        """Make the guard of the selected points once the mesh has settled."""
        document = self._document
        settled = all(document.volume(body.key) is not None for body in document.model.bodies)
        if self.mode != "free" and document.editing is None and settled:
            self.prepare(document.selection)


def _free(item: LatticeItem, points: Iterable[Index]) -> tuple[Index, ...]:
    frozen = item.frozen_mask
    return tuple(sorted(point for point in points if not frozen[point]))


def is_last(model: Model, item: LatticeItem) -> bool:
    """Whether a lattice deforms, and none behind it does."""
    keys = [step.key for step in model.steps]
    if item.key not in keys:
        return False
    return not any(step.deformed for step in model.steps[keys.index(item.key) + 1 :])


def _shape(model: Model) -> object:
    """All that a guard depends on: the meshes and the lattices that deform them."""
    meshes = [body.mesh for body in model.bodies]
    return [id(mesh) for mesh in meshes], model.active, [(x.rest, x.current) for x in model.steps]
