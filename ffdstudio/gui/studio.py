"""What panels and handlers share: the document, the viewer's choices, jobs, settings, questions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from psygnal import Signal

from ffdstudio.errors import InputError
from ffdstudio.gui.errors import problem_of
from ffdstudio.gui.state import WindowState
from ffdstudio.project.commands import Command
from ffdstudio.project.document import Document

if TYPE_CHECKING:
    from ffdstudio.gui.dialogs.ask import Asker
    from ffdstudio.gui.jobs import Jobs
    from ffdstudio.gui.settings import Settings
    from ffdstudio.gui.theme import Theme


@dataclass
class Studio:
    """One window's world."""

    document: Document
    state: WindowState
    jobs: Jobs
    settings: Settings
    asker: Asker
    theme: Theme
    said: ClassVar[Signal] = Signal(str)

    def say(self, text: str) -> None:
        """Show a text in the status line for a while."""
        self.said.emit(text)

    def do(self, command: Command) -> bool:
        """Carry out a command; if it cannot be, say why. Whether it was done."""
        return self.attempt(lambda: self._name(command), lambda: self.document.do(command))

    def _name(self, command: Command) -> str:
        """What a command is called in the history; it has changed nothing."""
        try:
            return f"“{command.label(self.document.settled_model).strip()}”"
        except InputError:  # what it is about is gone
            return "This"

    def attempt(
        self,
        doing: str | Callable[[], str],
        action: Callable[[], object],
        again: Callable[[], object] | None = None,
    ) -> bool:
        """Run something that may raise `InputError`, which becomes a dialog.

        Where it can be tried `again` with another file, the dialog offers that.
        """
        try:
            action()
        except InputError as error:
            name = doing if isinstance(doing, str) else doing()
            ways = () if again is None else (("Save &elsewhere…", again),)
            self.asker.tell(replace(problem_of(error, name), ways=ways))
            return False
        return True
