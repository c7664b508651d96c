"""Runs studies beside the window and shows their iterates in it.

1. The study runs in a worker; its records wait in a queue that a timer empties, so that a
   thousand iterates a second cost the window no more than twenty.
2. Iterates are shown through `Scrub`, on the GUI thread. Whatever else edits the document
   ends that; following stops then, the study goes on.
3. A job that is cancelled (status line, closing) must end though its study is paused: `stop`
   wakes it. The worker never raises out of the study, so that no record is lost.
4. Drawing takes its time, above all where OpenGL is software: picture and plots are drawn in
   different turns, and after a turn that came late nothing is drawn for some time, so that
   the window answers whatever a frame costs.
5. A thread that computes keeps the interpreter for 5 ms by default, and many calls of Qt wait
   for it anew: while a study runs it has to hand over after 1 ms.
"""

from __future__ import annotations

import sys
import time
from collections import deque
from typing import TYPE_CHECKING, Any

from psygnal import Signal
from PySide6.QtCore import QObject, QTimer

from ffdstudio.errors import InputError
from ffdstudio.gui.dialogs.ask import Question
from ffdstudio.gui.errors import problem_of, sentence
from ffdstudio.gui.jobs import Job, Progress
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.runs import Run
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.project.studies.plan import NEW, Plan, box_around, checked
from ffdstudio.project.studies.scrubbing import Scrub, scrub

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record
    from ffdstudio.project.model import LatticeItem, Model

POLL_MS = 50
REST, LATE_S = 2.0, 0.02  # times the delay; what counts as one, in seconds
HAND_OVER_S = 1e-3
TELL_S = 0.2  # between reports to the status line


class StudyRunner(QObject):
    """The studies of one window; one runs at a time.

    Signals: `draft_changed` (the form's plan), `changed` (a run began, paused, ended),
    `grown` (records arrived), `shown_changed` (another iterate is shown, or none),
    `checked` (its inverted cells have been counted).
    """

    draft_changed = Signal()
    changed = Signal()
    grown = Signal()
    shown_changed = Signal()
    checked = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.draft: Plan | None = None
        self.runs: list[Run] = []
        self.run: Run | None = None
        self.place = -1
        self.following = True
        self.problem = ""
        self._began = 0
        self._news = False
        self._polled = self._rest_until = 0.0
        self._scrub: Scrub | None = None
        self._queue: deque[tuple[Run, Record | str]] = deque()
        self._job: Job | None = None
        self._timer = QTimer(self)
        self._timer.setInterval(POLL_MS)
        self._timer.timeout.connect(self.poll)
        studio.jobs.changed.connect(self._on_jobs)
        self._listening = Listening((studio.document.moved, self._on_moved))

    # ---- what the user asks for ---------------------------------------------------------------

    def put_draft(self, plan: Plan | None) -> None:
        """Take note of the plan that the form describes now."""
        if plan != self.draft:
            self.draft = plan
            self.draft_changed.emit()

    def start(self, plan: Plan, paused: bool = False) -> bool:
        """Begin a study; whether it could begin. With `paused`, one iterate at a time."""
        if self.alive:
            return False
        self.release()
        document = self._studio.document
        try:
            plan = checked(plan, document.model)
            if plan.lattice == NEW:
                document.do(box_around(plan, document.model))
                item = document.model.lattices[-1]
            else:
                item = document.model.lattice(plan.lattice)
        except InputError as error:
            self._fail(None, error)
            return False
        self._begin(plan, item, paused)
        return True

    def _begin(self, plan: Plan, item: LatticeItem, paused: bool) -> None:
        from ffdstudio.optimize.runs.record import RunHistory

        self._began += 1
        run = Run(f"Study {self._began}", self._began - 1, plan, item.key, RunHistory())
        self.runs.append(run)
        self.run, self.place, self.following, self.problem = run, -1, True, ""
        model = self._studio.document.settled_model
        self._job = self._studio.jobs.start(
            run.name,
            lambda progress: self._work(run, model, item, paused, progress),
            lambda _: None,
            lambda error: self._fail(run, error),
            "study",
        )
        self._hand_over = sys.getswitchinterval()
        sys.setswitchinterval(HAND_OVER_S)
        self._polled, self._rest_until = time.monotonic(), 0.0
        self._timer.start()
        self.changed.emit()
        self.shown_changed.emit()

    @property
    def alive(self) -> bool:
        """Whether a study is under way."""
        return self._job is not None

    def pause(self) -> None:
        """Wait at the next iterate."""
        if self._study is not None and self.run is not None:
            self._study.pause()
            self._put_state("paused")

    def proceed(self) -> None:
        """Go on."""
        if self._study is not None:
            self._put_state("running")
            self._study.proceed()

    def step(self) -> None:
        """Go on for one iterate."""
        if self._study is not None:
            self._put_state("paused")
            self.following = True
            self._study.step()

    def stop(self) -> None:
        """End at the next evaluation."""
        if self.run is not None and self.alive:
            self.run.stopping = True
        if self._study is not None:
            self._study.stop()
        elif self._job is not None:
            self._job.cancel()  # still preparing

    @property
    def _study(self) -> Any:
        return self.run.study if self.run is not None and self.alive else None

    def _put_state(self, state: str) -> None:
        if self.run is not None and self.run.state != state and self.run.state != "preparing":
            self.run.state = state
            self.changed.emit()

    # ---- in the worker ------------------------------------------------------------------------

    def _work(
        self, run: Run, model: Model, item: LatticeItem, paused: bool, progress: Progress
    ) -> None:
        from ffdstudio.project.studies.task import prepare

        progress(0.0, "Preparing")
        study = prepare(run.plan, model, item).study
        if paused:
            study.pause()
        run.study = study  # from here on a stop reaches it; before, a cancel ends this job
        progress(0.0, "Running")
        self._queue.append((run, "paused" if paused else "running"))

        told = 0.0

        def listen(record: Record) -> None:
            nonlocal told
            self._queue.append((run, record))
            if progress.cancelled or run.stopping:
                study.stop()
            elif time.monotonic() - told > TELL_S:
                told = time.monotonic()
                progress(_fraction(run.plan, record), f"{record.variables} variables")

        study.run(listen)

    # ---- in the window ------------------------------------------------------------------------

    def poll(self) -> None:
        """Take what has arrived, and show the newest iterate."""
        if self._job is not None and self._job.progress.cancelled:
            self.stop()  # from the status line: it may be paused
        while self._queue:
            run, news = self._queue.popleft()
            if isinstance(news, str):
                run.state = news
                self.changed.emit()
            else:
                run.add(news)
                self._news = self._news or news.kind in ("iterate", "end")
        self._still_ours()
        self._draw()

    def _draw(self) -> None:
        """Show what is new: the picture in one turn, the plots in the next; see reason 4."""
        now, late = time.monotonic(), time.monotonic() - self._polled - 1e-3 * POLL_MS
        self._polled = now
        if self.alive:
            self._rest_until = max(self._rest_until, now + REST * late if late > LATE_S else 0.0)
            if now < self._rest_until:
                return
        last = -1 if self.run is None else len(self.run.iterates) - 1
        if self.following and self.run is not None and self.place != last >= 0:
            self.show(self.run, last, follow=True)
            if self.alive:
                return
        if self._news:
            self._news = False
            self.grown.emit()

    def _on_jobs(self) -> None:
        """Notice that the study's job has ended, in whatever way, or was cancelled."""
        if self._job is None or self._job in self._studio.jobs.running:
            return
        self._job = None
        sys.setswitchinterval(self._hand_over)
        self.poll()
        self._timer.stop()
        if self.run is not None and self.run.state != "failed":
            self.run.state = "done"
            self.run.note = self.run.note or "cancelled"
        self.changed.emit()

    def _fail(self, run: Run | None, error: Exception) -> None:
        known = isinstance(error, InputError)
        self.problem = sentence(str(error)) if known else problem_of(error).cause
        if run is not None:
            run.state, run.note = "failed", self.problem
        if not known:
            self._studio.asker.tell(problem_of(error))
        self.changed.emit()

    # ---- showing iterates ---------------------------------------------------------------------

    def show(self, run: Run, place: int, follow: bool = False) -> None:
        """Show an iterate of a run: net, mesh and all views."""
        if not 0 <= place < len(run.iterates):
            return
        from ffdstudio.optimize.runs.record import unpack

        self.run, self.place, self.following = run, place, follow
        stored = run.iterates[place].lattice
        assert stored is not None
        document = self._studio.document
        try:
            self._scrub = scrub(document, run.key)
            note = f"iterate {run.iterates[place].iteration} of {run.name}"
            self._scrub.show(unpack(stored), note)
        except InputError as error:  # the lattice has gone, or has other degrees now
            self.following, self._scrub = False, None
            self.problem = sentence(str(error))
            self.changed.emit()
        self.shown_changed.emit()

    def follow(self, on: bool) -> None:
        """Show each new iterate, or stay where it is."""
        self.following = on
        if on and self.run is not None and self.run.iterates:
            self.show(self.run, len(self.run.iterates) - 1, follow=True)
        self.shown_changed.emit()

    def use(self) -> None:
        """Make what is shown an entry of the history."""
        if self.showing and self._scrub is not None:
            self.following = False
            self._scrub.commit()
            self._scrub = None
            self.shown_changed.emit()

    def release(self) -> None:
        """Stop showing iterates; the document is what it was."""
        self.following = False
        if self.showing and self._scrub is not None:
            self._scrub.abort()
        self._scrub = None
        self.shown_changed.emit()

    def forget(self, run: Run) -> None:
        """Drop a run that has ended from the plots."""
        if run.alive:
            return
        self.runs.remove(run)
        if self.run is run:
            self.release()
            self.run, self.place = None, -1
        self.changed.emit()
        self.shown_changed.emit()

    @property
    def showing(self) -> bool:
        """Whether an iterate stands in place of the lattice."""
        return self._scrub is not None and self._studio.document.editing is self._scrub

    def _still_ours(self) -> None:
        if self._scrub is not None and not self.showing:
            self.following, self._scrub = False, None
            self.shown_changed.emit()

    def _on_moved(self) -> None:
        self._still_ours()

    # ---- the end ------------------------------------------------------------------------------

    def may_close(self) -> bool:
        """Ask whether a study under way may be stopped; stop it if so, and wait until it has."""
        if not self.alive:
            return True
        assert self.run is not None
        question = Question(
            "A study is running",
            f"Stop {self.run.name}?",
            "Its best shape so far is shown; use it as an edit to keep it.",
            (("stop", "&Stop"), ("cancel", "&Keep running")),
        )
        if self._studio.asker.choose(question) != "stop":
            return False
        self.stop()
        self._studio.jobs.finish()
        return True

    def close(self) -> None:
        """Stop whatever runs; nothing is shown any more."""
        self._timer.stop()
        self._listening.stop()
        if self._job is not None:
            sys.setswitchinterval(self._hand_over)
            self._job.cancel()
        if self._study is not None:
            self._study.stop()
        self._studio.jobs.changed.disconnect(self._on_jobs)


def _fraction(plan: Plan, record: Record) -> float:
    """How far a study is, by whichever budget is most spent."""
    parts = [0.0]
    if plan.indicator:
        parts.append(record.variables / max(1, plan.variables))
    if plan.evaluations:
        parts.append(record.evaluation / plan.evaluations)
    if plan.iterations:
        parts.append(record.iteration / plan.iterations)
    return min(1.0, max(parts))
