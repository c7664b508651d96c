"""A drag: begun, updated many times, committed as one entry or aborted without a trace.

The model shows the preview at once; displayed points follow when somebody asks for them
(`Document.refresh`), so that many mouse moves between two frames cost one deformation. Control
points on a symmetry plane slide in it whatever is asked of them (see `plane_constraints`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.project.commands import MovePoints, SetWeights
from ffdstudio.project.commands.base import Command, numbers
from ffdstudio.project.followers import DragFollower, Follower
from ffdstudio.project.model import Index, Model
from ffdstudio.project.plane_constraints import alike, planes_in, slid


class EditGuard(Protocol):
    """Who keeps edits that are no drags, such as typed values, from inverting cells."""

    def shorten(self, edit: Edit) -> None:
        """End an edit that is about to be committed before it does harm, if that is wanted."""
        ...


class Owner(Protocol):
    """Who has a model edited; see `editor.Editor`."""

    model: Model
    editing: Edit | None
    guard: EditGuard | None

    def preview(self, model: Model) -> None:
        """Show a model without entering it into the history."""
        ...

    def end(self, edit: Edit, command: Command | None) -> None:
        """End the edit, with a command or without a trace."""
        ...


class Edit:
    """Made by `Document.edit`.

    Attributes
    ----------
    points : tuple of tuple of int
        Control points that are edited; frozen ones are left out.
    start, weights : numpy.ndarray
        (k, 3) and (k,) what they were at the beginning.
    lasting : bool
        Whether it goes on while something else is done; a drag is committed then.
    """

    lasting = False
    guarded = False  # whether somebody has kept it from inverting cells already

    def __init__(self, document: Owner, key: str, points: Sequence[Index]) -> None:
        self._document = document
        self.before: Model = document.model
        self.item = self.before.lattice(key)
        self.points = tuple(points)
        self._where = tuple(np.array(self.points, dtype=np.int64).T)
        self._flat = np.ravel_multi_index(self._where, self.item.rest.shape).tolist()
        self.start: Array = self.item.current.control_points[self._where]
        self.weights: Array = self.item.current.weights[self._where]
        self._planes = planes_in(self.before)
        kept = slid(self.item.rest, self._where, self.start, self._planes)
        slack = 1e-12 * self.item.rest.diagonal
        self._on_planes = bool(np.abs(kept - self.start).max(initial=0.0) <= slack)
        self._positions, self._weights = self.start, self.weights
        self._vector: Array | None = None
        self._holds: dict[Follower, DragFollower | None] = {}

    # ---- update: always from the start, never from the last update ------------------------

    def translate(self, vector: ArrayLike) -> None:
        """Move all points by one vector from where they began: the fast way."""
        asked = numbers(vector, (3,), "a displacement")
        self._vector = self.along(asked) if self._on_planes else None
        self._show(self.start + asked, self.weights)

    def along(self, vector: Array) -> Array | None:
        """Make of a vector what all points make of it by sliding; None if they differ in that."""
        return alike(self.item.rest, self._where, vector, self._planes)

    def place(self, positions: ArrayLike) -> None:
        """Put the points to (k, 3) positions."""
        self._vector = None
        self._show(numbers(positions, self.start.shape, "positions"), self.weights)

    def weigh(self, weights: ArrayLike) -> None:
        """Give the points (k,) weights."""
        self._vector = None
        self._show(self.start, numbers(weights, self.weights.shape, "weights"))

    def _show(self, positions: Array, weights: Array) -> None:
        if self._document.editing is not self:  # somebody has ended it
            return
        positions = slid(self.item.rest, self._where, positions, self._planes)
        new = self._with(positions, weights)  # raises before anything has changed
        self._positions, self._weights = positions, weights
        self._document.preview(self.before.with_(replace(self.item, current=new)))

    def _with(self, positions: Array, weights: Array) -> Lattice:
        current = self.item.current
        net, all_weights = current.control_points.copy(), current.weights.copy()
        net[self._where], all_weights[self._where] = positions, weights
        return current.moved(net, all_weights)

    def lattice_with(self, positions: Array | None = None, weights: Array | None = None) -> Lattice:
        """The lattice with its points there, (k, 3), or with weights (k,); nothing is shown."""
        places = self.start if positions is None else positions
        places = slid(self.item.rest, self._where, places, self._planes)
        return self._with(places, self.weights if weights is None else weights)

    @property
    def state(self) -> tuple[Array, Array]:
        """(k, 3) positions and (k,) weights as previewed."""
        return self._positions, self._weights

    def _between(self, share: float, whole: tuple[Array, Array]) -> tuple[Array, Array]:
        places = self.start + share * (whole[0] - self.start)
        return places, self.weights * (whole[1] / self.weights) ** share

    def lattice_at(self, share: float, whole: tuple[Array, Array]) -> Lattice:
        """The lattice a share of the way from the start to a state."""
        return self.lattice_with(*self._between(share, whole))

    def go_to(self, share: float, whole: tuple[Array, Array]) -> None:
        """Preview a share of the way from the start to a state."""
        self._vector = None
        self._show(*self._between(share, whole))

    @property
    def current(self) -> Lattice:
        """The lattice as previewed."""
        return self._document.model.lattice(self.item.key).current

    # ---- displayed points ------------------------------------------------------------------

    def follow(self, follower: Follower) -> None:
        """Take displayed points where the preview wants them, if their embedding is known."""
        if follower not in self._holds:
            self._holds[follower] = follower.hold(self.item.key)
        hold = self._holds[follower]
        if hold is not None and self._vector is not None:
            hold.pull(self._flat, self._vector)
        elif hold is not None:
            hold.reshape(self.current)

    def forget(self, follower: Follower) -> None:
        """Take hold of a follower anew: it has settled in the meantime."""
        self._holds.pop(follower, None)

    def go_on_from(self, model: Model) -> None:
        """Take a model that differs in looks only for the one it began with."""
        raise NotImplementedError  # a drag does not last

    # ---- end ---------------------------------------------------------------------------------

    def commit(self) -> None:
        """Make it one entry of the history; none if nothing has changed."""
        guard = self._document.guard
        if guard is not None and not self.guarded and not self.lasting:
            guard.shorten(self)
        command = self.command
        self._document.end(self, command)

    def abort(self) -> None:
        """Put everything back to what it was."""
        self._document.end(self, None)

    @property
    def command(self) -> Command | None:
        """What has been done so far, as a command; None if nothing has."""
        key, start = self.item.key, (self._positions == self.start).all(axis=1)
        weighed, moved = np.flatnonzero(self._weights != self.weights), np.flatnonzero(~start)
        if len(weighed):
            chosen = tuple(self.points[k] for k in weighed)
            return SetWeights(key, chosen, tuple(self._weights[weighed].tolist()))
        if len(moved):
            chosen = tuple(self.points[k] for k in moved)
            positions = tuple(map(tuple, self._positions[moved].tolist()))
            return MovePoints(key, chosen, positions)
        return None
