"""Commands that change the visibility of many things at once."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ffdstudio.errors import InputError
from ffdstudio.project.commands.base import Command
from ffdstudio.project.model import Model


@dataclass(frozen=True)
class IsolateMarker(Command):
    """Show one marker of a body without its others, and the body with it."""

    verb: ClassVar[str] = "isolate marker"
    looks_only: ClassVar[bool] = True
    item: str
    marker: str

    def apply(self, model: Model) -> Model:
        body = model.body(self.item)
        if self.marker not in body.mesh.markers:
            raise InputError(f"{body.name} has no marker {self.marker}")
        others = frozenset(body.mesh.markers) - {self.marker}
        return model.with_(replace(body, visible=True, hidden_markers=others))

    def label(self, model: Model) -> str:
        return f"Show {self.marker} alone"


@dataclass(frozen=True)
class ShowAll(Command):
    """Show all bodies, markers and lattices."""

    verb: ClassVar[str] = "show all"
    looks_only: ClassVar[bool] = True

    def apply(self, model: Model) -> Model:
        bodies = [replace(b, visible=True, hidden_markers=frozenset()) for b in model.bodies]
        lattices = [replace(item, visible=True) for item in model.lattices]
        return model.with_(*bodies, *lattices)

    def label(self, model: Model) -> str:
        return "Show all"
