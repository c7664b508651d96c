"""Doing a journal again without a window."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ffdstudio.errors import InputError
from ffdstudio.files import together
from ffdstudio.meshes.formats import suffix_of
from ffdstudio.project.commands import Command, OpenMesh
from ffdstudio.project.files.exporting import Written, write_body
from ffdstudio.project.files.journal import read_journal
from ffdstudio.project.files.opening import load
from ffdstudio.project.history import Entry, History
from ffdstudio.project.model import Body, Model


def replay(path: str | os.PathLike[str]) -> Model:
    """Return the model that a journal ends with.

    Raises
    ------
    InputError
        If a line is wrong or cannot be carried out, or a mesh is missing or has changed.
    """
    model, history = Model(), History()
    for number, step in read_journal(path):
        try:
            if isinstance(step, Command):
                model = _carried_out(step, model, history)
            else:
                model = history.at(step)
        except (InputError, IndexError) as error:
            what = error if isinstance(error, InputError) else f"there is no position {step}"
            raise InputError(f"{os.fspath(path)}, line {number}: {what}") from None
    return model


def _carried_out(command: Command, model: Model, history: History) -> Model:
    if isinstance(command, OpenMesh):
        command = load(command)
    after = command.apply(model)
    history.push(Entry(command, "", model, after))
    return after


def export(
    model: Model, folder: str | os.PathLike[str], tell: Callable[[str], None] = lambda text: None
) -> list[Written]:
    """Write all bodies of a model, deformed, into a folder, under the names of their files.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {target}: {error.strerror}") from error
    written, names = [], _file_names(model.bodies)
    with together():  # none of them if one would overwrite what was read
        for body, name in zip(model.bodies, names, strict=True):
            tell(f"writing {name}")
            written.append(write_body(body, model.steps, target / name))
    return written


def _file_names(bodies: tuple[Body, ...]) -> list[str]:
    """Names of the bodies' files; where two have the same one, the bodies' own names."""
    names = [body.path.name for body in bodies]
    twice = {name for name in names if names.count(name) > 1}
    own = [f"{body.name}{suffix_of(body.path)}".replace("/", "_") for body in bodies]
    return [b if a in twice else a for a, b in zip(names, own, strict=True)]
