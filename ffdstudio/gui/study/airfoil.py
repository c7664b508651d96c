"""The airfoil view: outlines, errors along the chord, curvature, and the pressure, live.

A worker computes; the view asks for the next picture when the last one has arrived, so a
drag costs the window only the drawing, and the newest shape is always the one that comes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QSplitter,
    QStackedLayout,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import note, say
from ffdstudio.gui.start import Elided
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.plots import make_plot, narrow, paint_plot, put_key
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.optimize.geometry.profiles import Profile, profiles
from ffdstudio.project.model import Body

if TYPE_CHECKING:
    from ffdstudio.project.view.section_view import SectionView

FRAME_MS = 33
EMPTY = (
    "No airfoil here. Open a plane mesh with an airfoil as one of its markers, "
    "such as the sample naca0012.su2, or an airfoil file."
)


class AirfoilPanel(QWidget):
    """Three plots over the chord: the section, its distance to the target, its pressure."""

    def __init__(self, studio: Studio, runner: StudyRunner) -> None:
        super().__init__()
        self._studio, self._runner = studio, runner
        self._theme = studio.theme
        self._found: list[tuple[Body, Profile]] = []
        self._busy = self._stale = False
        self._target = ""
        self.view: SectionView | None = None
        self.pictures = 0
        self.section = narrow(QComboBox())
        self.section.setAccessibleName("Section")
        self.angle = QDoubleSpinBox()
        self.angle.setRange(-30.0, 30.0)
        self.angle.setSingleStep(0.5)
        self.angle.setSuffix("°")
        self.angle.setValue(2.0)
        self.angle.setToolTip("Angle of attack of the panel method")
        self.comb = _switch("Co&mb", "Curvature comb: teeth as long as the root of the curvature")
        self.show_error = _switch("E&rror", "Distance to the target, with Kulfan's tolerance", True)
        self.show_pressure = _switch("&Cp", "Pressure by the panel method: inviscid", True)
        self.lift = Elided("", "", Qt.TextElideMode.ElideRight)
        self.lift.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.problem = note(role="problem")
        self.shape = make_plot("Section", "x / c", "y / c")
        self.error = make_plot("Error along the chord", "x / c", "Error / c")
        self.pressure = make_plot("Pressure", "x / c", "Cp (inviscid)")
        self._curves = _Curves(self.shape, self.error, self.pressure)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(FRAME_MS)
        self._timer.timeout.connect(self._ask)
        self._lay_out()
        self._connect()
        self._on_structure()

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.setContentsMargins(6, 4, 6, 0)
        row.addWidget(self.section)
        row.addWidget(self.comb)
        row.addWidget(self.show_error)
        row.addWidget(self.show_pressure)
        row.addWidget(QLabel("at"))
        row.addWidget(self.angle)
        row.addWidget(self.lift, 1)
        self.splitter = QSplitter(Qt.Orientation.Horizontal)
        for plot in (self.shape, self.error, self.pressure):
            self.splitter.addWidget(plot)
        self.splitter.setChildrenCollapsible(False)
        page = QWidget()
        inner = QVBoxLayout(page)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.setSpacing(4)
        inner.addLayout(row)
        inner.addWidget(self.problem)
        inner.addWidget(self.splitter, 1)
        blank = QWidget()
        self.empty = note(EMPTY)
        self.empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        QVBoxLayout(blank).addWidget(self.empty)
        self.pages = QStackedLayout(self)
        self.pages.addWidget(blank)
        self.pages.addWidget(page)
        say(self.problem, "")

    def _connect(self) -> None:
        document = self._studio.document
        self.section.currentIndexChanged.connect(self.ask)
        self.angle.valueChanged.connect(self.ask)
        for switch in (self.comb, self.show_error, self.show_pressure):
            switch.toggled.connect(self._reveal)
        self._listening = Listening(
            (document.structure_changed, self._on_structure),
            (document.moving, self.ask),
            (document.moved, self.ask),
            (self._runner.draft_changed, self._on_draft),
            (self._runner.shown_changed, self.ask),
        )

    def close_panel(self) -> None:
        """Stop listening."""
        self._timer.stop()
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self._theme = theme
        self._curves.paint_with(theme)
        for plot in (self.shape, self.error, self.pressure):
            paint_plot(plot, theme)

    # ---- what is looked at --------------------------------------------------------------------

    def _on_structure(self) -> None:
        bodies = self._studio.document.model.bodies
        known = [(body.key, body.mesh) for body, _ in self._found]
        if {k for k, _ in known} != {b.key for b in bodies} or not known:
            self._found = [(body, p) for body in bodies for p in profiles(body.mesh)]
            self.section.blockSignals(True)
            self.section.clear()
            for body, profile in self._found:
                self.section.addItem(f"{body.name} {profile.marker}".strip())
            self.section.blockSignals(False)
        self.pages.setCurrentIndex(1 if self._found else 0)
        self.section.setVisible(len(self._found) > 1)
        self.ask()

    def _on_draft(self) -> None:
        draft = self._runner.draft
        target = draft.objective.aim if draft is not None else ""
        attack = None if draft is None else draft.objective.attack
        if attack is not None:
            self.angle.setValue(attack)
        if target != self._target:
            self._target = target
            self.ask()

    def ask(self) -> None:
        """Ask for a new picture, soon."""
        if self._found and not self._timer.isActive():
            self._timer.start()

    def _ask(self) -> None:
        if self._busy or not self.isVisible():
            self._stale = True
            return
        index = self.section.currentIndex()
        if not 0 <= index < len(self._found):
            return
        body, profile = self._found[index]
        document = self._studio.document
        try:
            surface = document.surface(body.key)
        except KeyError:  # it has just been removed
            return
        document.refresh()
        rows = np.searchsorted(surface.nodes, profile.nodes)
        now = profile.local(document.points(body.key)[rows])
        start = profile.local(body.mesh.points[profile.nodes])
        target, angle = self._target, self.angle.value()
        self._busy, self._stale = True, False
        self._studio.jobs.start(
            "Airfoil view", lambda _: _look(start, now, target, angle), self._take, self._refuse
        )

    def showEvent(self, event: Any) -> None:
        super().showEvent(event)
        self._on_draft()
        self.ask()

    # ---- what has come ------------------------------------------------------------------------

    def _take(self, found: tuple[SectionView, str]) -> None:
        self._busy = False
        self.view, problem = found
        say(self.problem, problem)
        self._reveal()
        self.pictures += 1
        if self._stale:
            self.ask()

    def _refuse(self, error: Exception) -> None:
        self._busy = False
        if not isinstance(error, InputError):
            raise error
        say(self.problem, sentence(str(error)))

    def _reveal(self) -> None:
        view = self.view
        if view is None:
            return
        self.error.setVisible(self.show_error.isChecked() and view.error is not None)
        self.pressure.setVisible(self.show_pressure.isChecked())
        self.angle.setEnabled(self.show_pressure.isChecked())
        self._curves.draw(view, self.comb.isChecked())
        parts = []
        if view.error is not None:
            parts.append(f"RMS {view.rms:.2e}, largest {np.abs(view.error).max():.2e}")
        if view.pressure is not None and self.show_pressure.isChecked():
            aim = f" (target {view.aim.lift:.4f})" if view.aim is not None else ""
            parts.append(f"CL {view.pressure.lift:.4f}{aim}")
        self.lift.put(" · ".join(reversed(parts)))
        self.lift.setToolTip("\n".join(parts))


def _look(start: Any, now: Any, target: str, angle: float) -> tuple[SectionView, str]:
    """Picture, and what is wrong with the target; for a worker."""
    from ffdstudio.project.view.section_view import section_view

    try:
        return section_view(start, now, target, angle), ""
    except InputError as error:
        if not target:
            raise
        return section_view(start, now, "", angle), sentence(str(error))


class _Curves:
    """The items of the three plots."""

    def __init__(self, shape: Any, error: Any, pressure: Any) -> None:
        import pyqtgraph as pg

        shape.setAspectLocked(True)
        shape.getPlotItem().setLabel("left", "")
        pressure.getPlotItem().invertY(True)
        self.teeth, self.tips = shape.plot(connect="pairs"), shape.plot()
        self.source, self.target, self.current = shape.plot(), shape.plot(), shape.plot()
        self.bands = [error.plot() for _ in range(2)]
        self.sides = [error.plot() for _ in range(2)]
        self.zero = pg.InfiniteLine(0.0, angle=0)
        error.addItem(self.zero, ignoreBounds=True)
        self.aim, self.cp = pressure.plot(), pressure.plot()
        self.plots = (shape, error, pressure)

    def paint_with(self, theme: Theme) -> None:
        import pyqtgraph as pg

        dash = Qt.PenStyle.DashLine
        muted, strong = theme["muted"], theme["highlight"]
        for item, colour, width, style in (
            (self.source, muted, 1, Qt.PenStyle.DotLine),
            (self.target, theme["hovered"], 1.5, dash),
            (self.current, strong, 2, None),
            (self.teeth, theme["border"], 1, None),
            (self.tips, theme["axis_j"], 1, None),
            (self.aim, theme["hovered"], 1.5, dash),
            (self.cp, strong, 2, None),
            (self.sides[0], strong, 1.5, None),
            (self.sides[1], theme["axis_i"], 1.5, None),
            *((band, muted, 1, dash) for band in self.bands),
        ):
            item.setPen(pg.mkPen(colour, width=width, style=style or Qt.PenStyle.SolidLine))
        self.zero.setPen(pg.mkPen(theme["border"]))
        target, current = ("┄", "target", theme["hovered"]), ("━", "current", strong)
        shape, error, pressure = self.plots
        put_key(shape, ("┈", "source", muted), target, current)
        put_key(
            error, ("┄", "Kulfan", muted), ("━", "upper", strong), ("━", "lower", theme["axis_i"])
        )
        put_key(pressure, target, current)

    def draw(self, view: SectionView, comb: bool) -> None:
        from ffdstudio.optimize.geometry.sections import kulfan_tolerance

        self.source.setData(view.source)
        self.current.setData(view.current)
        _put(self.target, view.target)
        teeth = np.stack([view.current, view.comb], axis=1).reshape(-1, 2)
        _put(self.teeth, teeth if comb else None)
        _put(self.tips, view.comb if comb else None)
        for item, pressure in ((self.cp, view.pressure), (self.aim, view.aim)):
            if pressure is None:
                item.setData([], [])
            else:
                item.setData(pressure.x, pressure.cp)
        if view.error is None:
            return
        for item, side in zip(self.sides, (view.upper, ~view.upper), strict=True):
            item.setData(view.current[side, 0], view.error[side])
        x = np.array([0.0, 0.2, 0.2, 1.0])
        band = kulfan_tolerance(np.array([0.1, 0.1, 0.6, 0.6]))
        near = np.abs(view.error).max() > 0.02 * band.max()  # else the band would hide the error
        for item, sign in zip(self.bands, (1.0, -1.0), strict=True):
            item.setData(x if near else [], sign * band if near else [])


def _put(item: Any, points: Any) -> None:
    if points is None:
        item.setData([], [])
    else:
        item.setData(points[:, 0], points[:, 1])


def _switch(text: str, tip: str, on: bool = False) -> QCheckBox:
    box = QCheckBox(text)
    box.setToolTip(tip)
    box.setChecked(on)
    return box
