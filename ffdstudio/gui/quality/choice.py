"""What the user wants to know of the quality: body, measure, colours, a solver's limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from psygnal import Signal

from ffdstudio.project.checks.checking import presets

COLOURS = {"off": "Off", "value": "Value", "change": "Change since undeformed"}


@dataclass(frozen=True)
class MeasureWanted:
    """Choices of the quality panel; `cell` is the worst cell that was picked, -1 for none."""

    body: str = ""
    measure: str = "skewness"
    colour: str = "off"
    preset: str = presets()[0]
    cell: int = -1


class Choice:
    """The choices, with a signal that they are others."""

    changed = Signal()

    def __init__(self) -> None:
        self.wanted = MeasureWanted()

    def want(self, **changes: Any) -> None:
        """Change choices; another body or measure lets go of the picked cell."""
        if {"body", "measure"} & changes.keys():
            changes.setdefault("cell", -1)
        new = replace(self.wanted, **changes)
        if new != self.wanted:
            self.wanted = new
            self.changed.emit()
