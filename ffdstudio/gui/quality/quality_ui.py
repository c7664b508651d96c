"""Everything about quality in the window, put together: panel, colours, marks, guard."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtWidgets import QDockWidget

from ffdstudio.gui.actions import Actions
from ffdstudio.gui.quality.choice import Choice
from ffdstudio.gui.quality.guardline import GuardLine
from ffdstudio.gui.quality.legend import Legend
from ffdstudio.gui.quality.marks import CellMark
from ffdstudio.gui.quality.painter import Painter
from ffdstudio.gui.quality.panel import QualityPanel
from ffdstudio.gui.quality.ringline import RingLine
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.sections import SectionPlanes
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.project.checks.checking import Checks
from ffdstudio.project.checks.folding import Foldings
from ffdstudio.project.checks.guarding import DragGuard
from ffdstudio.project.interaction.tools import Tools


class QualityPart:
    """Owns the reports and the guard; its `panel` goes into a dock.

    It is also the handler of the Quality menu.
    """

    def __init__(self, studio: Studio, scene: Scene, sections: SectionPlanes, tools: Tools) -> None:
        self._studio = studio
        settings = studio.settings
        self.choice, self.checks = Choice(), Checks(studio.document)
        self.warden = DragGuard(
            studio.document,
            settings.text("guard", "warn"),
            settings.text("guard_limits", "inversion"),
        )
        tools.guard_with(self.warden)
        self.foldings = Foldings(studio.document)
        self.panel = QualityPanel(studio, self.checks, self.choice, self.warden, self.foldings)
        self.painter = Painter(studio, scene, sections, self.checks, self.choice)
        self.legend = Legend(studio, scene.viewport, self.checks, self.choice)
        self.mark = CellMark(scene.viewport, studio.document, self.checks, self.choice)
        self.line, self.ring = GuardLine(scene.viewport, tools), RingLine(studio, scene)
        self.reveal: Callable[[], None] = lambda: None
        self._seen = False
        self._sought = ""  # body whose inverted cells are to be shown
        self._listening = Listening(
            (self.choice.changed, self._watch), (self.checks.changed, self._find)
        )

    def attach(self, dock: QDockWidget, actions: Actions) -> None:
        """Take note of the dock the panel is in, and of the rows of the menu."""

        def reveal() -> None:
            dock.show()
            dock.raise_()

        def check() -> None:
            actions.check("quality.colour", self.choice.wanted.colour != "off")
            actions.check(f"quality.guard_{self.warden.mode}", True)

        self.reveal = reveal
        dock.visibilityChanged.connect(self.see)
        self._checking = Listening((self.choice.changed, check), (self.warden.changed, check))
        check()

    def close(self) -> None:
        """Stop listening and leave the picture; the panel is closed with the others."""
        self._listening.stop()
        self._checking.stop()
        for part in (self.mark, self.painter, self.line, self.ring, self.warden, self.checks):
            part.close()
        self.foldings.close()
        self.legend.close_legend()

    def paint_with(self, _theme: Theme) -> None:
        """Take the colours of a theme."""
        self.painter.paint()
        self.ring.update()
        self.legend.update()

    def see(self, on: bool) -> None:
        """Take note whether the panel is seen: nothing is measured for nobody."""
        self._seen = on
        self._watch()

    def _watch(self) -> None:
        self.checks.watch(self._seen or self.choice.wanted.colour != "off")
        self.foldings.watch(self._seen)

    # ---- the Quality menu -------------------------------------------------------------------

    def show(self) -> None:
        """Show the panel."""
        self.reveal()

    def colour(self, on: bool) -> None:
        """Colour the mesh by the measure, or not."""
        self.choice.want(colour="value" if on else "off")

    def show_inverted(self, body: str) -> None:
        """Show a body by the measure that inverted cells fail, and fly to the worst of them."""
        self.reveal()
        self.choice.want(body=body, measure="scaled_jacobian", colour="value")
        self._sought = body
        self._find()

    def _find(self, _key: str = "") -> None:
        """Pick the inverted cell that is sought, once the cells are measured."""
        report = self.checks.report(self._sought)
        if report is None or not self.checks.current(self._sought):
            return
        cells = np.flatnonzero(report.inverted)
        if len(cells):
            worst = np.argmin(report.measures["scaled_jacobian"][cells])
            self.choice.want(cell=int(cells[worst]))
        self._sought = ""

    def worst(self) -> None:
        """Fly to the worst cell; when there already, to the next one."""
        self.reveal()
        cells = self.panel.worst.cells()
        if cells:
            here = self.choice.wanted.cell
            place = cells.index(here) + 1 if here in cells else 0
            self.choice.want(cell=cells[place % len(cells)])

    def guard_stop(self) -> None:
        """Drags end at the limit."""
        self.warden.set(mode="stop")

    def guard_warn(self) -> None:
        """Drags beyond the limit are told."""
        self.warden.set(mode="warn")

    def guard_free(self) -> None:
        """No guard."""
        self.warden.set(mode="free")
