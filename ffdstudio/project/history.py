"""The history: what was done, as a list to move in.

Each entry holds the models before and after its command. Models are immutable and share
all that stays the same, so an entry costs little, and going back gives the same object.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ffdstudio.project.model import Model

if TYPE_CHECKING:
    from ffdstudio.project.commands import Command


@dataclass(frozen=True, eq=False)
class Entry:
    """A command that was done."""

    command: Command
    label: str
    before: Model
    after: Model


@dataclass(eq=False)
class History:
    """Entries in order; the first `position` of them are done, the rest are undone."""

    entries: list[Entry] = field(default_factory=list)
    position: int = 0

    def push(self, entry: Entry) -> None:
        """Add what was just done; what was undone before is forgotten."""
        del self.entries[self.position :]
        self.entries.append(entry)
        self.position += 1

    def at(self, position: int) -> Model:
        """Model after the first `position` entries; the history then stands there."""
        if not 0 <= position <= len(self.entries) or not self.entries:
            raise IndexError(position)
        self.position = position
        return self.entries[position - 1].after if position else self.entries[0].before

    @property
    def labels(self) -> list[str]:
        """What each entry did, oldest first."""
        return [entry.label for entry in self.entries]

    @property
    def undo_label(self) -> str | None:
        """What undo would take back; None if there is nothing."""
        return self.entries[self.position - 1].label if self.position else None

    @property
    def redo_label(self) -> str | None:
        """What redo would do again; None if there is nothing."""
        done = self.position == len(self.entries)
        return None if done else self.entries[self.position].label
