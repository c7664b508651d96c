"""Iterates of a study shown in place of the lattice: one edit, begun, shown often, ended.

It stands where a drag stands (`Document.editing`), so that the viewport shows it as it shows
a drag, an undo or Esc takes it back without a trace, and whatever else the user edits keeps
what he sees: one entry of the history, *Use iterate*. Unlike a drag it may refine the net, and
it lasts while the user hides, colours or names things to see it better.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ffdstudio.engine import Lattice
from ffdstudio.engine.spaces import in_space_of, with_knots_of
from ffdstudio.project.commands import UseIterate
from ffdstudio.project.commands.base import Command
from ffdstudio.project.edit import Edit
from ffdstudio.project.followers import DragFollower, Follower
from ffdstudio.project.model import LatticeItem, Model

if TYPE_CHECKING:
    from ffdstudio.project.editor import Editor

KEPT = 12  # refined embeddings: scrubbing to and fro finds them again


class Scrub(Edit):
    """Shows states of one lattice, refined ones too; made by `scrub`.

    Attributes
    ----------
    shown : Lattice or None
    note : str
        What the history will say of it.
    inverted : int or None
        Cells that it turns inside out; None until somebody has counted them.
    """

    lasting = True

    def __init__(self, document: Editor, key: str) -> None:
        self._document = self._editor = document
        self.before: Model = document.model
        self.item = self.before.lattice(key)
        self.points = ()
        self.shown: Lattice | None = None
        self.note = ""
        self.inverted: int | None = None
        self._rests = [self.item.rest]
        self._holds: dict[Follower, DragFollower | None] = {}
        self._finer: dict[tuple[int, int], DragFollower] = {}

    def show(self, current: Lattice, note: str = "") -> None:
        """Show a state of the lattice; knots that only one of both has are inserted exactly."""
        if self._document.editing is not self:
            return
        current = with_knots_of(current, self.item.rest)
        if current != self.shown:
            self.inverted = None
        self.shown, self.note = current, note
        self._put(self._as_shown())

    def _as_shown(self) -> LatticeItem:
        if self.shown is None:
            return self.item
        return replace(self.item, rest=self.rest_of(self.shown), current=self.shown)

    def go_on_from(self, model: Model) -> None:
        """See `Edit.go_on_from`."""
        self.before, self.item = model, model.lattice(self.item.key)
        self._document.preview(model.with_(self._as_shown()))

    def _put(self, item: LatticeItem) -> None:
        document = self._editor
        other = document.model.lattice(item.key).rest.shape != item.rest.shape
        if other:
            document.select(())
        document.preview(self.before.with_(item))
        if other:
            document.structure_changed.emit()

    def rest_of(self, current: Lattice) -> Lattice:
        """Lattice at rest in the space of a state; the same object each time."""
        for rest in self._rests:
            if rest.same_space(current):
                return rest
        self._rests.append(in_space_of(self.item.rest, current))
        return self._rests[-1]

    def follow(self, follower: Follower) -> None:
        """See `Edit.follow`."""
        if follower not in self._holds:
            self._holds[follower] = follower.hold(self.item.key)
        hold = self._holds[follower]
        if hold is not None and self.shown is not None:
            self._in_space(follower, hold).reshape(self.shown)

    def _in_space(self, follower: Follower, hold: DragFollower) -> DragFollower:
        assert self.shown is not None
        rest = self.rest_of(self.shown)
        if rest is self.item.rest:
            return hold
        place = (id(follower), id(rest))
        if place not in self._finer:
            self._finer[place] = hold.refined(rest)
            while len(self._finer) > KEPT:
                del self._finer[next(iter(self._finer))]
        return self._finer[place]

    def forget(self, follower: Follower) -> None:
        """See `Edit.forget`."""
        super().forget(follower)
        self._finer = {k: hold for k, hold in self._finer.items() if k[0] != id(follower)}

    def abort(self) -> None:
        """Put everything back, the net first: views have to draw the old one again."""
        if self._document.editing is self:
            self._put(self.item)
        super().abort()

    @property
    def command(self) -> Command | None:
        """What is shown, as a command; None if it is what was there before."""
        if self.shown is None or self.shown == self.item.current:
            return None
        return UseIterate(self.item.key, self.shown, self.note)


def scrub(document: Editor, key: str) -> Scrub:
    """Begin to show iterates in place of a lattice; an edit under way is committed."""
    if isinstance(document.editing, Scrub) and document.editing.item.key == key:
        return document.editing
    if document.editing is not None:
        document.editing.commit()
    document.editing = Scrub(document, key)
    return document.editing
