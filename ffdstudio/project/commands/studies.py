"""Commands about studies: they come, go and get names like everything else."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.commands.base import Command
from ffdstudio.project.model import Model, StudyItem


def _plus(model: Model, name: str, spec: StudySpec) -> Model:
    model.check_name(name)
    item = StudyItem(model.new_key("study"), name, spec)
    return replace(model, studies=(*model.studies, item), used=model.used + 1)


@dataclass(frozen=True)
class AddStudy(Command):
    """Add a study by its description."""

    verb: ClassVar[str] = "add study"
    looks_only: ClassVar[bool] = True
    name: str
    spec: StudySpec

    def apply(self, model: Model) -> Model:
        return _plus(model, self.name, self.spec)

    def label(self, model: Model) -> str:
        return f"New {self.name}"


@dataclass(frozen=True)
class DuplicateStudy(Command):
    """Add a study with the description of another one, without its records."""

    verb: ClassVar[str] = "duplicate study"
    looks_only: ClassVar[bool] = True
    item: str

    def apply(self, model: Model) -> Model:
        old = model.study(self.item)
        return _plus(model, model.free_name(f"{old.name} copy"), old.spec)

    def label(self, model: Model) -> str:
        return f"Duplicate {model.study(self.item).name}"


@dataclass(frozen=True)
class RenameStudy(Command):
    """Give a study another name."""

    verb: ClassVar[str] = "rename study"
    looks_only: ClassVar[bool] = True
    item: str
    name: str

    def apply(self, model: Model) -> Model:
        model.check_name(self.name, self.item)
        new = replace(model.study(self.item), name=self.name)
        studies = tuple(new if item.key == self.item else item for item in model.studies)
        return replace(model, studies=studies)

    def label(self, model: Model) -> str:
        return f"Rename {model.study(self.item).name}"


@dataclass(frozen=True)
class RemoveStudy(Command):
    """Remove a study; its records come back with an undo."""

    verb: ClassVar[str] = "remove study"
    looks_only: ClassVar[bool] = True
    item: str

    def apply(self, model: Model) -> Model:
        model.study(self.item)
        return replace(
            model, studies=tuple(item for item in model.studies if item.key != self.item)
        )

    def label(self, model: Model) -> str:
        return f"Remove {model.study(self.item).name}"
