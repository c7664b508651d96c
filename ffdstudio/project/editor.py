"""Who edits a model: its history and journal, the selection, the drag under way, and who is told.

It knows neither what is displayed nor how files are read and written: those stand on it, and
`document.Document` puts all of it together.

1. The model is an immutable value (see `model`). It changes by `do(command)`, by `undo`, `redo`
   and `jump`, and while an `Edit` (a drag) is under way; on one thread only.
2. Two kinds of signal. *moving*: a newer preview is there, emitted once until somebody looks, so
   50 mouse moves give one; viewport only. *moved*: positions of control points or displayed
   points changed for good, once an edit; quality, plots, autosave.
3. Long work goes to `runner` (see `running`). Work gets values and returns values; what comes of
   it is taken on the document's thread.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from psygnal import Signal

from ffdstudio.errors import InputError
from ffdstudio.files import Stamp
from ffdstudio.meshes import Mesh
from ffdstudio.project.commands import Command
from ffdstudio.project.edit import Edit, EditGuard
from ffdstudio.project.files.journal import Journal, commands_of
from ffdstudio.project.files.model_codec import to_file
from ffdstudio.project.files.records import ProjectFile
from ffdstudio.project.files.write_order import Turns
from ffdstudio.project.history import Entry, History
from ffdstudio.project.model import Index, Model
from ffdstudio.project.running import Runner, RunNow
from ffdstudio.project.study_records import StudyRecords
from ffdstudio.project.view.surface import DisplaySurface

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record


class Editor:
    """A model that is edited; attributes and signals are documented at `document.Document`."""

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
        self.guard: EditGuard | None = None
        self.path: Path | None = None
        self.sections: dict[str, Any] = {}
        self.records = StudyRecords()
        self.surfaces: WeakKeyDictionary[Mesh, DisplaySurface] = WeakKeyDictionary()
        self.ask: Callable[[ProjectFile], ProjectFile | None] | None = None
        self.may_replace: Callable[[], bool] | None = None
        self.may_overwrite: Callable[[Path], bool] | None = None
        self.on_disk: Stamp | None = None
        self.turns = Turns()
        self._packs = False
        self._saved, self._recorded = self.model, 0
        self._stale = False

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
        self.records.forget_new(before, after)
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
        self._put_back()
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
        return self.settled_model is not self._saved or self.records.version != self._recorded

    # ---- what becomes of the whole -------------------------------------------------------

    def snapshot(self) -> ProjectFile:
        """Return what a project file would hold now; a value that a worker may write."""
        return to_file(self.settled_model, self.sections, self.records)

    def replace(
        self,
        model: Model,
        sections: dict[str, Any],
        path: Path | None,
        saved: bool = True,
        records: dict[str, list[Record]] | None = None,
    ) -> None:
        """Take a model that was opened, with records of its studies; the history begins anew."""
        self.editing, self.path, self.sections = None, path, sections
        self.on_disk = None
        self.records.take(model, records or {}, path)
        self.history, self.journal = History(), Journal(list(commands_of(model)))
        self._packs = any(body.packed is not None for body in model.bodies)
        self._set_model(model)
        self.saved(model if saved else Model())

    def clear(self) -> None:
        """Begin a new, empty project."""
        self.replace(Model(), {}, None)

    def saved(self, model: Model, records: int = 0) -> None:
        """Take note that a model is in the project file, with so many changes of records."""
        self._saved, self._recorded = model, records
        self.history_changed.emit()

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
        self._follow(model)
        if _structure(before) != _structure(model):
            self.structure_changed.emit()
        if lost:
            self.selection_changed.emit()
        self.moved.emit()
        self._start_work()

    # ---- for who shows it -------------------------------------------------------------------

    def _follow(self, model: Model) -> None:
        """Have displayed points follow a model before anybody is told of it."""

    def _put_back(self) -> None:
        """Take back what a drag has done to displayed points."""

    def _start_work(self) -> None:
        """Start what it takes for the rest to follow."""


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
    return model.bodies, model.active, lattices, model.studies
