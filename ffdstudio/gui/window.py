"""The main window: puts document, viewport, panels, actions and handlers together.

It decides nothing itself. What the user asks for goes from the action table to a handler;
what changes comes from the document's signals to the views.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QByteArray, Qt
from PySide6.QtGui import QAction, QCloseEvent, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QMenu, QStackedWidget, QWidget

from ffdstudio.gui import theme as themes
from ffdstudio.gui.actions import Actions, conditions
from ffdstudio.gui.dialogs.ask import Asker
from ffdstudio.gui.dialogs.palette import Offer
from ffdstudio.gui.errors import ErrorNet, ErrorReport, problem_of, sentence
from ffdstudio.gui.fieldkeys import FieldKeys
from ffdstudio.gui.focusring import FocusRing
from ffdstudio.gui.handlers.editing import EditHandler, LatticeHandler, SelectHandler
from ffdstudio.gui.handlers.files import FileHandler
from ffdstudio.gui.handlers.recovery_handler import Keeper
from ffdstudio.gui.handlers.viewing import HelpHandler, ViewHandler
from ffdstudio.gui.jobs import Job, Jobs
from ffdstudio.gui.looks import Looks
from ffdstudio.gui.panels.history import HistoryPanel
from ffdstudio.gui.panels.lattice import LatticePanel
from ffdstudio.gui.panels.points import PointsPanel
from ffdstudio.gui.panels.problems import ProblemsPanel
from ffdstudio.gui.panels.slices import SlicesPanel
from ffdstudio.gui.panels.tree import TreePanel
from ffdstudio.gui.pointer import PointerFilter
from ffdstudio.gui.quality.panel import QualityPanel
from ffdstudio.gui.quality.quality_ui import QualityPart
from ffdstudio.gui.readouts import Readouts
from ffdstudio.gui.resources import program_icon
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.sectionbar import SectionBar
from ffdstudio.gui.sections import SectionPlanes
from ffdstudio.gui.settings import LAYOUT_VERSION, Settings
from ffdstudio.gui.shapingbar import ShapingBar
from ffdstudio.gui.start import StartPage
from ffdstudio.gui.state import WindowState
from ffdstudio.gui.status import StatusLine
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.plots import WhenSeen
from ffdstudio.gui.study.study_ui import StudyRoom
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.viewport import Viewport, save_picture
from ffdstudio.project.document import Document
from ffdstudio.project.interaction.spread import Mirror, Soft
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.view.looks import LOOKS

Panel = (
    TreePanel
    | HistoryPanel
    | ProblemsPanel
    | LatticePanel
    | PointsPanel
    | StatusLine
    | SectionBar
    | ShapingBar
    | QualityPanel
)
LEFT, RIGHT = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
MIRRORS = ("off", "x", "y", "z")
SOFT_RADIUS = 0.25  # of the lattice's diagonal, to begin with
SWITCHES = ("ghost", "edges", "inside", "net", "outer")


class MainWindow(QMainWindow):
    """One document and all its views."""

    def __init__(
        self,
        settings: Settings | None = None,
        asker: Asker | None = None,
        recovery: Path | None = None,
    ) -> None:
        super().__init__()
        self.setWindowIcon(program_icon())
        self.setAcceptDrops(True)
        self.setDockNestingEnabled(True)
        self.jobs = Jobs(self)
        asker = asker if asker is not None else Asker()
        asker.parent = self
        settings = settings if settings is not None else Settings()
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        self._app = application
        name = settings.text("theme", themes.preferred(application))
        theme = themes.apply(application, name if name in themes.THEMES else "light")
        self.document = Document(self.jobs)
        self.studio = Studio(self.document, WindowState(), self.jobs, settings, asker, theme)
        self.net = ErrorNet(self._tell_unexpected, self)
        self.keeper = Keeper(self.studio, recovery)
        self._build_middle()
        self._build_panels()
        self._build_actions()
        self._listen()
        self._wear(theme)
        self._restore_layout()
        self._on_structure()

    # ---- making the parts -------------------------------------------------------------------

    def _build_middle(self) -> None:
        """Start page and viewport; the viewport before the window is shown."""
        self.middle = QStackedWidget()
        self.start = StartPage(lambda: self.files.open(), lambda p: self.files.open_paths([p]))
        self.viewport = Viewport(self.middle, self.studio.theme)
        self.middle.addWidget(self.start)
        self.middle.addWidget(self.viewport)
        self.setCentralWidget(self.middle)
        self.tools = Tools(self.document)
        self.scene = Scene(self.viewport, self.document, self.studio.state, self.studio.theme)
        self.sections = SectionPlanes(self.studio, self.scene)
        self.looks = Looks(self.studio, self.scene)
        self.quality = QualityPart(self.studio, self.scene, self.sections, self.tools)
        self.readouts = Readouts(self.viewport, self.tools, self.studio.state)
        self.pointer = PointerFilter(self.viewport, self.tools, self.studio.state)

    def _build_panels(self) -> None:
        studio = self.studio
        self.tree, self.history = TreePanel(studio), HistoryPanel(studio)
        self.lattice, self.points = LatticePanel(studio), PointsPanel(studio)
        self.problems = ProblemsPanel(studio)
        self.status = StatusLine(studio)
        self.section_bar = SectionBar(studio)
        self.shaping_bar = ShapingBar(studio, self.tools, self.quality.warden)
        self.setStatusBar(self.status)
        self.docks = {
            title: self._dock(title, panel, area)
            for title, panel, area in (
                ("Scene", self.tree, LEFT),
                ("History", self.history, LEFT),
                ("Problems", self.problems, LEFT),
                ("Lattice", self.lattice, RIGHT),
                ("Quality", self.quality.panel, RIGHT),
                ("Points", self.points, RIGHT),
            )
        }
        self.tabifyDockWidget(self.docks["History"], self.docks["Problems"])
        self.tabifyDockWidget(self.docks["Lattice"], self.docks["Quality"])
        self.docks["Lattice"].raise_()
        self.docks["History"].raise_()
        self.studies = StudyRoom(studio)
        self.docks |= self.studies.add_docks(self, self.docks["Lattice"])
        self.slices = WhenSeen(lambda: SlicesPanel(studio), studio.theme)
        self.docks["Section curves"] = self._dock(
            "Section curves", self.slices, Qt.DockWidgetArea.BottomDockWidgetArea
        )
        self.docks["Section curves"].hide()
        self._first_state: QByteArray | None = None

    def _dock(self, title: str, panel: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(title)
        dock.setWidget(panel)
        self.addDockWidget(area, dock)
        return dock

    @property
    def panels(self) -> list[Panel]:
        """Everything that listens to the document and wears the theme."""
        return [
            self.tree,
            self.history,
            self.problems,
            self.lattice,
            self.points,
            self.status,
            self.section_bar,
            self.shaping_bar,
            self.quality.panel,
        ]

    def _build_actions(self) -> None:
        studio = self.studio
        self.actions_ = Actions(self, self._run)
        self.field_keys = FieldKeys(self._app, self.actions_.shortcuts)
        self.focus_ring = FocusRing(self._app, self, self.viewport)
        self.addToolBar(self.section_bar)
        self.addToolBar(Qt.ToolBarArea.BottomToolBarArea, self.shaping_bar)
        self._file_menus()
        panel_menu = self.actions_.menus["&View"].addMenu("Pa&nels")
        for dock in self.docks.values():
            panel_menu.addAction(dock.toggleViewAction())
        self._panel_actions = [self._panel_action(*pair) for pair in self.docks.items()]
        self.files = FileHandler(studio, self._save_picture, self.close)
        self.view = ViewHandler(studio, self.scene, self._choose_theme, self._reset_layout)
        edit, select = EditHandler(studio, self.tools), SelectHandler(studio)
        lattice = LatticeHandler(studio, self.lattice, self._show_lattice_panel)
        lattice.load_paths = self.files.open
        self.lattice.left = self._to_picture
        self.tree.lattice_around = lattice.around
        self.files.may_stop = self.studies.may_close
        self.files.chosen_body = self.view.chosen_body = self.tree.chosen_body
        help_ = HelpHandler(studio, self.actions_)
        help_.more = self._offers
        handlers = {
            "file": self.files,
            "edit": edit,
            "select": select,
            "lattice": lattice,
            "study": self.studies,
            "quality": self.quality,
            "view": self.view,
            "help": help_,
        }
        self._handlers = handlers
        self._special = self._with_arguments(edit, select, lattice)
        self.quality.attach(self.docks["Quality"], self.actions_)
        self.files.show_inverted = self.quality.show_inverted

    def _file_menus(self) -> None:
        """Recent files and examples, filled when they are opened."""
        menu, before = self.actions_.menus["&File"], self.actions_.by_name["file.new"]
        self._recent, self._samples = QMenu("Open &recent", menu), QMenu("E&xamples", menu)
        for submenu in (self._recent, self._samples):
            menu.insertMenu(before, submenu)
        self._recent.aboutToShow.connect(lambda: self.files.fill_recent(self._recent))
        self._samples.aboutToShow.connect(lambda: self.files.fill_examples(self._samples))

    def _offers(self) -> list[Offer]:
        """What the command palette offers beyond the table: files, examples, panels."""
        self.files.fill_recent(self._recent)
        self.files.fill_examples(self._samples)
        found = [
            Offer(f"File: {menu.title()}", action, action.statusTip())
            for menu in (self._recent, self._samples)
            for action in menu.actions()
            if not action.isSeparator()
        ]
        return found + [Offer("View: Panels", a, a.statusTip()) for a in self._panel_actions]

    def _panel_action(self, name: str, dock: QDockWidget) -> QAction:
        """Action that brings a panel to the front, unlike Qt's own, which may also close it."""
        action = QAction(name, self)
        action.setStatusTip(f"Show the panel {name}")
        action.triggered.connect(partial(self._show_dock, dock))
        return action

    def _show_dock(self, dock: QDockWidget, _on: bool = False) -> None:
        dock.show()
        dock.raise_()

    def _with_arguments(
        self, edit: EditHandler, select: SelectHandler, lattice: LatticeHandler
    ) -> dict[str, Callable[[bool], object]]:
        """Rows that share a method: for an axis, a side, a switch."""
        found: dict[str, Callable[[bool], object]] = {
            "edit.soft": edit.soft,
            "view.parallel": self.view.parallel,
            "view.section": self.view.section,
            "quality.colour": self.quality.colour,
            "view.corner": lambda _: self.view.side("corner"),
            "view.slices": lambda _: self._show_dock(self.docks["Section curves"]),
        }
        for name in SWITCHES:
            found[f"view.{name}"] = partial(self.view.switch, name)
        for look in LOOKS:
            found[f"view.look_{look}"] = _ignoring(partial(self.view.look, look))
        for axis, name in enumerate(MIRRORS, start=-1):
            found[f"edit.mirror_{name}"] = _ignoring(partial(edit.mirror, axis))
        for axis, letter in enumerate("ijk"):
            found[f"select.row_{letter}"] = _ignoring(partial(select.row, axis))
            found[f"select.plane_{letter}"] = _ignoring(partial(select.plane, axis))
            found[f"lattice.elevate_{letter}"] = _ignoring(partial(lattice.elevate, axis))
        for letter in "xyz":
            found[f"view.plus_{letter}"] = _ignoring(partial(self.view.side, f"+{letter}"))
            found[f"view.minus_{letter}"] = _ignoring(partial(self.view.side, f"-{letter}"))
        return found

    def _run(self, name: str, on: bool) -> None:
        """Carry out a row of the action table."""
        if name in self._special:
            self._special[name](on)
        else:
            handler, method = name.split(".")
            getattr(self._handlers[handler], method)()
        if name.startswith("select."):
            self._to_picture()  # the arrow keys nudge what is selected now

    def _to_picture(self) -> None:
        """Give the picture the keyboard."""
        self.viewport.setFocus(Qt.FocusReason.OtherFocusReason)

    # ---- listening --------------------------------------------------------------------------

    def _listen(self) -> None:
        document, state = self.document, self.studio.state
        self._listening = Listening(
            (document.structure_changed, self._on_structure),
            (document.selection_changed, self._on_enabling),
            (self.studies.runner.changed, self._on_enabling),
            (self.studies.runner.shown_changed, self._on_enabling),
            (self.studies.runner.shown_changed, self.status.refresh),
            (self.studies.runner.checked, self.status.refresh),
            (document.moved, self._on_enabling),
            (document.history_changed, self._on_history),
            (document.volume_changed, self._on_volume),
            (document.problem, self._on_problem),
            (document.filed, self.files.remember),
            (state.shown_changed, self._on_marks),
            (state.mode_changed, self._on_mode),
        )
        self.jobs.failed.connect(self._on_failed)
        self.viewport.view_changed.connect(self._on_marks)

    def _on_structure(self) -> None:
        model = self.document.model
        if model.bodies or model.lattices:
            self.middle.setCurrentWidget(self.viewport)
        else:
            self.start.fill(self.studio.settings.recent(), self.studio.theme)
            self.middle.setCurrentWidget(self.start)
        self._on_history()
        self._on_marks()

    def _on_enabling(self) -> None:
        self.actions_.enable(conditions(self.document) | self.studies.conditions())

    def _on_volume(self, _key: str) -> None:
        self._on_enabling()

    def _on_history(self) -> None:
        self._on_enabling()
        history, by_name = self.document.history, self.actions_.by_name
        undo, redo = history.undo_label, history.redo_label
        by_name["edit.undo"].setText("&Undo" + (f" {undo}" if undo else ""))
        by_name["edit.redo"].setText("&Redo" + (f" {redo}" if redo else ""))
        path = self.document.path
        name = path.name if path else "Untitled" if self.document.model.bodies else ""
        self.setWindowTitle(f"{name}[*] - FFD Studio" if name else "FFD Studio[*]")
        self.setWindowModified(self.document.modified)

    def _on_problem(self, title: str, cause: str, doing: str) -> None:
        """Say what did not work, and offer to try it with another file."""
        files, text = self.files, "Nothing was changed."
        ways: dict[str, tuple[str, Callable[[], object]]] = {
            "open": ("&Open another…", files.open),
            "save": ("Save &as…", files.save_as),
            "export": ("Export &elsewhere…", files.export_mesh),
            "export lattice": ("Export &elsewhere…", files.export_lattice),
        }
        if doing == "save":
            text = "The project is still open, but not saved."
        elif doing == "note":
            text = ""
        way = (ways[doing],) if doing in ways else ()
        self.studio.asker.tell(ErrorReport(title, sentence(cause), text, ways=way))

    def _on_failed(self, _job: Job, error: Exception) -> None:
        self._tell_unexpected(problem_of(error))

    def _tell_unexpected(self, problem: ErrorReport) -> None:
        """Say what nobody foresaw, with a way to save the work first of all."""
        save = ("Save &as…", self.files.save_as)
        ways = (save,) if problem.details and self.document.modified else ()
        self.studio.asker.tell(replace(problem, ways=ways))

    def _on_marks(self) -> None:
        shown = self.studio.state.shown
        for name in SWITCHES:
            self.actions_.check(f"view.{name}", getattr(shown, name))
        self.actions_.check(f"view.look_{shown.look}", True)
        self.actions_.check("view.section", shown.section is not None)
        self.actions_.check("view.parallel", self.viewport.view.parallel)
        self._on_mode()

    def _on_mode(self) -> None:
        state, item = self.studio.state, self.document.model.active_lattice
        soft = None
        if state.soft and item is not None:
            radius = SOFT_RADIUS * item.rest.diagonal if state.radius is None else state.radius
            soft = Soft(radius, state.profile)
        mirror = Mirror(state.mirror, state.mirror_at) if state.mirror >= 0 else None
        self.tools.options = Options(state.mode, soft, mirror, state.pivot)
        self.shaping_bar.fill()
        mode = "select.box_mode" if state.mode == "box" else f"edit.{state.mode}_mode"
        for name in (mode, f"edit.mirror_{MIRRORS[state.mirror + 1]}"):
            self.actions_.check(name, True)
        self.actions_.check("edit.soft", state.soft)

    # ---- looks ------------------------------------------------------------------------------

    def _choose_theme(self, name: str) -> None:
        self.studio.settings.put("theme", name)
        self._set_theme(name)

    def _set_theme(self, name: str) -> None:
        self._wear(themes.apply(self._app, name))

    def _wear(self, theme: themes.Theme) -> None:
        """Paint everything that has colours of its own."""
        self.studio.theme = theme
        self.viewport.paint_with(theme)
        self.scene.paint_with(theme)
        self.quality.paint_with(theme)
        self.sections.paint_with(theme)
        self.looks.paint_with(theme)
        self.actions_.paint_with(theme)
        for panel in (*self.panels, self.studies, self.slices):
            panel.paint_with(theme)
        self.start.fill(self.studio.settings.recent(), theme)
        self.actions_.check(f"view.{theme.name}", True)

    def _save_picture(self, path: Path) -> None:
        save_picture(self.viewport.picture(), path)

    def _show_lattice_panel(self) -> None:
        self.docks["Lattice"].show()
        self.docks["Lattice"].raise_()

    def _restore_layout(self) -> None:
        self.resize(1280, 800)
        self.resizeDocks(
            [self.docks["Scene"], self.docks["Lattice"]], [230, 320], Qt.Orientation.Horizontal
        )
        self.resizeDocks(
            [self.docks["Lattice"], self.docks["Points"]], [380, 240], Qt.Orientation.Vertical
        )
        self._first_state = self.saveState(LAYOUT_VERSION)
        layout = self.studio.settings.layout()
        if layout is not None:
            self.restoreGeometry(layout[0])
            self.restoreState(layout[1], LAYOUT_VERSION)
            self.section_bar.fill()
            self.shaping_bar.fill()

    def _reset_layout(self) -> None:
        assert self._first_state is not None
        self.restoreState(self._first_state, LAYOUT_VERSION)
        self.section_bar.fill()
        self.shaping_bar.fill()

    # ---- Qt ---------------------------------------------------------------------------------

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        urls = event.mimeData().urls()
        event.acceptProposedAction()
        self.files.open_paths([Path(url.toLocalFile()) for url in urls if url.isLocalFile()])

    def closeEvent(self, event: QCloseEvent) -> None:
        if not self.files.may_discard():
            event.ignore()
            return
        self.studio.settings.put_layout(self.saveGeometry(), self.saveState(LAYOUT_VERSION))
        self.studio.settings.save()
        self._close_parts()
        event.accept()

    def _close_parts(self) -> None:
        """Let go of the document, stop the workers, close the picture; once."""
        self.studies.close_panel()
        self.jobs.close()
        self.keeper.close()
        self._listening.stop()
        self.pointer.close()
        self.readouts.close()
        self.quality.close()
        self.looks.close()
        self.sections.close()
        self.scene.close()
        for panel in (*self.panels, self.slices):
            panel.close_panel()
        self.field_keys.close()
        self.focus_ring.close_ring()
        self.viewport.close()
        self.net.close()


def _ignoring(action: Callable[[], object]) -> Callable[[bool], object]:
    """Action that takes no notice of a mark."""
    return lambda _on: action()
