"""The quality panel: measures, histogram, limits of the solvers, worst cells, the guard."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QGroupBox,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.panels.fields import note, say
from ffdstudio.gui.quality.choice import COLOURS, Choice
from ffdstudio.gui.quality.guardbox import GuardBox
from ffdstudio.gui.quality.lazy_histogram import LateHistogram
from ffdstudio.gui.quality.lists import LimitList, WorstList, spaced
from ffdstudio.gui.quality.notes import FoldNote, PlaneNote, put
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.measures import LIMITS, MEASURES
from ffdstudio.project.checks.checking import Checks, Digest, presets
from ffdstudio.project.checks.folding import Foldings
from ffdstudio.project.checks.guarding import DragGuard

if TYPE_CHECKING:
    from ffdstudio.meshes import Mesh
    from ffdstudio.meshes.measures.report import Report


class QualityPanel(QStackedWidget):
    """Two pages: why there is nothing to show, and what there is."""

    def __init__(
        self, studio: Studio, checks: Checks, choice: Choice, warden: DragGuard, foldings: Foldings
    ) -> None:
        super().__init__()
        self._studio, self._checks, self._choice = studio, checks, choice
        self._mesh: Mesh | None = None  # the one that a picked cell is of
        self.empty = note()
        self.empty.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.empty.setMargin(9)
        self.body, self.measure = QComboBox(), QComboBox()
        self.colour, self.preset = QComboBox(), QComboBox()
        self.standard, self.figures, self.inverted, self.tests = note(), note(), note(), note()
        self.topology = note()
        self.histogram, self.limits, self.worst = LateHistogram(), LimitList(), WorstList()
        self.planes, self.folds = PlaneNote(studio), FoldNote(studio, foldings)
        self.guard = GuardBox(studio, warden)
        self._fill_choices()
        page = QScrollArea()
        page.setWidget(self._page())
        page.setWidgetResizable(True)
        page.setFrameShape(QScrollArea.Shape.NoFrame)
        page.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # it follows the field that has it
        page.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.addWidget(self.empty)
        self.addWidget(page)
        self._connect()
        self.fill()

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()
        self.guard.close_box()
        self.folds.close_note()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        self.histogram.paint_with(theme)
        self.fill()

    # ---- making the page --------------------------------------------------------------------

    def _fill_choices(self) -> None:
        for name, measure in MEASURES.items():
            title = measure.title[:1].upper() + measure.title[1:]
            self.measure.addItem(title, name)
            tip = f"{title}, as defined by: {measure.standard}"
            self.measure.setItemData(self.measure.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)
        for key, text in COLOURS.items():
            self.colour.addItem(text, key)
        for name in presets():
            self.preset.addItem(name, name)
        for box, name, tip in (
            (self.body, "Body", "Whose cells are judged"),
            (self.measure, "Measure", "What the cells are judged by; each names its standard"),
            (self.colour, "Colours", "Colour the mesh by the measure, or by how it has changed"),
            (self.preset, "Limits", "Whose limits the cells are counted against"),
        ):
            box.setAccessibleName(name)
            box.setToolTip(tip)
            box.setMinimumContentsLength(8)
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def _page(self) -> QWidget:
        page = QWidget()
        layout = QVBoxLayout(page)
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Body", self.body)
        form.addRow("&Measure", self.measure)
        form.addRow("", self.standard)
        form.addRow("&Colours", self.colour)
        self._form = form
        layout.addLayout(form)
        for widget in (
            self.inverted,
            self.topology,
            self.planes,
            self.folds,
            self.histogram,
            self.figures,
        ):
            layout.addWidget(widget)
        limits = QFormLayout()
        limits.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        limits.addRow("L&imits of", self.preset)
        layout.addLayout(limits)
        layout.addWidget(self.limits)
        layout.addWidget(self.tests)
        layout.addWidget(_titled("Worst cells", self.worst))
        layout.addWidget(self.guard)
        layout.addStretch(1)
        return page

    def _connect(self) -> None:
        want = self._choice.want
        self.body.activated.connect(lambda: want(body=self.body.currentData()))
        self.measure.activated.connect(lambda: want(measure=self.measure.currentData()))
        self.colour.activated.connect(lambda: want(colour=self.colour.currentData()))
        self.preset.activated.connect(lambda: want(preset=self.preset.currentData()))
        self.worst.picked.connect(lambda cell: want(cell=cell))
        document = self._studio.document
        self._listening = Listening(
            (document.structure_changed, self._on_structure),
            (document.volume_changed, self._on_key),
            (self._checks.changed, self._on_key),
            (self._checks.digested, self._on_key),
            (self._choice.changed, self.fill),
        )
        self._on_structure()

    # ---- showing ----------------------------------------------------------------------------

    def _on_structure(self) -> None:
        bodies = self._studio.document.model.bodies
        self.body.clear()
        for body in bodies:
            self.body.addItem(body.name, body.key)
        self._form.setRowVisible(self.body, len(bodies) > 1)
        if self._choice.wanted.body not in {body.key for body in bodies}:
            self._choice.want(body=bodies[0].key if bodies else "")
        mesh = next((b.mesh for b in bodies if b.key == self._choice.wanted.body), None)
        if mesh is not self._mesh:  # keys begin anew with each project
            self._mesh = mesh
            self._choice.want(cell=-1)
        self.fill()

    def _on_key(self, _key: str) -> None:
        self.fill()

    def fill(self) -> None:
        """Show what is known of the chosen body."""
        wanted = self._choice.wanted
        report = self._checks.report(wanted.body)
        self.setCurrentIndex(0 if report is None else 1)
        if report is None:
            say(self.empty, self._why_nothing())
            return
        for box, value in (
            (self.body, wanted.body),
            (self.measure, wanted.measure),
            (self.colour, wanted.colour),
            (self.preset, wanted.preset),
        ):
            box.setCurrentIndex(box.findData(value))
        self.standard.setText(MEASURES[wanted.measure].standard)
        self._enable_measures(report)
        self._fill_counts(report)
        digest = self._checks.digest(wanted.body, wanted.measure)
        if digest is not None:
            self._fill_measure(report, digest)
        elif wanted.measure not in report.measures:
            self.histogram.clear_all()
            self.worst.clear()
            say(self.figures, "This mesh has no such measure.")

    def _why_nothing(self) -> str:
        key = self._choice.wanted.body
        if not key:
            return "Open a mesh to see the quality of its cells."
        trouble = self._checks.trouble.get(key)
        return f"No quality: {trouble}." if trouble else "Measuring the cells …"

    def _enable_measures(self, report: Report) -> None:
        model = self.measure.model()
        for row in range(self.measure.count()):
            has = self.measure.itemData(row) in report.measures
            model.item(row).setEnabled(has)  # type: ignore[attr-defined]

    def _fill_counts(self, report: Report) -> None:
        count = int(report.inverted.sum())
        unseen = report.coverage
        role = "problem" if count else "warning" if unseen.missing else "good"
        cells = spaced(report.cells)
        text = f"{spaced(count)} of {cells} cells are inverted"
        text = text if count else f"None of {cells} cells is inverted"
        text += f"; {unseen}" if unseen.missing else ""
        stale = "" if self._checks.current(self._choice.wanted.body) else " (measuring …)"
        put(self.inverted, text + stale, role)
        self._fill_topology()
        self.planes.fill(self._choice.wanted.body)
        self.limits.fill(report, self._choice.wanted.preset, self._studio.theme)
        failed = [f"{name}: {spaced(n)}" for name, n in report.solver_tests.items() if n]
        text = "; ".join(failed) or "The solvers' own tests find nothing wrong."
        put(self.tests, text, "warning" if failed else "muted")
        tip = "\n".join(f"{name}: {n}" for name, n in report.solver_tests.items())
        self.tests.setToolTip(tip)

    def _fill_topology(self) -> None:
        """What checkMesh would say of how the cells hang together."""
        found = self._checks.topology(self._choice.wanted.body)
        if found is not None:
            put(self.topology, f"Topology: {found}", "warning" if found.faults else "muted")
            self.topology.setToolTip(
                "As OpenFOAM's checkMesh has it: unused points, duplicate faces and cells, open "
                "cells, edges where more than two outer faces meet, regions, order of faces"
            )

    def _fill_measure(self, report: Report, digest: Digest) -> None:
        theme, numbers = self._studio.theme, digest.statistics
        self.histogram.fill(digest, theme)
        limits = [limit for limit in LIMITS if limit.preset == self._choice.wanted.preset]
        lines = [limit.value for limit in limits if limit.measure == digest.measure]
        self.histogram.mark([] if digest.scale.log else lines, theme["warning"])
        text = f"min {numbers.min:.4g}, mean {numbers.mean:.4g}, max {numbers.max:.4g}"
        if digest.before.any():
            text += ". Bars: now; line: undeformed."
        say(self.figures, text)
        self.worst.fill(digest, self._choice.wanted.cell)


def _titled(title: str, widget: QWidget) -> QGroupBox:
    box = QGroupBox(title)
    layout = QVBoxLayout(box)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(widget)
    return box
