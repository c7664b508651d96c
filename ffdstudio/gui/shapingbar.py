"""The strip under the picture that says how a drag works: what follows, about what, guarded how.

What is on stands out; modes that nobody sees surprise. Shown while there is a lattice.
"""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel, QToolBar, QToolButton, QWidget

from ffdstudio.gui.panels.fields import NumberEdit
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.checks.guarding import DragGuard
from ffdstudio.project.interaction.spread import PROFILES
from ffdstudio.project.interaction.tools import Tools

PLANES = ("no symmetry", "about x =", "about y =", "about z =")
PIVOTS = (("about their centre", "centroid"), ("about the point clicked last", "picked"))
GUARDS = (("stop at the limit", "stop"), ("warn at the limit", "warn"), ("not guarded", "free"))


class ShapingBar(QToolBar):
    """Soft selection, symmetry, pivot and guard, each with its values."""

    def __init__(self, studio: Studio, tools: Tools, guard: DragGuard) -> None:
        super().__init__("Shaping")
        self.setObjectName("shaping")
        self._studio, self._tools, self._guard = studio, tools, guard
        self.soft = QToolButton()
        self.soft.setText("Soft")
        self.soft.setCheckable(True)
        self.soft.setToolTip("Points near the selected ones follow (O)")
        self.radius = NumberEdit("Radius of soft selection", "How far soft selection reaches")
        self.profile = _box("Profile of soft selection", [(name, name) for name in PROFILES])
        self.plane = _box("Plane of symmetry", [(text, n - 1) for n, text in enumerate(PLANES)])
        self.at = NumberEdit("Place of the plane of symmetry", "Where the plane of symmetry is")
        self.pivot = _box("About what points turn and scale", PIVOTS)
        self.guard = _box("What happens at the limit", GUARDS)
        for edit in (self.radius, self.at):
            edit.setFixedWidth(64)
        self._lay_out()
        self._connect()
        state = studio.state
        self._listening = Listening(
            (state.mode_changed, self.fill),
            (studio.document.structure_changed, self.fill),
            (tools.changed, self._on_tools),
            (guard.changed, self.fill),
        )
        self.fill()

    def _lay_out(self) -> None:
        parts: list[tuple[str, list[QWidget]]] = [
            ("", [self.soft, self.radius, self.profile]),
            ("", [self.plane, self.at]),
            ("Turn", [self.pivot]),
            ("Guard:", [self.guard]),
        ]
        for number, (title, widgets) in enumerate(parts):
            if number:
                self.addSeparator()
            if title:
                self.addWidget(QLabel(f" {title} "))
            for widget in widgets:
                self.addWidget(widget)

    def _connect(self) -> None:
        state = self._studio.state
        self.soft.toggled.connect(lambda on: state.spread(soft=on))
        self.radius.entered.connect(self._on_radius)
        self.profile.activated.connect(
            lambda: state.spread(soft=True, profile=self.profile.currentData())
        )
        self.plane.activated.connect(lambda: state.spread(mirror=self.plane.currentData()))
        self.at.entered.connect(lambda value: state.spread(mirror_at=value))
        self.pivot.activated.connect(lambda: state.spread(pivot=self.pivot.currentData()))
        self.guard.activated.connect(lambda: self._guard.set(mode=self.guard.currentData()))

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, _theme: Theme) -> None:
        """Nothing here has a colour of its own."""

    def _on_radius(self, value: float) -> None:
        if value > 0:
            self._studio.state.spread(soft=True, radius=value)
        else:
            self._studio.say("Radius of soft selection: it must be positive")

    def _on_tools(self) -> None:
        """The wheel changes the radius during a drag: keep it for the next one."""
        soft = self._tools.options.soft
        if soft is not None and soft.radius != self._studio.state.radius:
            self._studio.state.radius = soft.radius
            self.radius.put(soft.radius)

    def fill(self) -> None:
        """Show what is on."""
        state, options = self._studio.state, self._tools.options
        self.setVisible(self._studio.document.model.active_lattice is not None)
        self.soft.blockSignals(True)
        self.soft.setChecked(state.soft)
        self.soft.blockSignals(False)
        if not self.radius.isModified():
            self.radius.put(options.soft.radius if options.soft is not None else state.radius)
        self.profile.setCurrentIndex(self.profile.findData(state.profile))
        self.plane.setCurrentIndex(state.mirror + 1)
        if not self.at.isModified():
            self.at.put(state.mirror_at)
        self.at.setEnabled(state.mirror >= 0)
        self.pivot.setCurrentIndex(self.pivot.findData(state.pivot))
        self.guard.setCurrentIndex(self.guard.findData(self._guard.mode))


def _box(name: str, items: object) -> QComboBox:
    box = QComboBox()
    box.setAccessibleName(name)
    box.setToolTip(name)
    box.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    for text, data in items:  # type: ignore[attr-defined]
        box.addItem(text, data)
    return box
