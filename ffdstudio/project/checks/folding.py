"""Whether the lattices of a document are locally invertible, worked out after each edit.

A lattice at rest is not looked at. As with quality, nothing is worked out while nobody looks,
and it is work for a worker: a large net has many knot spans.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from psygnal import Signal

from ffdstudio.engine import Lattice
from ffdstudio.engine.folds import Folds, folds
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.running import Progress

if TYPE_CHECKING:
    from ffdstudio.project.document import Document

MEANING = (
    "One sign of the Jacobian determinant over all knot spans means that the lattice as a map is "
    "locally invertible: nowhere does it turn space inside out. It does not mean that the cells "
    "are valid, whose edges are straight: they are tested by themselves, see the inverted cells. "
    "Nor does it mean that distant parts cannot overlap."
)
State = tuple[Lattice, Lattice]


class Foldings:
    """What is known of each lattice by its key.

    Notes
    -----
    Signal ``changed(key)``: the answer for a lattice is there, or is out of date.
    """

    changed = Signal(str)

    def __init__(self, document: Document) -> None:
        self._document = document
        self._watching = False
        self._asked: dict[str, State] = {}
        self._known: dict[str, Folds] = {}
        document.moved.connect(self._on_moved)

    def close(self) -> None:
        """Stop listening."""
        self._document.moved.disconnect(self._on_moved)

    def watch(self, on: bool) -> None:
        """Begin or stop to look after each edit."""
        self._watching = on
        self._on_moved()

    def known(self, key: str) -> Folds | None:
        """Answer for a lattice as it is; None for one at rest, and until it is known."""
        return self._known.get(key)

    def _on_moved(self) -> None:
        items = {item.key: item for item in self._document.settled_model.lattices}
        for key in [key for key in self._asked if key not in items or not items[key].deformed]:
            self._forget(key)
        for item in items.values():
            if self._watching and item.deformed and self._asked.get(item.key) != _state(item):
                self._ask(item)

    def _forget(self, key: str) -> None:
        self._asked.pop(key, None)
        self._known.pop(key, None)
        self.changed.emit(key)

    def _ask(self, item: LatticeItem) -> None:
        key, state = item.key, _state(item)
        self._forget(key)
        self._asked[key] = state

        def work(_progress: Progress) -> Folds:
            return folds(state[1], state[0])

        def done(found: Folds) -> None:
            if self._asked.get(key) is state:
                self._known[key] = found
                self.changed.emit(key)

        self._document.runner.start(
            f"Looking for folds of {item.name}", work, done, key=f"folds {key}"
        )


def _state(item: LatticeItem) -> State:
    return item.rest, item.current


def told(name: str, found: Folds | None) -> tuple[str, str]:
    """Sentence about a lattice, and whether it is "good", a "warning" or a "problem".

    Examples
    --------
    >>> told("Box", folds(Lattice.box([0, 0], [1, 1], shape=(3, 3))))
    ('Box is locally invertible.', 'good')
    """
    if found is None:
        return f"{name}: looking for folds …", "muted"
    if found.locally_invertible:
        return f"{name} is locally invertible.", "good"
    folded = bool(found.folded.any())
    count, ends = len(found.where), zip("ijk", found.where[0], strict=False)
    spans = f"{count} knot span{'' if count == 1 else 's'}"
    place = ", ".join(f"{axis} {low:.4g} to {high:.4g}" for axis, (low, high) in ends)
    first = f"at {place}" if count == 1 else f"the first at {place}"
    if folded:
        return f"{name} folds in {spans}, {first}.", "problem"
    return f"Undecided in {spans} whether {name} folds, {first}.", "warning"
