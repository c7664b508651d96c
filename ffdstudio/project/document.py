"""The document: the single truth that every view listens to.

1. `Document.model` is an immutable value (see `model`). It changes by `do(command)`, by
   `undo`, `redo` and `jump`, and while an `Edit` (a drag) is under way; on one thread only.
2. Two kinds of signal. *moving*: a newer preview is there, emitted once until somebody
   calls `refresh`, so 50 mouse moves give one; viewport only. *moved*: positions of control
   points or displayed points changed for good, once an edit; quality, plots, autosave.
3. Long work goes to `runner` (see `running`): reading, embedding, volumes, saving. Work
   gets values and returns values; what comes of it is taken here, on the document's thread.
4. Displayed points (see `followers`) are bound to the lattices when they appear and then
   follow at once; volume nodes follow by work started after *moved*. Nothing that happens
   in a frame knows how many nodes a volume has.
5. What is written is computed from the model alone (`followers.deformed`), never from what
   is displayed: a replay of the journal gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from ffdstudio.aliases import Array, PathLike
from ffdstudio.errors import InputError
from ffdstudio.project.commands import Command
from ffdstudio.project.edit import Edit
from ffdstudio.project.files import filing
from ffdstudio.project.files.journal import Journal, commands_of
from ffdstudio.project.files.model_codec import to_file
from ffdstudio.project.files.opening import Opened
from ffdstudio.project.files.records import ProjectFile
from ffdstudio.project.files.recovery import Left
from ffdstudio.project.files.write_order import Turns
from ffdstudio.project.followers import Follower
from ffdstudio.project.history import Entry, History
from ffdstudio.project.model import Index, Model
from ffdstudio.project.running import Runner, RunNow
from ffdstudio.project.view.body_views import Displays
from ffdstudio.project.view.surface import Surface
from ffdstudio.project.view.volume import Volume


class Document:
    """Bodies, lattices, selection, history, and the points that follow.

    Parameters
    ----------
    runner : Runner, optional
        Who runs long work; by default it is run at once.

    Attributes
    ----------
    model : Model
        Bodies and lattices as they are now, the preview of a drag included.
    history : History
        What was done, with labels; change it by `undo`, `redo` and `jump` only.
    journal : Journal
        The same as lines to replay.
    selection : frozenset of tuple of int
        Selected control points (i, j, k) of the active lattice; not part of the history.
    editing : Edit or None
        The drag under way.
    path : pathlib.Path or None
        The project file.
    sections : dict
        Other parts of the project file (studies, ...), kept as they are.
    ask : callable or None
        Called with a `ProjectFile` whose meshes are missing or changed; see `filing`.
    may_replace : callable or None
        Called when a project has been read, if something was done in the meantime: whether it
        may go.

    Notes
    -----
    Signals, all on the document's thread:

    - ``moving()``, ``moved()``: see above.
    - ``structure_changed()``: bodies or lattices came, went, were renamed, hidden, coloured,
      refined or frozen, or another one became active.
    - ``selection_changed()``, ``history_changed()`` (also when saved).
    - ``volume_changed(key)``: `volume(key)` is known now, or is no longer.
    - ``problem(title, cause, doing)``: something that was asked for did not work; `doing` is
      "open", "save", "export" or "export lattice" when that can be tried with another file,
      "note" when it did work but not quite, else empty.
    - ``told(text)``: something that was asked for is done; for the status line.
    - ``filed(path)``: a mesh, lattice or project was read, or a project written.

    Examples
    --------
    >>> from ffdstudio.project.commands import CreateBox
    >>> document = Document()
    >>> document.do(CreateBox("Box", (0, 0, 0), (1, 1, 1), (4, 3, 3), (3, 2, 2)))
    >>> drag = document.edit([(3, 2, 2)])
    >>> drag.translate([0.5, 0, 0])
    >>> drag.commit()
    >>> document.history.labels
    ['Create Box 4×3×3', 'Move point (3, 2, 2)']
    """

    moving = Signal()
    moved = Signal()
    structure_changed = Signal()
    selection_changed = Signal()
    history_changed = Signal()
    volume_changed = Signal(str)
    problem = Signal(str, str, str)
    told = Signal(str)
    filed = Signal(Path)

    def __init__(self, runner: Runner | None = None) -> None:
        self.runner: Runner = RunNow() if runner is None else runner
        self.model = Model()
        self.history = History()
        self.journal = Journal()
        self.selection: frozenset[Index] = frozenset()
        self.editing: Edit | None = None
        self.path: Path | None = None
        self.sections: dict[str, Any] = {}
        self.ask: Callable[[ProjectFile], ProjectFile | None] | None = None
        self.may_replace: Callable[[], bool] | None = None
        self.turns = Turns()
        self._packs = False
        self._saved = self.model
        self._stale = False
        self._displays = Displays(self)

    # ---- edits ------------------------------------------------------------------------

    def do(self, command: Command) -> None:
        """Carry out a command and enter it into history and journal.

        A drag under way is committed before; an iterate that is shown stays if the command
        is about looks only.

        Raises
        ------
        InputError
            If it cannot be carried out; nothing has changed then.
        """
        beside = self.editing if command.looks_only else None
        if self.editing is not None and (beside is None or not beside.lasting):
            self.editing.commit()
        before = self.settled_model
        after = command.apply(before)
        self.history.push(Entry(command, command.label(before), before, after))
        self.journal.record(command)
        if self.editing is None:
            self._set_model(after)
        else:
            self.editing.go_on_from(after)
            self.structure_changed.emit()
        self.history_changed.emit()

    def undo(self) -> None:
        """Take back the last command; during a drag, the drag."""
        if self.editing is not None:
            self.editing.abort()
        elif self.history.position > 0:
            self.jump(self.history.position - 1)

    def redo(self) -> None:
        """Do again what was taken back."""
        if self.history.position < len(self.history.entries):
            self.jump(self.history.position + 1)

    def jump(self, position: int) -> None:
        """Go to the state after the first `position` entries of the history."""
        if self.editing is not None:
            self.editing.abort()
        if position == self.history.position:
            return
        model = self.history.at(position)
        self.journal.record(position)
        self._set_model(model)
        self.history_changed.emit()

    def edit(self, points: Iterable[Index] | None = None) -> Edit:
        """Begin a drag of control points of the active lattice (default: the selection).

        Feed it with `translate(vector)`, `place(positions)` or `weigh(weights)`; end it with
        `commit()`, which makes one entry, or `abort()`.

        Raises
        ------
        InputError
            If there is no active lattice, or nothing in it to move: frozen points stay.
        """
        if self.editing is not None:
            self.editing.commit()
        item = self.model.active_lattice
        if item is None:
            raise InputError("there is no lattice to edit")
        frozen, chosen = item.frozen_mask, self.selection if points is None else points
        free = sorted(point for point in chosen if not frozen[point])
        if not free:
            raise InputError("none of the chosen control points can move")
        self.editing = Edit(self, item.key, free)
        return self.editing

    def preview(self, model: Model) -> None:
        """Show a model without entering it into the history; for `Edit`."""
        self.model = model
        self.tell_moving()

    def end(self, edit: Edit, command: Command | None) -> None:
        """End a drag with a command or, with None, without a trace; for `Edit`."""
        if self.editing is not edit:
            return
        self.editing, self.model = None, edit.before
        if command is not None:
            self.do(command)
            return
        self._stale = False
        self._displays.put_back(self.model)
        self.moved.emit()

    def select(self, points: Iterable[Index]) -> None:
        """Select control points of the active lattice."""
        item, chosen = self.model.active_lattice, frozenset(points)
        if item is None:
            chosen = frozenset()
        elif not chosen <= set(np.ndindex(item.rest.shape)):
            raise InputError(f"{item.name} has no such control point")
        if chosen != self.selection:
            self.selection = chosen
            self.selection_changed.emit()

    @property
    def settled_model(self) -> Model:
        """The model without the preview of a drag."""
        return self.model if self.editing is None else self.editing.before

    @property
    def modified(self) -> bool:
        """Whether there is anything that was not saved."""
        return self.settled_model is not self._saved

    # ---- what is displayed --------------------------------------------------------------

    def refresh(self) -> None:
        """Bring displayed points up to the newest preview; call it before drawing."""
        self._stale = False
        if self.editing is not None:
            for body in self.model.bodies:
                if body.visible:
                    self.editing.follow(self._displays[body.key].in_hand)

    def surface(self, key: str) -> Surface:
        """What to draw of a body: polygons, lines, markers, node numbers, the proxy."""
        return self._displays[key].surface

    def points(self, key: str) -> Array:
        """(m, 3) displayed points of a body now, one for each of `surface(key).nodes`.

        While a drag is under way and the surface has a proxy, they stay behind: show
        `proxy_points`.
        """
        return self._displays[key].full.positions

    def proxy_points(self, key: str) -> Array:
        """(k, 3) points of the proxy now, one for each of `surface(key).proxy.rows`."""
        proxy = self._displays[key].proxy
        if proxy is None:
            raise InputError("this surface needs no proxy")
        return proxy.positions

    def inside(self, key: str) -> NDArray[np.bool_] | None:
        """(m,) displayed points of a body inside the active lattice; None until known."""
        active = self.model.active
        return None if active is None else self._displays[key].full.inside(active)

    def nodes(self, key: str) -> Follower:
        """All nodes of a body and what they are bound to; workers may ask it."""
        return self._displays[key].nodes

    def volume(self, key: str) -> Volume | None:
        """All nodes of a body as deformed, inverted cells counted; None until known."""
        return self._displays[key].volume

    def checking(self, key: str) -> bool:
        """Whether `volume(key)` is being worked out."""
        return self._displays[key].checking

    def check(self) -> None:
        """Have the volumes worked out that nobody works on: the user has cancelled that."""
        self._displays.start_work()

    # ---- files --------------------------------------------------------------------------

    def open_mesh(self, path: PathLike) -> None:
        """Read a mesh and add it as a body."""
        filing.open_mesh(self, path)

    def export_mesh(self, key: str, path: PathLike) -> None:
        """Write a body as it is deformed."""
        filing.export_mesh(self, key, path)

    def import_lattice(self, path: PathLike, block: str | None = None) -> None:
        """Read a lattice file and add it."""
        filing.import_lattice(self, path, block)

    def export_lattice(self, key: str, path: PathLike) -> None:
        """Write a lattice, at rest and as it is."""
        filing.export_lattice(self, key, path)

    def open(self, path: PathLike) -> None:
        """Read a project, which replaces everything."""
        filing.open_project(self, path)

    def save(self, path: PathLike | None = None, pack_meshes: bool | None = None) -> None:
        """Write the project; by default to where it came from, meshes in it or not as before."""
        target = self.path if path is None else path
        if target is None:
            raise InputError("the project has no file yet")
        if pack_meshes is not None:
            self._packs = pack_meshes
        filing.save(self, target, self._packs)

    def snapshot(self) -> ProjectFile:
        """Return what a project file would hold now; a value that a worker may write."""
        return to_file(self.settled_model, self.sections)

    def recover(self, left: Left) -> None:
        """Read the autosave of a session that died (see `recovery`); it counts as not saved."""
        filing.open_project(self, left.autosave, left)

    def replace(
        self, model: Model, sections: dict[str, Any], path: Path | None, saved: bool = True
    ) -> None:
        """Take a model that was opened; the history begins anew."""
        self.editing, self.path, self.sections = None, path, sections
        self.history, self.journal = History(), Journal(list(commands_of(model)))
        self._packs = any(body.packed is not None for body in model.bodies)
        self._set_model(model)
        self.saved(model if saved else Model())

    def clear(self) -> None:
        """Begin a new, empty project."""
        self.replace(Model(), {}, None)

    def saved(self, model: Model) -> None:
        """Take note that a model is in the project file."""
        self._saved = model
        self.history_changed.emit()

    def register_surface(self, opened: Opened) -> None:
        """Take over the surface of a mesh that a worker has worked out."""
        assert opened.command.mesh is not None
        self._displays.surfaces[opened.command.mesh] = opened.surface

    def failed(self, title: str, doing: str = "") -> Callable[[Exception], None]:
        """Return what to do with an error of work: tell the cause if it is one of input."""

        def tell(error: Exception) -> None:
            if not isinstance(error, InputError):
                raise error
            self.problem.emit(title, str(error), doing)

        return tell

    # ---- keeping up ---------------------------------------------------------------------

    def tell_moving(self) -> None:
        """Say once that there is something newer to show."""
        if not self._stale:
            self._stale = True
            self.moving.emit()

    def _set_model(self, model: Model) -> None:
        """Take another model; when views are told, everything fits together already."""
        before, self.model, self._stale = self.model, model, False
        kept = self.selection if _same_net(before, model) else frozenset()
        lost, self.selection = kept != self.selection, kept
        self._displays.take(model)
        if _structure(before) != _structure(model):
            self.structure_changed.emit()
        if lost:
            self.selection_changed.emit()
        self.moved.emit()
        self._displays.start_work()


def _same_net(before: Model, after: Model) -> bool:
    """Whether selected control points mean the same in both models."""
    old, new = before.active_lattice, after.active_lattice
    if old is None or new is None:
        return False
    return old.key == new.key and old.rest.shape == new.rest.shape


def _structure(model: Model) -> object:
    """All that `structure_changed` is about: everything but where control points are."""
    lattices = [
        (item.key, item.name, item.rest, item.frozen, item.visible, item.enabled, item.shapes)
        for item in model.lattices
    ]
    return model.bodies, model.active, lattices
