"""Records of the studies of a document: kept beside the model, and in the project file.

1. A study runs for long and tells of thousands of steps: they are no edits. The model holds the
   descriptions, which can be undone; records are kept by the key of their study, so that an undo
   of its removal brings them back.
2. A key may be given again when what was undone is forgotten: `forget` drops what belonged to
   the one before.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record, RunHistory
    from ffdstudio.optimize.spec.goals import ObjectiveSpec
    from ffdstudio.project.model import Model


class StudyRecords:
    """Histories by the key of their study.

    Attributes
    ----------
    version : int
        Changes with every study that has begun or ended: what a save has to hold.
    strangers : dict
        Objectives that came inside the project, and its path: their programs are not trusted.
    """

    def __init__(self) -> None:
        self.version = 0
        self.strangers: dict[ObjectiveSpec, Path] = {}
        self._known: dict[str, RunHistory] = {}

    def history(self, key: str) -> RunHistory:
        """RunHistory of a study; a new one if nothing is known."""
        from ffdstudio.optimize.runs.record import RunHistory

        return self._known.setdefault(key, RunHistory())

    def put(self, key: str, records: list[Record]) -> None:
        """Take the records of a study that was read."""
        from ffdstudio.optimize.runs.record import RunHistory

        self._known[key] = RunHistory(records)

    def begin(self, key: str) -> RunHistory:
        """Begin a history anew."""
        self.put(key, [])
        self.version += 1
        return self._known[key]

    def ended(self) -> None:
        """Take note that a study has ended: there is something to save."""
        self.version += 1

    def forget_new(self, before: Model, after: Model) -> None:
        """Drop what is known of the keys of studies that a command has added."""
        old = {item.key for item in before.studies}
        for item in after.studies:
            if item.key not in old:
                self._known.pop(item.key, None)

    def take(self, model: Model, records: dict[str, list[Record]], path: Path | None) -> None:
        """Begin anew with a model that was opened, and the records of its studies."""
        self._known.clear()
        self.version = 0
        for key, known in records.items():
            self.put(key, known)
        named = path or Path("the project")
        self.strangers = {item.spec.objective: named for item in model.studies}

    def source_of(self, objective: ObjectiveSpec) -> Path | None:
        """Return the project that an objective came inside; None if the user says it."""
        return self.strangers.get(objective)

    def of(self, key: str) -> list[Record]:
        """Records of a study at this moment, a copy."""
        known = self._known.get(key)
        return [] if known is None else list(known.records)
