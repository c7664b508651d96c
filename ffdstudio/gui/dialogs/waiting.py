"""Wait for work that the next step needs, with a way out."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QProgressDialog, QWidget

from ffdstudio.gui.jobs import Job, Jobs

PATIENCE = 300  # milliseconds until a dialog comes


def wait_for(jobs: Jobs, which: Callable[[Job], bool], text: str, parent: QWidget | None) -> None:
    """Wait until some jobs have ended; the user may cancel them, and only them."""
    if not _quick(jobs, which):
        _with_dialog(jobs, which, text, parent)


def _quick(jobs: Jobs, which: Callable[[Job], bool]) -> bool:
    """Wait without a dialog, which would but flash; whether all have ended."""
    loop, timer = QEventLoop(), QTimer()
    timer.setSingleShot(True)
    timer.timeout.connect(loop.quit)
    jobs.changed.connect(loop.quit)
    timer.start(PATIENCE)
    while timer.isActive() and any(map(which, jobs.running)):
        loop.exec(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)
    jobs.changed.disconnect(loop.quit)
    return not any(map(which, jobs.running))


def _with_dialog(
    jobs: Jobs, which: Callable[[Job], bool], text: str, parent: QWidget | None
) -> None:
    dialog, loop = QProgressDialog(text, "Cancel", 0, 1000, parent), QEventLoop()
    dialog.setWindowModality(Qt.WindowModality.ApplicationModal)
    dialog.setAutoClose(False)
    dialog.setAutoReset(False)

    def follow() -> None:
        left = [job for job in jobs.running if which(job)]
        if left:
            dialog.setValue(round(1000 * left[0].fraction))
        else:
            loop.quit()

    def cancel() -> None:
        for job in filter(which, jobs.running):
            job.cancel()
        loop.quit()  # it ends when it next reports: nobody has to wait for that

    dialog.canceled.connect(cancel)
    jobs.changed.connect(follow)
    dialog.show()
    follow()
    while any(map(which, jobs.running)) and not dialog.wasCanceled():
        loop.exec()
    jobs.changed.disconnect(follow)
    dialog.close()
    dialog.deleteLater()
