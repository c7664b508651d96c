"""The Study panel: the form, what goes on, and start, pause, step, stop."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QHBoxLayout,
    QPushButton,
    QScrollArea,
    QStackedLayout,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import note, say
from ffdstudio.gui.resources import icon
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.form import StudyForm
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.gui.study.runs import STATES, Run
from ffdstudio.gui.study.table import StudiesTable
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.checks.iterate_cells import coverage_of
from ffdstudio.project.commands import DuplicateStudy, RenameStudy
from ffdstudio.project.studies.scrubbing import Scrub

CASES = "Case files (*.toml);;All files (*)"
EMPTY = (
    "Nothing to optimize yet. Open a plane mesh with an airfoil as a marker, "
    "an airfoil file, or a surface."
)
SHOWN = "The picture shows {}. Use it as an edit, or put the lattice back."

INVERTED = "The iterate shown turns cells inside out: {}."


class StudyPanel(QWidget):
    """Describes a study and runs it."""

    def __init__(self, studio: Studio, runner: StudyRunner) -> None:
        super().__init__()
        self._studio, self._runner = studio, runner
        self._case: Path | None = None  # a case file whose mesh is being opened
        self.form = StudyForm(studio)
        self.table = StudiesTable()
        self.heading, self.figures = note(role="heading"), note()
        self.problem, self.shown = note(role="problem"), note()
        self.cells = note(role="problem")
        self.start = self._button("Start", "Begin, with what the form says")
        self.pause = self._button("Pause", "Wait at the next iterate; or go on")
        self.step = self._button("Step", "One iterate, then wait")
        self.stop = self._button("Stop", "End; what was reached is kept")
        self._lay_out()
        self._connect()
        self.fill()

    def _button(self, text: str, tip: str) -> QPushButton:
        button = QPushButton(text)
        button.setToolTip(tip)
        return button

    def _lay_out(self) -> None:
        self.area = QScrollArea()
        self.area.setWidget(self._sheet())
        self.area.setWidgetResizable(True)
        self.area.setFrameShape(QScrollArea.Shape.NoFrame)
        self.area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # it follows the field that has it
        self.area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        buttons = QHBoxLayout()
        buttons.setSpacing(4)
        for button in (self.start, self.pause, self.step, self.stop):
            buttons.addWidget(button)
            button.setMinimumWidth(44)
        buttons.setContentsMargins(8, 0, 8, 8)
        page, blank = QWidget(), QWidget()
        layout = QVBoxLayout(page)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        layout.addWidget(self.area, 1)
        layout.addLayout(buttons)
        inner = QVBoxLayout(blank)
        inner.addWidget(note(EMPTY))
        inner.addStretch(1)
        self.pages = QStackedLayout(self)
        self.pages.addWidget(blank)
        self.pages.addWidget(page)

    def _sheet(self) -> QWidget:
        """What goes on, above the form; both are scrolled, so that notes keep their lines."""
        sheet, notes = QWidget(), QVBoxLayout()
        notes.setContentsMargins(8, 4, 8, 0)
        notes.setSpacing(4)
        notes.addWidget(self.table)
        for label in (self.heading, self.figures, self.cells, self.shown, self.problem):
            notes.addWidget(label)
        self.form.setMinimumWidth(0)
        layout = QVBoxLayout(sheet)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(notes)
        layout.addWidget(self.form, 1)
        return sheet

    def _connect(self) -> None:
        runner = self._runner
        self.form.changed.connect(self._on_form)
        self.table.looked_at.connect(runner.select)
        self.table.renamed.connect(self._rename)
        self.table.duplicated.connect(lambda run: self._studio.do(DuplicateStudy(run.item.key)))
        self.table.removed.connect(runner.forget)
        self.table.shown_in_form.connect(lambda run: self.form.put(run.spec))
        self.start.clicked.connect(self.begin)
        self.pause.clicked.connect(self.toggle_pause)
        self.step.clicked.connect(self.one_step)
        self.stop.clicked.connect(runner.stop)
        self._listening = Listening(
            (self._studio.document.structure_changed, self.fill),
            (runner.changed, self._on_state),
            (runner.grown, self._on_figures),
            (runner.shown_changed, self._on_figures),
            (runner.checked, self._on_figures),
        )

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        names = {
            self.start: "play",
            self.pause: "pause",
            self.step: "step-forward",
            self.stop: "stop",
        }
        for button, name in names.items():
            button.setIcon(icon(name, theme["text"]))

    # ---- showing ------------------------------------------------------------------------------

    def fill(self) -> None:
        """Offer what the document holds."""
        model = self._studio.document.settled_model
        self.pages.setCurrentIndex(1 if model.bodies else 0)
        self.form.fill(model)
        if self._case is not None:
            self.take_case(self._case)
        self._on_form()
        self._on_state()

    def _on_form(self) -> None:
        self._runner.put_draft(self.form.spec)
        self.start.setEnabled(self.form.spec is not None and not self._runner.alive)

    def _on_state(self) -> None:
        runner, run = self._runner, self._runner.run
        alive = runner.alive
        paused = run is not None and alive and run.state == "paused"
        self.form.setEnabled(not alive)
        self.start.setEnabled(not alive and self.form.spec is not None)
        self.pause.setEnabled(alive)
        self.pause.setText("Go on" if paused else "Pause")
        self.step.setEnabled(self.form.spec is not None)
        self.stop.setEnabled(alive)
        failed = run is not None and not alive and run.failed
        note = "" if run is None or run.ending is None or not failed else run.ending.detail
        say(self.problem, runner.problem or sentence(note) if note else runner.problem)
        if alive or self.problem.text():  # what goes on stands at the top
            self.area.verticalScrollBar().setValue(0)
        text = "" if run is None else f"{run.name}: {STATES[run.state]}"
        if run is not None and run.state == "done":
            text += ", failed" if failed else f", {run.note}"
        say(self.heading, text)
        self._on_figures()

    def _rename(self, run: Run, name: str) -> None:
        self._studio.do(RenameStudy(run.item.key, name))
        self._on_state()  # a name that was refused goes

    def _on_figures(self) -> None:
        self.table.fill(self._runner.runs, self._runner.run)
        run = self._runner.run
        last = "" if run is None or not run.iterates else run.sentence(len(run.iterates) - 1)
        say(self.figures, last[:1].upper() + last[1:])
        ended = self._runner.showing and not self._runner.alive and run is not None
        where = run.sentence(self._runner.place).split(",")[0] if ended and run else ""
        say(self.shown, SHOWN.format(where) if ended else "")
        edit = self._studio.document.editing
        count = edit.inverted if isinstance(edit, Scrub) else None
        text = INVERTED.format(f"{count:,}".replace(",", "\u202f")) if count else ""
        unseen = coverage_of(self._studio.document)
        told = sentence(str(unseen)) if count is not None and unseen.missing else ""
        say(self.cells, f"{text} {told}".strip())

    # ---- what the buttons do ------------------------------------------------------------------

    def begin(self) -> None:
        """Start what the form says."""
        spec = self.form.spec
        if spec is not None:
            self._runner.start(spec)

    def save_case(self) -> None:
        """Ask for a name and write what the form says as a case file."""
        studio, spec = self._studio, self.form.spec
        if spec is None:
            say(self.problem, self.form.wrong or "There is no shape to write a case about.")
            return
        path = studio.asker.save_path("Save as case file", CASES, self._folder() / "study.toml")
        if path is None:
            return
        from ffdstudio.project.studies.casefile import write_case

        model = studio.document.settled_model
        studio.jobs.start(
            f"Writing {path.name}",
            lambda _: write_case(spec, model, path),
            lambda _: studio.say(f"Wrote {path.name}"),
            self._refuse,
        )

    def load_case(self) -> None:
        """Ask for a case file and show what it says; its mesh is opened if need be."""
        paths = self._studio.asker.open_paths("Load case", CASES, self._folder())
        if paths:
            self.take_case(paths[0])

    def take_case(self, path: Path) -> None:
        """Show what a case file says, when its mesh is there."""
        from ffdstudio.project.studies.casefile import mesh_to_open, read_case_for

        document, waited = self._studio.document, self._case is not None
        self._case = None
        try:
            spec = read_case_for(path, document.settled_model)
        except InputError as error:
            self._refuse(error)
            return
        mesh = mesh_to_open(spec)
        if mesh is None:
            self.pages.setCurrentIndex(1)
            self.form.put(spec)
            say(self.problem, "")
            return
        self._case = path
        if not waited:
            document.open_mesh(mesh)  # `fill` comes back here

    def _refuse(self, error: Exception) -> None:
        if not isinstance(error, InputError):
            raise error
        say(self.problem, sentence(str(error)))

    def _folder(self) -> Path:
        return Path(self._studio.settings.text("folder", str(Path.home())))

    def toggle_pause(self) -> None:
        """Pause, or go on."""
        run = self._runner.run
        if run is not None and run.state == "paused":
            self._runner.proceed()
        else:
            self._runner.pause()

    def one_step(self) -> None:
        """One iterate; begins a study if none is under way."""
        spec = self.form.spec
        if self._runner.alive:
            self._runner.step()
        elif spec is not None:
            self._runner.start(spec, paused=True)
