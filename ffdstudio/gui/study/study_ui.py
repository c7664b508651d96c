"""Everything about studies that the window takes in: docks, the handler, closing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.cellcheck import CellCheck
from ffdstudio.gui.study.plots import WhenSeen
from ffdstudio.gui.study.runner import StudyRunner
from ffdstudio.gui.theme import Theme

if TYPE_CHECKING:
    from ffdstudio.gui.study.airfoil import AirfoilPanel
    from ffdstudio.gui.study.convergence import ConvergencePanel
    from ffdstudio.gui.study.panel import StudyPanel
    from ffdstudio.gui.study.refine import RefinePanel

BELOW = {"Convergence": 2, "Airfoil": 3, "Refine here": 2}  # with their shares of the width
BELOW_HEIGHT, POINTS_HEIGHT = 260, 130


class StudyRoom:
    """Panels of studies, each made when it is first seen; also the handler of their actions."""

    def __init__(self, studio: Studio) -> None:
        self.studio = studio
        self.runner = StudyRunner(studio)
        self._cells = CellCheck(studio, self.runner)
        theme = studio.theme
        self.seen = {
            "Study": WhenSeen(self._make_panel, theme),
            "Convergence": WhenSeen(self._make_convergence, theme),
            "Airfoil": WhenSeen(self._make_airfoil, theme),
            "Refine here": WhenSeen(self._make_refine, theme),
        }
        self.docks: dict[str, QDockWidget] = {}

    def _make_panel(self) -> QWidget:
        from ffdstudio.gui.study.panel import StudyPanel

        return StudyPanel(self.studio, self.runner)

    def _make_convergence(self) -> QWidget:
        from ffdstudio.gui.study.convergence import ConvergencePanel

        return ConvergencePanel(self.studio, self.runner)

    def _make_airfoil(self) -> QWidget:
        from ffdstudio.gui.study.airfoil import AirfoilPanel

        return AirfoilPanel(self.studio, self.runner)

    def _make_refine(self) -> QWidget:
        from ffdstudio.gui.study.refine import RefinePanel

        return RefinePanel(self.studio, self.runner)

    def add_docks(self, window: QMainWindow, beside: QDockWidget) -> dict[str, QDockWidget]:
        """Add the docks, hidden: the form beside another dock, the plots below the picture."""
        right, below = Qt.DockWidgetArea.RightDockWidgetArea, Qt.DockWidgetArea.BottomDockWidgetArea
        for title, widget in self.seen.items():
            dock = QDockWidget(title, window)
            dock.setObjectName(title)
            dock.setWidget(widget)
            self.docks[title] = dock
            if title in BELOW:
                window.addDockWidget(below, dock, Qt.Orientation.Horizontal)
            else:
                window.addDockWidget(right, dock)
                window.tabifyDockWidget(beside, dock)
            dock.hide()
        self._window = window
        beside.raise_()
        return self.docks

    def paint_with(self, theme: Theme) -> None:
        """Take the colours of a theme."""
        for widget in self.seen.values():
            widget.paint_with(theme)

    def conditions(self) -> dict[str, bool]:
        """Which of the conditions of the action table hold."""
        runner = self.runner
        return {
            "study idle": bool(self.studio.document.model.bodies) and not runner.alive,
            "study alive": runner.alive,
            "study shown": runner.showing,
            "study any": any(run.iterates for run in runner.runs),
        }

    def may_close(self) -> bool:
        """Whether the window may close: no study runs, or the user has it stopped."""
        return self.runner.may_close()

    def close_panel(self) -> None:
        """Stop listening, and the study under way."""
        self._cells.close()
        self.runner.close()
        for widget in self.seen.values():
            widget.close_panel()

    # ---- panels by name -----------------------------------------------------------------------

    @property
    def panel(self) -> StudyPanel:
        """The form."""
        made: StudyPanel = self.seen["Study"].made()
        return made

    @property
    def convergence(self) -> ConvergencePanel:
        """The plot."""
        made: ConvergencePanel = self.seen["Convergence"].made()
        return made

    @property
    def airfoil_view(self) -> AirfoilPanel:
        """The airfoil view."""
        made: AirfoilPanel = self.seen["Airfoil"].made()
        return made

    @property
    def refine_view(self) -> RefinePanel:
        """The bars."""
        made: RefinePanel = self.seen["Refine here"].made()
        return made

    def _show(self, *titles: str) -> None:
        before = {title for title in BELOW if self.docks[title].isVisible()}
        for title in titles:
            self.docks[title].show()
            self.docks[title].raise_()
        if {title for title in titles if title in BELOW} - before:
            self._share(not before)

    def _share(self, fresh: bool) -> None:
        """Give the docks below the picture their shares of the width, at first a height too."""
        window, below = self._window, list[QDockWidget]()
        for title in BELOW:
            dock, beside = self.docks[title], window.tabifiedDockWidgets(self.docks[title])
            if dock.isVisible() and not dock.isFloating() and not set(beside) & set(below):
                below.append(dock)
        if fresh:
            heights = [max(BELOW_HEIGHT, window.height() // 3)] * len(below)
            window.resizeDocks(below, heights, Qt.Orientation.Vertical)
        shares = [BELOW[dock.windowTitle()] for dock in below]
        widths = [window.width() * share // sum(shares) for share in shares]
        window.resizeDocks(below, widths, Qt.Orientation.Horizontal)

    # ---- actions, by their names in the table ---------------------------------------------------

    def setup(self) -> None:
        """Open the form."""
        self._show("Study")
        points = self._window.findChild(QDockWidget, "Points")
        if isinstance(points, QDockWidget) and points.height() > POINTS_HEIGHT:
            docks, heights = [self.docks["Study"], points], [self._window.height(), POINTS_HEIGHT]
            self._window.resizeDocks(docks, heights, Qt.Orientation.Vertical)
        self.panel.setFocus()

    def start(self) -> None:
        """Start what the form says, with the plots in sight."""
        flat = self.panel.form.has_sections
        self._show("Study", "Convergence", *(("Airfoil",) if flat else ()))
        self.panel.begin()

    def pause(self) -> None:
        """Pause, or go on."""
        if self.runner.alive:
            self.panel.toggle_pause()

    def step(self) -> None:
        """One iterate."""
        self.panel.one_step()

    def stop(self) -> None:
        """End the study under way."""
        self.runner.stop()

    def use(self) -> None:
        """Take over the iterate that is shown."""
        self.runner.use()

    def release(self) -> None:
        """Show the lattice as it is in the document."""
        self.runner.release()

    def convergence_plot(self) -> None:
        """Show the plot and the timeline."""
        self._show("Convergence")

    def airfoil(self) -> None:
        """Show the airfoil view."""
        self._show("Airfoil")

    def refine(self) -> None:
        """Show the bars, in the place of the airfoil view if that is open."""
        self.panel.fill()  # the bars need the objective that the form describes
        airfoil, bars = self.docks["Airfoil"], self.docks["Refine here"]
        if airfoil.isVisible() and not bars.isVisible() and not airfoil.isFloating():
            self._window.tabifyDockWidget(airfoil, bars)
        self._show("Refine here")

    def save_case(self) -> None:
        """Write what the form says as a case file."""
        self.panel.save_case()

    def load_case(self) -> None:
        """Fill the form from a case file."""
        self._show("Study")
        self.panel.load_case()

    def export(self) -> None:
        """Write the plot or its figures."""
        if self.runner.runs:
            self.convergence.save()
