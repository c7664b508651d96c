"""Keeping the recovery file of a document fresh.

The window calls `tick` from a timer; a crash then loses at most one interval. A drag under
way is not an edit yet and is left out. Writing is work for the document's runner.
"""

from __future__ import annotations

from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.project.editor import Editor
from ffdstudio.project.files.recovery import Session
from ffdstudio.project.model import Model
from ffdstudio.project.running import Progress

INTERVAL = 20.0
"""Seconds between two calls of `Autosave.tick`."""


class Autosave:
    """Writes a document to the recovery folder whenever it has changed.

    Parameters
    ----------
    document : Editor
    folder : pathlib.Path, optional
        Where sessions keep their recovery files; by default the user's state folder.
    """

    def __init__(self, document: Editor, folder: Path | None = None) -> None:
        self._document = document
        self._latest: tuple[Model, int] = document.settled_model, 0
        self._session: Session | None = None
        try:
            self._session = Session(folder)
        except InputError as error:
            document.problem.emit("There will be no autosaves", str(error), "note")

    def tick(self) -> None:
        """Write an autosave if there is anything new that is not in the project file."""
        document, session = self._document, self._session
        model = document.settled_model
        now = model, document.records.version
        if session is None or (now[0] is self._latest[0] and now[1] == self._latest[1]):
            return
        self._latest = now
        if not document.modified:
            session.forget()
            return
        content, journal, project = document.snapshot(), document.journal.copy(), document.path

        def work(progress: Progress) -> None:
            session.write(content, journal, project)

        failed = document.failed("The autosave cannot be written")
        document.runner.start("Autosaving", work, lambda _: None, failed, key="autosave")

    def close(self) -> None:
        """End properly: nothing is left behind."""
        if self._session is not None:
            self._session.close()
