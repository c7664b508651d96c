"""What the Edit, Select and Lattice menus do."""

from __future__ import annotations

from collections.abc import Callable

from ffdstudio.gui.dialogs.knot import KnotDialog
from ffdstudio.gui.dialogs.transform import TransformDialog
from ffdstudio.gui.panels.lattice import LatticePanel
from ffdstudio.gui.studio import Studio
from ffdstudio.project import commands as c
from ffdstudio.project.interaction import numeric_edits as typed
from ffdstudio.project.interaction import selection as sel
from ffdstudio.project.interaction.tools import Tools
from ffdstudio.project.model import LatticeItem


class EditHandler:
    """Undo, redo, modes, reset, typed transformations."""

    def __init__(self, studio: Studio, tools: Tools) -> None:
        self._studio, self._tools = studio, tools

    def undo(self) -> None:
        """Take back the last edit."""
        self._studio.document.undo()

    def redo(self) -> None:
        """Do again what was taken back."""
        self._studio.document.redo()

    def move_mode(self) -> None:
        """A drag moves."""
        self._studio.state.set_mode("move")

    def rotate_mode(self) -> None:
        """A drag turns."""
        self._studio.state.set_mode("rotate")

    def scale_mode(self) -> None:
        """A drag scales."""
        self._studio.state.set_mode("scale")

    def skin_mode(self) -> None:
        """A drag takes a point of the mesh along."""
        self._studio.state.set_mode("skin")

    def soft(self, on: bool) -> None:
        """Near points follow, or not."""
        self._studio.state.spread(soft=on)

    def mirror(self, axis: int) -> None:
        """Points opposite the plane of an axis follow; -1 for none."""
        self._studio.state.spread(mirror=axis)

    def transform(self) -> None:
        """Ask for numbers and move, turn or scale by them."""
        dialog = TransformDialog(self._tools, self._studio.asker.parent)
        accepted = self._studio.asker.run(dialog)
        dialog.end(accepted)

    def reset_selected(self) -> None:
        """Put the selected points back."""
        item, points = _active(self._studio), tuple(sorted(self._studio.document.selection))
        self._studio.do(c.ResetPoints(item.key, points))

    def reset_weights(self) -> None:
        """Set the weights of the selected points to 1."""
        weigh = lambda: typed.set_weight(self._studio.document, 1.0)  # noqa: E731
        self._studio.attempt("Reset weights", weigh)

    def reset_all(self) -> None:
        """Put all points of the active lattice back."""
        _reset_all(self._studio)


class SelectHandler:
    """Sets of control points."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio

    def box_mode(self) -> None:
        """A drag draws a rubber band."""
        self._studio.state.set_mode("box")

    def all(self) -> None:
        """All that can move."""
        item = _active(self._studio)
        frozen = item.frozen_mask
        free = [point for point in sel.everything(item.rest.shape) if not frozen[point]]
        self._studio.document.select(free)

    def none(self) -> None:
        """Nothing."""
        self._studio.document.select(())

    def invert(self) -> None:
        """What is not selected."""
        self._apply(lambda chosen, shape: sel.inverse(chosen, shape))

    def grow(self) -> None:
        """The neighbours too."""
        self._apply(sel.grow)

    def row(self, axis: int) -> None:
        """Rows through the selected points."""
        self._apply(lambda chosen, shape: sel.row(chosen, shape, axis))

    def plane(self, axis: int) -> None:
        """Planes through the selected points."""
        self._apply(lambda chosen, shape: sel.plane(chosen, shape, axis))

    def _apply(self, change: Callable[[sel.Selection, tuple[int, ...]], sel.Selection]) -> None:
        document = self._studio.document
        document.select(change(document.selection, _active(self._studio).rest.shape))


class LatticeHandler:
    """Building and refining."""

    def __init__(self, studio: Studio, panel: LatticePanel, show: Callable[[], None]) -> None:
        self._studio, self._panel, self._show = studio, panel, show
        self.load_paths: Callable[[], None] = lambda: None
        panel.summary.insert.clicked.connect(self.insert_knot)
        panel.summary.refit.clicked.connect(self.refit)
        panel.summary.reset.clicked.connect(lambda: _reset_all(studio))

    def new(self) -> None:
        """Open the form."""
        self._show()
        self._panel.build()

    def around(self, key: str, marker: str) -> None:
        """Open the form for a body or a marker."""
        self._show()
        self._panel.build(key, marker)

    def load(self) -> None:
        """Ask for a lattice file."""
        self.load_paths()

    def refit(self) -> None:
        """Open the form for the active lattice."""
        self._show()
        self._panel.refit(_active(self._studio))

    def insert_knot(self) -> None:
        """Ask for direction and place, and insert."""
        item = _active(self._studio)
        dialog = KnotDialog(item.rest, self._studio.asker.parent)
        if self._studio.asker.run(dialog) and not dialog.problem:
            self._studio.do(c.InsertKnots(item.key, dialog.axis, (dialog.knot,)))

    def elevate(self, axis: int) -> None:
        """Raise the degree."""
        self._studio.do(c.ElevateDegree(_active(self._studio).key, axis))

    def next(self) -> None:
        """Edit the next lattice."""
        model = self._studio.document.model
        keys = [item.key for item in model.lattices]
        if model.active is not None:
            self._studio.do(c.Activate(keys[(keys.index(model.active) + 1) % len(keys)]))

    def toggle(self) -> None:
        """Switch the active lattice on or off."""
        item = _active(self._studio)
        self._studio.do(c.Enable(item.key, not item.enabled))

    def remove(self) -> None:
        """Remove the active lattice; undo brings it back."""
        self._studio.do(c.Remove(_active(self._studio).key))


def _reset_all(studio: Studio) -> None:
    item = _active(studio)
    if item.deformed:
        studio.do(c.ResetPoints(item.key))


def _active(studio: Studio) -> LatticeItem:
    item = studio.document.model.active_lattice
    assert item is not None  # the action table enables nothing here without one
    return item
