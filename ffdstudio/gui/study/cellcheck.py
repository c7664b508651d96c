"""Looks for inverted cells in the iterate that is shown, as soon as it stands still."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer

from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.project.checks.iterate_cells import checkable, count_inverted
from ffdstudio.project.studies.scrubbing import Scrub

STILL_MS = 250


class CellCheck(QObject):
    """Sets `Scrub.inverted` and has the runner emit `checked`; not while a study computes."""

    def __init__(self, studio: Studio, runner: StudyRunner) -> None:
        super().__init__()
        self._studio, self._runner = studio, runner
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(STILL_MS)
        self._timer.timeout.connect(self._check)
        runner.shown_changed.connect(self._wait)
        runner.changed.connect(self._wait)

    def close(self) -> None:
        """Check nothing more."""
        self._timer.stop()
        self._runner.shown_changed.disconnect(self._wait)
        self._runner.changed.disconnect(self._wait)

    @property
    def _edit(self) -> Scrub | None:
        """The iterate to check, if there is one."""
        run, edit = self._runner.run, self._studio.document.editing
        busy = self._runner.alive and (run is None or run.state != "paused")
        if busy or not isinstance(edit, Scrub) or edit.inverted is not None:
            return None
        return edit

    def _wait(self) -> None:
        if self._edit is None:
            self._timer.stop()
        else:
            self._timer.start()

    def _check(self) -> None:
        edit, document = self._edit, self._studio.document
        if edit is None or edit.shown is None:
            return
        bodies = [(body, document.nodes(body.key)) for body in checkable(document)]
        shown, rest = edit.shown, edit.rest_of(edit.shown)

        def done(count: int | None) -> None:
            if document.editing is edit and edit.shown is shown and count is not None:
                edit.inverted = count
                self._runner.checked.emit()

        if bodies:
            self._studio.jobs.start(
                "Checking the cells of the iterate",
                lambda progress: count_inverted(
                    bodies, edit.before, edit.item, shown, rest, progress
                ),
                done,
                key="iterate cells",
            )
