"""The journal: what was done, one line of JSON each, to be read and to be replayed.

1. Lines are commands in the words of `command_codec`, and ``{"do": "go to", "position": 3}`` for
   moves in the history: undo, redo and jumps.
2. Paths of meshes are stored relative to the journal, with their hash.
3. A document that was opened from a project begins its journal with the commands that
   build what the project held, so that a journal never depends on a project file.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from ffdstudio.containers.strictjson import field, loads
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.project.commands import Activate, AddLattice, AddStudy, Command, OpenMesh
from ffdstudio.project.files import references
from ffdstudio.project.files.command_codec import to_command, to_words
from ffdstudio.project.model import Model

FORMAT, SCHEMA = "ffdstudio-journal", 1
GO_TO = "go to"

Step = Command | int
"""A command, or the position in the history to go to."""


class Journal:
    """Steps in the order in which they were done."""

    def __init__(self, steps: list[Step] | None = None) -> None:
        self.steps: list[Step] = [] if steps is None else steps

    def record(self, step: Step) -> None:
        """Add what was just done."""
        self.steps.append(step)

    def copy(self) -> Journal:
        """Return a journal of the steps so far, for a worker to write."""
        return Journal(list(self.steps))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the journal, atomically."""
        write_bytes(path, self.text(Path(os.path.realpath(path)).parent).encode())

    def text(self, folder: Path) -> str:
        """Return the journal as it is stored in a folder."""
        header = {"format": FORMAT, "schema": SCHEMA}
        lines = [header, *(_words(step, folder) for step in self.steps)]
        return "".join(f"{_line(words)}\n" for words in lines)


def _line(words: dict[str, Any]) -> str:
    return json.dumps(words, ensure_ascii=False, allow_nan=False)


def _words(step: Step, folder: Path) -> dict[str, Any]:
    if isinstance(step, int):
        return {"do": GO_TO, "position": step}
    if isinstance(step, OpenMesh):
        step = replace(step, path=references.relative(Path(step.path), folder))
    return to_words(step)


def read_journal(path: str | os.PathLike[str]) -> Iterator[tuple[int, Step]]:
    """Yield line number and step of a journal, one after the other.

    Raises
    ------
    InputError
        If it cannot be read, or a line is none; the message names it.
    """
    name, folder = os.fspath(path), Path(os.path.realpath(path)).parent
    lines = read_bytes(path).splitlines()
    _check_header(lines, name)
    for number, line in enumerate(lines[1:], start=2):
        if line.strip():
            yield number, _step(line, folder, f"{name}, line {number}")


def _check_header(lines: list[bytes], name: str) -> None:
    header = loads(lines[0], name) if lines else {}
    if header.get("format") != FORMAT:
        raise InputError(f"{name}: no journal of FFD Studio")
    if field(header, "schema", int, name) > SCHEMA:
        raise InputError(f"{name}: written by a newer FFD Studio; update it to replay this")


def _step(line: bytes, folder: Path, place: str) -> Step:
    words = loads(line, place)
    if words.get("do") == GO_TO:
        return int(field(words, "position", int, place))
    try:
        command = to_command(words)
    except InputError as error:
        raise InputError(f"{place}: {error}") from None
    if isinstance(command, OpenMesh):
        return replace(command, path=os.fspath(references.absolute(command.path, folder)))
    return command


def commands_of(model: Model) -> list[Command]:
    """Return commands that build a model from nothing."""
    commands: list[Command] = []
    for body in model.bodies:
        colour, hidden = body.colour, tuple(sorted(body.hidden_markers))
        look = (body.visible, colour, hidden, body.boxes, str(body.follows))
        said = (os.fspath(body.path), body.sha256, body.name, *look)
        commands.append(OpenMesh(*said, mesh=body.mesh, packed=body.packed))
    for item in model.lattices:
        states = (item.name, item.rest, item.current, item.frozen, item.visible, item.enabled)
        shapes, faces = tuple(item.shapes.items()), item.open_faces
        commands.append(AddLattice(*states, shapes=shapes, open_faces=faces))
    commands += [AddStudy(item.name, item.spec) for item in model.studies]
    if model.lattices and model.active is not None:
        place = [item.key for item in model.lattices].index(model.active)
        commands.append(Activate(f"lattice{len(model.bodies) + place + 1}"))
    return commands
