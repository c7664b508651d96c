"""Long work beside the window: workers with progress and cancel.

1. A worker returns values and never touches Qt, VTK or the document.
2. Everything comes back through one queued signal to an object that lives in the GUI
   thread. PySide calls a plain function connected to a signal in the *emitting* thread, so
   callbacks are kept here and called from the slot.
3. The threads are Python's: PySide keeps many a `QRunnable` for ever, with all it refers to.
4. Work that is out of date must not arrive: starting a job with the `key` of another
   cancels that one and drops what it would have delivered.
5. Jobs of one `line` deliver in the order in which they were started: files arrive as they
   were asked for. One that has ended keeps its result until those before it have ended.
6. No garbage is collected in a worker: see `gui_gc`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from PySide6.QtCore import QEventLoop, QObject, Qt, Signal, Slot

from ffdstudio.gui.gui_gc import collector

WORKERS = 2


class Cancelled(Exception):
    """Raised inside a worker by `Progress` once the user has cancelled."""


class Progress:
    """What a worker gets: report how far it is, learn that it shall stop.

    Calling it with a fraction in [0, 1] and a text raises `Cancelled` after a cancel, which
    ends the worker at the next report.
    """

    def __init__(self, report: Callable[[float, str], None]) -> None:
        self._report = report
        self._stop = threading.Event()

    def __call__(self, fraction: float, text: str = "") -> None:
        if self._stop.is_set():
            raise Cancelled
        self._report(fraction, text)

    @property
    def cancelled(self) -> bool:
        """Whether the user has asked to stop."""
        return self._stop.is_set()

    def cancel(self) -> None:
        """Ask the worker to stop."""
        self._stop.set()


class Job:
    """One piece of work under way."""

    def __init__(
        self,
        label: str,
        progress: Progress,
        done: Callable[[Any], None],
        failed: Callable[[Exception], None] | None,
        key: str,
        cancelled: Callable[[], None] | None,
        line: str = "",
    ) -> None:
        self.label = label
        self.progress = progress
        self.done = done
        self.failed = failed
        self.key, self.line = key, line
        self.outcome: tuple[str, Any] | None = None
        self.cancelled = cancelled
        self.outdated = False
        self.fraction = 0.0
        self.text = ""

    def cancel(self) -> None:
        """Ask it to stop; its result is dropped in any case."""
        self.progress.cancel()


def _run(job: Job, work: Callable[[Progress], Any], post: Callable[..., None]) -> None:
    """In a worker: do the work and send what came of it."""
    try:
        result = work(job.progress)
    except Cancelled:
        post(job, "cancelled", None)
    except BaseException as error:  # of a library that calls sys.exit, too: a job always ends
        post(job, "failed", error)
    else:
        post(job, "done", result)


class Jobs(QObject):
    """All work under way; emits `changed` whenever something starts, moves on or ends."""

    changed = Signal()
    failed = Signal(object, object)  # job, exception that no callback of the job took
    _posted = Signal(object, str, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        collector().workers.add(self)
        self._pool = ThreadPoolExecutor(WORKERS, "worker")
        self._jobs: list[Job] = []
        self._posted.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    @property
    def running(self) -> list[Job]:
        """Jobs under way, oldest first."""
        return list(self._jobs)

    def start(
        self,
        label: str,
        work: Callable[[Progress], Any],
        done: Callable[[Any], None],
        failed: Callable[[Exception], None] | None = None,
        key: str = "",
        cancelled: Callable[[], None] | None = None,
        line: str = "",
    ) -> Job:
        """Run `work(progress)` in a worker; `done(result)` is called in the GUI thread."""
        for other in self._jobs:
            if key and other.key == key:
                other.outdated = True
                other.cancel()
        progress = Progress(lambda f, t: self._post(job, "progress", (f, t)))
        job = Job(label, progress, done, failed, key, cancelled, line)
        self._jobs.append(job)
        self._pool.submit(_run, job, work, self._post)
        self.changed.emit()
        return job

    def cancel_all(self) -> None:
        """Ask everything to stop."""
        for job in self._jobs:
            job.cancel()

    def finish(self, which: Callable[[Job], bool] = lambda job: True) -> None:
        """Wait until everything under way, or some of it, has ended; the window is still drawn."""
        while any(which(job) for job in self._jobs):
            loop = QEventLoop()
            self.changed.connect(loop.quit)
            loop.exec(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)

    def close(self) -> None:
        """Stop everything and wait for the threads; no callback is called afterwards."""
        self.cancel_all()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._jobs.clear()

    def _post(self, job: Job, kind: str, value: object) -> None:
        self._posted.emit(job, kind, value)

    @Slot(object, str, object)
    def _deliver(self, job: Job, kind: str, value: Any) -> None:
        if job not in self._jobs:
            return
        if kind == "progress":
            job.fraction, job.text = value
            self.changed.emit()
            return
        job.outcome = kind, value
        if not self._waits(job):
            self._end(job, kind, value)

    def _waits(self, job: Job) -> bool:
        """Whether a job of the same line that was started before is still under way."""
        before = self._jobs[: self._jobs.index(job)]
        return bool(job.line) and any(other.line == job.line for other in before)

    def _end(self, job: Job, kind: str, value: Any) -> None:
        self._jobs.remove(job)
        self.changed.emit()  # what is said of it goes before a callback shows a dialog
        following = next((o for o in self._jobs if job.line and o.line == job.line), None)
        if following is not None and following.outcome is not None:
            self._posted.emit(following, *following.outcome)
        try:
            if not job.progress.cancelled:
                self._finish(job, kind, value)
            elif job.cancelled is not None and not job.outdated:
                job.cancelled()
        finally:
            self.changed.emit()  # `finish` waits for it, whatever a callback raises

    def _finish(self, job: Job, kind: str, value: Any) -> None:
        if kind == "done":
            job.done(value)
        elif kind == "failed" and job.failed is not None:
            job.failed(value)
        elif kind == "failed":
            self.failed.emit(job, value)
