"""The active lattice: what it is, its refinement, and the form for a new one."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QApplication,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSpinBox,
    QStackedWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.panels.builder import Builder
from ffdstudio.gui.panels.fields import note, say
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project import commands as c
from ffdstudio.project.model import LatticeItem

DIRECTIONS = "ijk"


class LatticePanel(QStackedWidget):
    """Three pages: no lattice yet, the active one, and the builder."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.left: Callable[[], object] = lambda: None  # the form was left: to the picture
        self.builder = Builder(studio, self._on_built)
        self.summary = Summary(studio)
        self.empty = note(
            "No lattice yet. Build one around the meshes (Ctrl+L), or load one from a file."
        )
        self.new = QPushButton("&New lattice…")
        self.new.clicked.connect(lambda: self.build())
        for page in (self._empty_page(), self.summary, self.builder):
            self.addWidget(_scrolled(page, self.builder.footer if page is self.builder else None))
        self._listening = Listening(
            (studio.document.structure_changed, self.fill),
            (studio.document.moved, self.summary.fill),
        )
        self.fill()

    def close_panel(self) -> None:
        """Stop listening."""
        self.builder.reach.stop()
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self.summary.paint_with(theme)

    def _empty_page(self) -> QWidget:
        page = QWidget()
        layout = QVBoxLayout(page)
        layout.addWidget(self.empty)
        layout.addWidget(self.new)
        layout.addStretch(1)
        return page

    @property
    def building(self) -> bool:
        """Whether the form is open."""
        return self.currentIndex() == 2

    def build(self, around: str = "", marker: str = "") -> None:
        """Open the form for a new lattice."""
        self.setCurrentIndex(2)
        self.builder.start(around, marker)

    def refit(self, item: LatticeItem) -> None:
        """Open the form for an undeformed lattice."""
        self.setCurrentIndex(2)
        self.builder.refit(item)

    def _on_built(self) -> None:
        focus = QApplication.focusWidget()
        typing = focus is not None and self.isAncestorOf(focus)
        self.setCurrentIndex(0)
        self.fill()
        if typing:  # else Qt would pick a field, and the next key would change its number
            self.left()

    def fill(self) -> None:
        """Show the page that fits."""
        model = self._studio.document.model
        self.new.setEnabled(bool(model.bodies))
        if self.building:
            self.builder.keep_up()
        else:
            self.setCurrentIndex(0 if model.active_lattice is None else 1)
            self.summary.fill()


class Summary(QWidget):
    """Counts, degrees and frozen layers of the active lattice, with what refines it."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.heading = note(role="heading")
        self.rows = [QLabel() for _ in DIRECTIONS]
        self.letters = [QLabel(f"<b>{letter}</b>") for letter in DIRECTIONS]
        self.raisers = [self._button("Degree +1", axis) for axis in range(3)]
        self.frozen = QSpinBox()
        self.frozen.setRange(0, 99)
        self.frozen.setToolTip(
            "Outermost layers that stay at rest, on every face where mesh may lie beyond; "
            "points in them that were moved or weighted go back to it"
        )
        self.frozen.setKeyboardTracking(False)
        self.problem = note(role="problem")
        self.state = note()
        self._lay_out()
        self.frozen.valueChanged.connect(self._freeze)

    def _button(self, text: str, axis: int) -> QToolButton:
        button = QToolButton()
        button.setText(text)
        button.setToolTip(f"Raise the degree in {DIRECTIONS[axis]}; the shape stays")
        button.clicked.connect(lambda: self._elevate(axis))
        return button

    def _lay_out(self) -> None:
        grid = QGridLayout()
        grid.setColumnStretch(1, 1)
        for axis in range(3):
            grid.addWidget(self.letters[axis], axis, 0)
            grid.addWidget(self.rows[axis], axis, 1)
            grid.addWidget(self.raisers[axis], axis, 2)
        form = QFormLayout()
        form.addRow("Fro&zen layers", self.frozen)
        self.insert = QPushButton("&Insert a knot…")
        self.refit = QPushButton("Fit a&new…")
        self.reset = QPushButton("&Reset all")
        buttons = QHBoxLayout()
        for button in (self.insert, self.refit, self.reset):
            buttons.addWidget(button)
        layout = QVBoxLayout(self)
        layout.addWidget(self.heading)
        layout.addLayout(grid)
        layout.addLayout(form)
        layout.addWidget(self.problem)
        layout.addWidget(self.state)
        layout.addLayout(buttons)
        layout.addStretch(1)

    def paint_with(self, theme: Theme) -> None:
        """Colour the letters like the axes in the picture."""
        for letter, label in zip(DIRECTIONS, self.letters, strict=True):
            label.setStyleSheet(f"color: {theme['axis_' + letter]}")

    def fill(self) -> None:
        """Show the active lattice."""
        item = self._studio.document.model.active_lattice
        if item is None:
            return
        rest = item.rest
        say(self.heading, item.name + ("" if item.enabled else " (switched off)"))
        for axis in range(3):
            for widget in (self.letters[axis], self.rows[axis], self.raisers[axis]):
                widget.setVisible(axis < rest.dimension)
            if axis < rest.dimension:
                self.rows[axis].setText(f"{rest.shape[axis]} points, degree {rest.degrees[axis]}")
        self.frozen.blockSignals(True)
        self.frozen.setValue(item.frozen)
        self.frozen.blockSignals(False)
        self.refit.setEnabled(not item.deformed)
        self.reset.setEnabled(item.deformed)
        say(self.problem, "")
        say(self.state, self._state(item))

    def _state(self, item: LatticeItem) -> str:
        moved = (item.current.control_points != item.rest.control_points).any(axis=-1).sum()
        weighted = int((item.current.weights != item.rest.weights).sum())
        text = f"{moved} of {item.rest.weights.size} control points moved"
        changed = f", {weighted} weight{'' if weighted == 1 else 's'} changed"
        text += (changed if weighted else "") + ".\n"
        inside = total = 0
        for body in self._studio.document.model.bodies:
            mask = self._studio.document.inside(body.key)
            if mask is None:
                return text + "Looking for the points inside …"
            inside, total = inside + int(mask.sum()), total + len(mask)
        return text + f"{inside:,} of {total:,} displayed points inside.".replace(",", "\u202f")

    def _elevate(self, axis: int) -> None:
        item = self._studio.document.model.active_lattice
        if item is not None:
            self._studio.do(c.ElevateDegree(item.key, axis))

    def _freeze(self, layers: int) -> None:
        item = self._studio.document.model.active_lattice
        if item is None:
            return
        most = (min(item.rest.shape) - 1) // 2
        if layers > most:
            self.frozen.blockSignals(True)
            self.frozen.setValue(item.frozen)
            self.frozen.blockSignals(False)
            most_of_them = f"{most} layer leaves" if most == 1 else f"{most} layers leave"
            say(self.problem, f"At most {most_of_them} a point free to move.")
        else:
            self._do(c.FreezeLayers(item.key, layers))

    def _do(self, command: c.FreezeLayers) -> None:
        """Freeze, and say what this has undone."""
        lost = command.lost(self._studio.document.settled_model)
        if self._studio.do(command) and lost:
            points = "1 point went" if lost == 1 else f"{lost} points went"
            say(self.problem, f"{points} back to rest; undo brings the shape back.")


def _scrolled(page: QWidget, footer: QWidget | None) -> QWidget:
    """Page in a scroll area, above a footer that always stays in view."""
    area = QScrollArea()
    area.setWidget(page)
    area.setWidgetResizable(True)
    area.setFrameShape(QScrollArea.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # it follows the field that has it
    whole = QWidget()
    layout = QVBoxLayout(whole)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(area)
    if footer is not None:
        layout.addWidget(footer)
    return whole
