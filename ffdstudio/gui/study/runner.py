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
from dataclasses import replace
from pathlib import Path
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
from ffdstudio.optimize.build.place import Place, is_given
from ffdstudio.optimize.consent import Consent, Order
from ffdstudio.project.commands import AddStudy, RemoveStudy
from ffdstudio.project.studies.folders import StudyFolders
from ffdstudio.project.studies.following import walls_to_follow
from ffdstudio.project.studies.scrubbing import Scrub, scrub
from ffdstudio.project.studies.starting import checked, new_lattice, on_lattice

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record
    from ffdstudio.optimize.spec.study import StudySpec
    from ffdstudio.project.model import Model, StudyItem

POLL_MS = 50
REST, LATE_S = 2.0, 0.02  # times the delay; what counts as one, in seconds
HAND_OVER_S = 1e-3
TELL_S = 0.2  # between reports to the status line


class StudyRunner(QObject):
    """The studies of one window; one runs at a time.

    Signals: `draft_changed` (the form's description), `changed` (a run began, paused, ended),
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
        self.draft: StudySpec | None = None
        self.folders = StudyFolders()
        self.consent = Consent(ask=self._asked)
        self.runs: list[Run] = []
        self.run: Run | None = None
        self.place = -1
        self.following = True
        self.problem = ""
        self._coloured = 0
        self._news = False
        self._polled = self._rest_until = 0.0
        self._scrub: Scrub | None = None
        self._queue: deque[tuple[Run, Record | str]] = deque()
        self._job: Job | None = None
        self._timer = QTimer(self)
        self._timer.setInterval(POLL_MS)
        self._timer.timeout.connect(self.poll)
        studio.jobs.changed.connect(self._on_jobs)
        self._listening = Listening(
            (studio.document.moved, self._on_moved),
            (studio.document.structure_changed, self._sync),
        )
        self._sync()

    # ---- what the user asks for ---------------------------------------------------------------

    def put_draft(self, draft: StudySpec | None) -> None:
        """Take note of the study that the form describes now."""
        if draft != self.draft:
            self.draft = draft
            self.draft_changed.emit()

    def start(self, study: StudySpec, paused: bool = False) -> bool:
        """Begin a study; whether it could begin. With `paused`, one iterate at a time.

        A study of the document that is ready and does the same is begun; else a new one is made.
        """
        if self.alive:
            return False
        self.release()
        document = self._studio.document
        try:
            study = checked(study, document.model)
            self._ask_leave(study)
            if not is_given(study.lattice.file):
                made = new_lattice(study, document.model)
                document.do(made)
                for command in walls_to_follow(made, document.model):
                    document.do(command)
                study = on_lattice(study, document.model.lattices[-1].key)
            ready = next((r for r in self.runs if r.state == "ready" and r.spec == study), None)
            if ready is None:
                document.do(AddStudy(document.model.free_name("Study 1"), study))
                ready = self._run_of(document.model.studies[-1])
        except InputError as error:
            self._fail(None, error)
            return False
        self._begin(ready, paused)
        return True

    def _ask_leave(self, study: StudySpec) -> None:
        """Ask whether a program may run that came inside the project; see `consent`."""
        place = Place(source=self._studio.document.records.source_of(study.objective))
        study.objective.require(replace(place, consent=self.consent))

    def _asked(self, order: Order) -> bool:
        question = Question(
            "A program from the project",
            f"{order.sentence}. Let it run?",
            "It came inside the project file. Let it run only if you trust who made that file.",
            (("refuse", "&Do not run"), ("run", "&Run it"), ("cancel", "Cancel")),
        )
        return self._studio.asker.choose(question) == "run"

    def _begin(self, run: Run, paused: bool) -> None:
        document = self._studio.document
        run.begin(document.records.begin(run.item.key))
        self.run, self.place, self.following, self.problem = run, -1, True, ""
        model, folder = document.settled_model, self.folders.of(run.item.key)
        self._job = self._studio.jobs.start(
            run.name,
            lambda progress: self._work(run, model, folder, paused, progress),
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

    # ---- the document's studies ---------------------------------------------------------------

    def _sync(self) -> None:
        """Keep a run for each study of the document, in its order."""
        document = self._studio.document
        wanted = document.settled_model.studies
        if [run.item for run in self.runs] == list(wanted):
            return
        self.runs = [self._run_of(item) for item in wanted]
        if self.run is not None and self.run not in self.runs and not self.run.alive:
            self.run, self.place = (self.runs[-1] if self.runs else None), -1
        self._coloured = max(self._coloured, len(self.runs))
        self.changed.emit()
        self.grown.emit()
        self.shown_changed.emit()

    def _run_of(self, item: StudyItem) -> Run:
        """The run of a study; made for one that is new, or was read."""
        history = self._studio.document.records.history(item.key)
        for run in self.runs:
            if run.item.key == item.key and run.history is history:
                run.item = item
                return run
        number = self._coloured
        self._coloured += 1
        return Run(item, number, history)

    def select(self, run: Run) -> None:
        """Look at another study: plots, timeline and figures are about it."""
        if self.alive or run is self.run:
            return
        self.release()
        self.run, self.place = run, len(run.iterates) - 1
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

    def _work(self, run: Run, model: Model, folder: Path, paused: bool, progress: Progress) -> None:
        from ffdstudio.project.studies.starting import prepare

        progress(0.0, "Preparing")
        source = self._studio.document.records.source_of(run.spec.objective)
        study = prepare(run.spec, model, folder, source, self.consent).study
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
                progress(_fraction(run.spec, record), f"{record.variables} variables")

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
        self._studio.document.records.ended()
        self._studio.document.history_changed.emit()
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
        """Remove a study that has ended from the document; an undo brings it back."""
        if run.alive:
            return
        if self.run is run:
            self.release()
        self._studio.do(RemoveStudy(run.item.key))

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
        self.folders.close()


def _fraction(study: StudySpec, record: Record) -> float:
    """How far a study is, by whichever budget is most spent."""
    parts, budget = [0.0], study.budget
    if study.refinement is not None:
        parts.append(record.variables / study.refinement.variables)
    if budget.evaluations:
        parts.append(record.evaluation / budget.evaluations)
    if budget.iterations:
        parts.append(record.iteration / budget.iterations)
    return min(1.0, max(parts))
