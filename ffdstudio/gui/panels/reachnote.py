"""The line of the lattice form that says how far the skin can move: a worker asks the cells."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QLabel

from ffdstudio.errors import InputError
from ffdstudio.gui.panels.fields import say
from ffdstudio.gui.studio import Studio
from ffdstudio.project.placing.placement import Placement, Site
from ffdstudio.project.placing.reach import is_little, reach_sentence
from ffdstudio.project.running import Progress

PAUSE_MS = 200  # between the last change of the form and the question
KEY = "reach"


class ReachNote(QLabel):
    """Says of the lattice in the form how far it lets the skin move, soon after it changed."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._asked: tuple[Site, Placement, int] | None = None
        self.reach: float | None = None
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(PAUSE_MS)
        self._timer.timeout.connect(self._ask)
        self.setWordWrap(True)
        say(self, "")

    @property
    def settled(self) -> bool:
        """Whether what it says is about the lattice in the form."""
        return self._asked is None

    def look(self, site: Site, placement: Placement, frozen: int) -> None:
        """Take note of another lattice in the form."""
        self._asked, self.reach = (site, placement, frozen), None
        self._timer.start()

    def stop(self) -> None:
        """There is no lattice in the form, or no form."""
        self._asked, self.reach = None, None
        self._timer.stop()
        say(self, "")

    def _ask(self) -> None:
        asked = self._asked
        if asked is None:
            return
        site, placement, frozen = asked

        def work(progress: Progress) -> float:
            return placement.reach(site, frozen, progress)

        def done(reach: float) -> None:
            if self._asked is asked:
                self._asked = None
                self._say(reach, placement.wanted)

        def failed(error: Exception) -> None:
            if not isinstance(error, InputError):
                raise error
            self.stop()

        self._studio.jobs.start("How far the skin can move", work, done, failed, KEY)

    def _say(self, reach: float, wanted: float) -> None:
        self.reach = reach
        say(self, reach_sentence(reach, wanted))
        self.setProperty("role", "warning" if is_little(reach, wanted) else "muted")
        self.style().unpolish(self)
        self.style().polish(self)
