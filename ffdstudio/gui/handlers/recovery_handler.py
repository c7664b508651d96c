"""Autosave, recovery after a crash, and meshes of a project that are not where they were."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from ffdstudio.gui.dialogs.ask import Question
from ffdstudio.gui.studio import Studio
from ffdstudio.project.autosave import INTERVAL, Autosave
from ffdstudio.project.files.records import BodyRecord, ProjectFile
from ffdstudio.project.files.recovery import Left, left_behind

ANY = "All files (*)"


class Keeper(QObject):
    """Saves in the background and brings back what a crash has left."""

    def __init__(self, studio: Studio, folder: Path | None = None) -> None:
        super().__init__()
        self._studio, self._folder = studio, folder
        self._autosave = Autosave(studio.document, folder)
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._autosave.tick)
        self._timer.start(round(1000 * INTERVAL))
        studio.document.ask = self.ask_for_meshes

    def tick(self) -> None:
        """Autosave now, if there is anything new."""
        self._autosave.tick()

    def close(self) -> None:
        """End properly: no autosave is left."""
        self._timer.stop()
        self._autosave.close()
        self._studio.document.ask = None

    # ---- recovery ---------------------------------------------------------------------------

    def offer(self) -> None:
        """Ask whether to bring back what sessions that died have left."""
        found = left_behind(self._folder)
        if not found:
            return
        newest = found[0]
        answer = self._studio.asker.choose(_recovery_question(newest, len(found)))
        if answer == "recover":
            self._recover(newest)
        elif answer == "discard":
            for left in found:
                left.discard()

    def _recover(self, left: Left) -> None:
        document = self._studio.document
        document.recover(left)

        def arrived() -> None:
            document.structure_changed.disconnect(arrived)
            self._autosave.tick()  # a copy of our own before the old one goes
            self._studio.say("Recovered. Save the project to keep it.")

        document.structure_changed.connect(arrived)

    # ---- meshes that are missing or have changed --------------------------------------------

    def ask_for_meshes(self, content: ProjectFile) -> ProjectFile | None:
        """Let the user point to missing meshes; None if he gives up."""
        kept: list[BodyRecord] = []
        for body in content.bodies:
            if body.packed is not None or body.path.exists():
                kept.append(body)
                continue
            found = self._find(body)
            if found is None:
                return None
            kept += found
        changed = [text for text in content.problems if "changed" in text]
        if changed and not self._accept(changed):
            return None
        content.bodies, content.problems = kept, []
        return content

    def _find(self, body: BodyRecord) -> list[BodyRecord] | None:
        """The body at another path, or none, or None to give up."""
        question = Question(
            "Missing mesh",
            f"The mesh of {body.name} is not there any more.",
            f"It was {body.path}. Show where it is now, or open the project without it.",
            (("find", "&Find it…"), ("leave", "&Leave it out"), ("cancel", "Cancel")),
        )
        answer = self._studio.asker.choose(question)
        if answer == "leave":
            return []
        if answer == "cancel":
            return None
        paths = self._studio.asker.open_paths(f"Find {body.path.name}", ANY, body.path.parent)
        if not paths:
            return self._find(body)
        body.path, body.sha256 = paths[0], ""
        return [body]

    def _accept(self, changed: list[str]) -> bool:
        question = Question(
            "Changed mesh",
            "A mesh has changed since the project was saved.",
            "\n".join(changed),
            (("open", "&Open it as it is now"), ("cancel", "Cancel")),
        )
        return self._studio.asker.choose(question) == "open"


def _recovery_question(left: Left, count: int) -> Question:
    when = datetime.fromtimestamp(left.saved)
    name = left.project.name if left.project else "a project that was never saved"
    more = f" There are {count - 1} older ones." if count > 1 else ""
    return Question(
        "Recovery",
        "FFD Studio did not end properly the last time.",
        f"There is an autosave of {name} from {when:%d %B %Y, %H:%M}.{more}",
        (("recover", "&Recover"), ("discard", "&Discard"), ("later", "Ask again later")),
    )
