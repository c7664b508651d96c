"""Points that follow the lattices.

1. What is written comes from `deformed`: a function of points and lattices, nothing else.
2. What is displayed comes from a `Follower`, which keeps embeddings and knows while a drag
   is under way which rows move.
3. Lattices compose (see `model`). When an earlier one moves, the points of a later one have
   to be embedded again; until that is done the later one's displacement is carried along
   as it was, which is what a drag shows too.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Embedding, Lattice, embed
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.running import Progress, no_progress

if TYPE_CHECKING:
    from ffdstudio.engine.drag import Drag

KEPT = 3  # embeddings beyond those in use: enough to undo a refinement, or to go to and fro


def deformed(
    points: Array, lattices: Iterable[LatticeItem], progress: Progress = no_progress
) -> Array:
    """(n, 3) points moved by the lattices in order; the same bits where nothing moves.

    Parameters
    ----------
    points : numpy.ndarray
        (n, 3) points of a mesh at rest.
    lattices : iterable of LatticeItem
        As `Model.steps` gives them.
    progress : callable
        Called with a fraction and a text between the steps.
    """
    moving = [item for item in lattices if item.deformed]
    for number, item in enumerate(moving):
        progress(number / len(moving), f"deforming by {item.name}")
        points = embed(item.rest, points).deform(item.current)
    return points


@dataclass(frozen=True, eq=False)
class LatticeLink:
    """One lattice's part in the way of the points: `start` -> `end`."""

    item: LatticeItem
    start: Array
    embedding: Embedding | None
    end: Array


class Bindings:
    """Embeddings of one set of points, shared by its followers in all threads.

    Only one thread at a time makes embeddings, so that work which is out of date is not done
    twice: whoever wants the same one waits and finds it.
    """

    def __init__(self) -> None:
        self._known: list[tuple[Array, Embedding]] = []
        self._making = threading.Lock()

    def find(self, rest: Lattice | None, points: Array) -> Embedding | None:
        """Return the embedding of points in a lattice if it has been made."""
        for start, embedding in self._known:
            if embedding.lattice is rest and (start is points or np.array_equal(start, points)):
                return embedding
        return None

    def make(self, item: LatticeItem, points: Array, room: int, progress: Progress) -> Embedding:
        """Return the embedding, made if need be; at most `room` of them are kept."""
        with self._making:
            found = self.find(item.rest, points)
            if found is not None:
                return found
            progress(0.0, f"embedding {len(points)} points in {item.name}")
            coarser = self.find(item.coarser, points)
            made = embed(item.rest, points) if coarser is None else coarser.refined(item.rest)
            _rehearse(made)
            self._known = [(points, made), *self._known][:room]
            return made


class Follower:
    """A set of points and where the lattices take it.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3) at rest.
    positions : numpy.ndarray
        (n, 3) now; replaced by `settle`, written in place by a `DragFollower`.
    settled : bool
        Whether every embedding that `positions` need was known.
    """

    def __init__(self, points: ArrayLike, bindings: Bindings | None = None) -> None:
        self.points: Array = np.ascontiguousarray(points, dtype=np.float64)
        self.positions = self.points
        self.settled = True
        self._links: dict[str, LatticeLink] = {}
        self._bindings = Bindings() if bindings is None else bindings

    def settle(self, lattices: Sequence[LatticeItem]) -> None:
        """Take the points where the lattices want them, as far as embeddings are known."""
        self._pass(lattices, lambda item, points: self._bindings.find(item.rest, points))

    def embed(self, lattices: Sequence[LatticeItem], progress: Progress = no_progress) -> Array:
        """Return the (n, 3) positions, with whatever embeddings that takes.

        This may be long and leaves the follower alone, so that a worker can do it; `settle`
        finds the embeddings afterwards.
        """
        return self._bound(lattices, progress).positions

    def bound(
        self, lattices: Sequence[LatticeItem], key: str, progress: Progress = no_progress
    ) -> tuple[Embedding, Array]:
        """Embedding in one of the lattices, and the (n, 3) points that it takes them to.

        Like `embed`, it leaves the follower alone.
        """
        link = self._bound(lattices, progress)._links[key]
        assert link.embedding is not None
        return link.embedding, link.end

    def _bound(self, lattices: Sequence[LatticeItem], progress: Progress) -> Follower:
        """Another follower of the same points, with whatever embeddings that takes."""
        own, room = type(self)(self.points, self._bindings), KEPT + len(lattices)
        own._pass(lattices, lambda item, points: self._bindings.make(item, points, room, progress))
        return own

    def _pass(
        self,
        lattices: Sequence[LatticeItem],
        binding: Callable[[LatticeItem, Array], Embedding | None],
    ) -> None:
        x, links = self.points, {}
        for item in lattices:
            embedding = binding(item, x)
            end = self._end(item, x, embedding)
            links[item.key] = LatticeLink(item, x, embedding, end)
            x = end
        self.settled = all(link.embedding is not None for link in links.values())
        self.positions, self._links = x, links

    def _end(self, item: LatticeItem, start: Array, embedding: Embedding | None) -> Array:
        if not item.deformed:
            return start
        if embedding is not None:
            return embedding.deform(item.current)
        old = self._links.get(item.key)
        return start if old is None or old.end is old.start else start + (old.end - old.start)

    def inside(self, key: str) -> NDArray[np.bool_] | None:
        """(n,) which points lie inside a lattice; None while that is not known."""
        link = self._links.get(key)
        return None if link is None or link.embedding is None else link.embedding.inside

    # ---- a drag -----------------------------------------------------------------------

    def hold(self, key: str) -> DragFollower | None:
        """Get ready to follow one lattice; None if its embedding is not known."""
        link = self._links.get(key)
        if link is None or link.embedding is None:
            return None
        self.positions = np.array(self.positions)  # ours to write into
        return DragFollower(link, self.positions)


def _rehearse(embedding: Embedding) -> None:
    """Deform and drag once, so that the first frame of a drag does not load the kernels."""
    out = embedding.deform(embedding.lattice.moved(embedding.lattice.control_points + 1.0))
    embedding.drag(embedding.lattice, [0]).move([0.0, 0.0, 0.0], out)


class DragFollower:
    """A follower in the hand: writes into its positions, frame by frame."""

    def __init__(self, link: LatticeLink, positions: Array) -> None:
        assert link.embedding is not None
        self._embedding = link.embedding
        self._positions = positions
        self._begin = link.item.current
        # what later lattices add, carried along as it is
        self._later = None if np.array_equal(positions, link.end) else positions - link.end
        self._drag: Drag | None = None
        self._points: Sequence[int] | None = None

    def refined(self, rest: Lattice) -> DragFollower:
        """Hold of the same points for a refinement of the lattice; only `reshape` it."""
        other = copy(self)
        other._embedding = self._embedding.refined(rest)
        return other

    def pull(self, points: Sequence[int], vector: ArrayLike) -> None:
        """Move control points (flat indices) by one vector from where they began."""
        if self._drag is None or self._points is not points:
            self._drag, self._points = self._embedding.drag(self._begin, points), points
        self._drag.move(vector, self._positions)
        if self._later is not None:
            self._positions[self._drag.rows] += self._later[self._drag.rows]

    def reshape(self, current: Lattice) -> None:
        """Follow any state of the lattice."""
        self._embedding.deform(current, out=self._positions)
        if self._later is not None:
            self._positions += self._later
