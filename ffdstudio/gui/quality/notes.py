"""Lines of the quality panel about planes that bend and lattices that fold."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from ffdstudio.gui.panels.fields import say
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.project.checks.folding import MEANING, Foldings, told


class PlaneNote(QLabel):
    """What of a body is no longer planar or no longer a pair; hidden when all is well."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._document = studio.document
        self.setWordWrap(True)
        self.setProperty("role", "warning")
        self.hide()

    def fill(self, body: str) -> None:
        """Show what is known of a body."""
        volume = self._document.volume(body)
        say(self, "" if volume is None else "".join(f"{told}.\n" for told in volume.broken).strip())


class FoldNote(QLabel):
    """Whether the active lattice is locally invertible; hidden when it is at rest."""

    def __init__(self, studio: Studio, foldings: Foldings) -> None:
        super().__init__()
        self._document, self._foldings = studio.document, foldings
        self.setWordWrap(True)
        self._listening = Listening(
            (studio.document.structure_changed, self.fill),
            (studio.document.moved, self.fill),
            (foldings.changed, self._on_key),
        )
        self.fill()

    def close_note(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def _on_key(self, _key: str) -> None:
        self.fill()

    def fill(self) -> None:
        """Show what is known of the active lattice."""
        item = self._document.settled_model.active_lattice
        if item is None or not item.deformed:
            self.hide()
            return
        found = self._foldings.known(item.key)
        put(self, *told(item.name, found))
        how = "" if found is None else f"{found.method[:1].upper()}{found.method[1:]}. "
        self.setToolTip(how + MEANING)
        self.show()


def put(label: QLabel, text: str, role: str) -> None:
    """Show a text in a note of another role."""
    label.setText(text)
    label.setProperty("role", role)
    label.style().unpolish(label)
    label.style().polish(label)
