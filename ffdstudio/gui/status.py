"""The status line: hints on the left; on the right what is known of the mesh, and jobs."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar, QToolButton

from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.checks.iterate_cells import checkable, coverage_of
from ffdstudio.project.studies.scrubbing import Scrub

HINTS = {
    "move": "Drag control points; X, Y, Z lock an axis, Shift slows, Ctrl snaps, Esc takes back.",
    "rotate": "Drag a selected point to turn the selection; X, Y, Z choose the axis.",
    "scale": "Drag a selected point to scale the selection; X, Y, Z lock an axis.",
    "box": "Draw a rectangle around control points; Shift adds, Ctrl takes away, Esc ends.",
}
QUICK_MS = 400  # what ends sooner than this shows no progress bar


class StatusLine(QStatusBar):
    """Says what goes on; `cancel` stops the work under way."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio, self._jobs = studio, studio.jobs
        self.cells, self.work = QLabel(), QLabel()
        self.bar = QProgressBar()
        self.bar.setRange(0, 1000)
        self.bar.setFixedWidth(120)
        self.bar.setTextVisible(False)
        self.cancel = QToolButton()
        self.cancel.setText("Cancel")
        self.cancel.setToolTip("Stop the work under way")
        self.cancel.clicked.connect(self._jobs.cancel_all)
        for widget in (self.work, self.bar, self.cancel, self.cells):
            self.addPermanentWidget(widget)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(QUICK_MS)
        self._timer.timeout.connect(self._show_jobs)
        self._jobs.changed.connect(self._on_jobs)
        self._listening = Listening(
            (studio.document.volume_changed, self._on_volume),
            (studio.document.structure_changed, self._on_structure),
            (studio.document.told, self.say),
            (studio.said, self.say),
            (studio.state.mode_changed, self._on_mode),
        )
        self._reveal(False)

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, _theme: Theme) -> None:
        """Take the colours of a theme."""
        self._on_structure()

    def say(self, text: str) -> None:
        """Show a text for a while."""
        self.showMessage(text, 15_000)

    def _on_mode(self) -> None:
        self.showMessage(HINTS[self._studio.state.mode], 8_000)

    def _on_volume(self, _key: str) -> None:
        self._on_structure()

    def _on_structure(self) -> None:
        """Nodes and inverted cells of all bodies, as far as they are known."""
        document = self._studio.document
        if isinstance(document.editing, Scrub):
            self._on_iterate(document.editing)
            return
        bodies = document.model.bodies
        volumes = [document.volume(body.key) for body in bodies]
        nodes = sum(len(body.mesh.points) for body in bodies)
        if not bodies:
            self._put("", "")
        elif any(volume is None for volume in volumes):
            busy = any(document.checking(body.key) for body in bodies)
            state = "checking cells …" if busy else "cells not checked"
            self._put(f"{nodes:,} nodes, {state}", "muted")
        else:
            moved = sum(v.moved for v in volumes if v is not None)
            counts = [v.inverted for v in volumes if v is not None and v.inverted is not None]
            text = f"{nodes:,} nodes, {moved:,} moved"
            unseen = coverage_of(document)
            broken = [told for v in volumes if v is not None for told in v.broken]
            self.cells.setToolTip("\n".join(broken))
            if counts and sum(counts):
                also = f", {unseen}" if unseen.missing else ""
                self._put(f"{text}, {sum(counts):,} inverted cells{also}", "problem")
            elif broken:
                self._put(f"{text}, {_short(broken)}", "warning")
            elif unseen.missing:
                self._put(f"{text}, {unseen}", "warning")
            elif counts:
                self._put(f"{text}, no inverted cells", "good")
            else:
                self._put(text, "muted")

    def _on_iterate(self, edit: Scrub) -> None:
        """What is known of the cells of an iterate that stands in place of the lattice."""
        document = self._studio.document
        text = f"{sum(len(b.mesh.points) for b in document.model.bodies):,} nodes, {edit.note}"
        if not checkable(document):
            self._put(text, "muted")
        elif edit.inverted is None:
            self._put(f"{text}, cells not checked yet", "muted")
        elif edit.inverted:
            self._put(f"{text}, {edit.inverted:,} inverted cells", "problem")
        elif (unseen := coverage_of(document)).missing:
            self._put(f"{text}, {unseen}", "warning")
        else:
            self._put(f"{text}, no inverted cells", "good")

    def refresh(self) -> None:
        """Say anew what is known of the cells."""
        self._on_structure()

    def _put(self, text: str, role: str) -> None:
        self.cells.setText(text.replace(",\u0020", "\0").replace(",", "\u202f").replace("\0", ", "))
        self.cells.setProperty("role", role)
        self.cells.style().unpolish(self.cells)
        self.cells.style().polish(self.cells)

    def _on_jobs(self) -> None:
        if not self._jobs.running:
            self._timer.stop()
            self._reveal(False)
            if self.currentMessage().endswith("…"):
                self.clearMessage()
        elif self.bar.isVisible():
            self._show_jobs()
        elif not self._timer.isActive():
            self._timer.start()

    def _show_jobs(self) -> None:
        if not self._jobs.running:
            return
        job = self._jobs.running[0]
        more = len(self._jobs.running) - 1
        self.work.setText(job.label + (f" (and {more} more)" if more else ""))
        self.work.setToolTip(job.text)
        self.bar.setValue(round(1000 * job.fraction))
        self._reveal(True)

    def _reveal(self, on: bool) -> None:
        for widget in (self.work, self.bar, self.cancel):
            widget.setVisible(on)


def _short(broken: list[str]) -> str:
    """What is broken, as far as a line has room for it: "SYMMETRY is no longer planar"."""
    more = f" and {len(broken) - 1} more" if len(broken) > 1 else ""
    return broken[0].partition(":")[0] + more
