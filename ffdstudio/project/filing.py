"""Files of a document: meshes, lattices and projects in and out, as work for its runner.

1. Every function gives work to `document.runner` and returns; what comes of it arrives later
   on the document's thread, failures as the signal *problem*.
2. A worker sees values only: the model when the work began, paths, records.
3. Meshes of a project that are missing or have changed are shown to `document.ask`, which may
   point to other files (`BodyRecord.path`), drop bodies, or give up by returning None.
4. A project file that somebody else has written on since is not replaced unasked
   (`document.may_overwrite`).
5. A project takes a while to read, and may be edited until it is there: `document.may_replace`
   is asked before what was done in the meantime goes.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ffdstudio.aliases import PathLike
from ffdstudio.errors import InputError
from ffdstudio.exchange import LatticeFile, read_lattice_file, write_lattice
from ffdstudio.files import stamp
from ffdstudio.paths import is_same
from ffdstudio.project.commands import AddLattice
from ffdstudio.project.editor import Editor
from ffdstudio.project.files.exporting import Written, write_body
from ffdstudio.project.files.model_codec import activation, lattice_commands
from ffdstudio.project.files.opening import Opened, open_body, read_record
from ffdstudio.project.files.records import BodyRecord, ProjectFile, StudyFile
from ffdstudio.project.files.storage import read_project, write_project
from ffdstudio.project.files.study_codec import study_command
from ffdstudio.project.model import Model
from ffdstudio.project.running import Progress

if TYPE_CHECKING:
    from ffdstudio.optimize.runs.record import Record
    from ffdstudio.project.files.recovery import Left

MOST_LATTICES = 100  # that one file may bring into a project
OPENING = "opening"  # the line of work that arrives in the order in which it was asked for


def _register_surface(document: Editor, opened: Opened) -> None:
    """Hand over the surface of a mesh that the worker who read it has worked out."""
    assert opened.command.mesh is not None
    document.surfaces[opened.command.mesh] = opened.surface


def open_mesh(document: Editor, path: PathLike) -> None:
    """Read a mesh and add it as a body."""

    def done(opened: Opened) -> None:
        _register_surface(document, opened)
        document.do(opened.command)
        document.filed.emit(Path(path))

    name = Path(path).name
    failed = document.failed(f"{name} cannot be opened", "open")
    work = lambda p: open_body(path, p)  # noqa: E731
    document.runner.start(f"Opening {name}", work, done, failed, line=OPENING)


def export_mesh(document: Editor, key: str, path: PathLike) -> None:
    """Write a body as it is deformed."""
    model = document.settled_model
    body, steps = model.body(key), model.steps

    def done(written: Written) -> None:
        for loss in written.losses:
            document.problem.emit(f"{written.path.name} was written with losses", loss, "note")
        document.told.emit(
            f"{written.path} written: {written.moved} of {written.nodes} nodes moved"
        )

    failed = document.failed(f"{body.name} cannot be exported", "export")
    work = lambda p: write_body(body, steps, path, p)  # noqa: E731
    document.runner.start(f"Exporting {body.name}", work, done, failed)


def import_lattice(document: Editor, path: PathLike, block: str | None = None) -> None:
    """Read a lattice file of any format and add it: one lattice of it, or by default all."""

    def done(found: list[LatticeFile]) -> None:
        name = Path(path).name.split(".")[0] or "Lattice"
        try:
            for number, each in enumerate(found):
                own = name if len(found) == 1 else f"{name} {each.blocks[number]}"
                document.do(_added(own, each))
        except InputError as error:  # more frozen layers than there are
            failed(error)
            return
        document.filed.emit(Path(path))
        for text in _told(found):
            document.problem.emit(f"{Path(path).name} was read", text, "note")

    failed = document.failed(f"{Path(path).name} cannot be opened", "open")
    work = lambda p: _lattices(path, block)  # noqa: E731
    document.runner.start(f"Reading {Path(path).name}", work, done, failed, line=OPENING)


def _lattices(path: PathLike, block: str | None) -> list[LatticeFile]:
    """One lattice of a file, or all that it holds."""
    first = read_lattice_file(path, block)
    if block is not None:
        return [first]
    if len(first.blocks) > MOST_LATTICES:
        raise InputError(
            f"{os.fspath(path)}: holds {len(first.blocks)} lattices, more than a project takes at "
            "once; convert --block makes a file of one"
        )
    return [first, *(read_lattice_file(path, k) for k in range(1, len(first.blocks)))]


def _told(found: list[LatticeFile]) -> list[str]:
    """What to say of lattices that were read, each thing once."""
    inexact = [str(each.exactness) for each in found if not each.exactness.exact]
    return list(dict.fromkeys([*inexact, *(text for each in found for text in each.notes)]))


def _added(name: str, found: LatticeFile) -> AddLattice:
    faces = found.open_faces
    return AddLattice(name, found.rest, found.current, found.frozen, open_faces=faces)


def export_lattice(document: Editor, key: str, path: PathLike) -> None:
    """Write a lattice, at rest and as it is; its file is small, so at once."""
    item = document.settled_model.lattice(key)
    try:
        frozen, faces = item.frozen, item.open_faces
        exactness = write_lattice(path, item.rest, item.current, frozen=frozen, open_faces=faces)
    except InputError as error:
        document.problem.emit(f"{item.name} cannot be exported", str(error), "export lattice")
    else:
        document.told.emit(f"{os.fspath(path)} written: {exactness}")


# ---- projects ---------------------------------------------------------------------------


class ChangedOnDisk(InputError):
    """Somebody else has written on the project file since it was read or written here."""


def save(document: Editor, path: PathLike, pack_meshes: bool, over: bool = False) -> None:
    """Write the project; what is done in the meantime counts as not saved.

    With `over` also over what somebody else has written since: `document.may_overwrite` agreed.
    """
    model, target = document.settled_model, Path(path)
    content, turn = document.snapshot(), document.turns.take()
    records = document.records.version
    ours = not over and document.path is not None and is_same(document.path, target)

    def done(_: None) -> None:
        if not document.turns.latest(turn):  # saved again in the meantime
            return
        document.path = target
        document.saved(model, records)
        document.filed.emit(target)
        document.told.emit(f"{target} saved")

    told = document.failed(f"{target.name} cannot be saved", "save")

    def failed(error: Exception) -> None:
        ask = document.may_overwrite
        if not isinstance(error, ChangedOnDisk) or ask is None:
            told(error)
        elif ask(target):
            save(document, target, pack_meshes, over=True)

    def write() -> None:
        now, known = stamp(target), document.on_disk
        if ours and None not in (now, known) and now != known:
            raise ChangedOnDisk(
                f"{target}: has been changed by another program since it was opened"
            )
        write_project(target, content, pack_meshes)
        document.on_disk = stamp(target)  # here, where the next save waits for this one

    def work(progress: Progress) -> None:
        progress(0.0, f"writing {target.name}")
        document.turns.wait(turn, target, write)

    document.runner.start(f"Saving {target.name}", work, done, failed)


def open_project(document: Editor, path: PathLike, recovered: Left | None = None) -> None:
    """Read a project, which replaces everything; what was `recovered` is not saved yet."""
    source = Path(path)
    failed = document.failed(f"{source.name} cannot be opened", "open")
    known = document.settled_model
    seen = stamp(source)  # before it is read: whatever comes later is a change

    def read(content: ProjectFile) -> None:
        chosen = _asked(document, content)
        if chosen is not None:
            label = f"Opening {source.name}"
            document.runner.start(label, lambda p: _load(chosen, p), loaded, failed, key="open")

    def loaded(result: tuple[ProjectFile, list[Opened], list[str]]) -> None:
        content, bodies, problems = result
        try:
            model = _model(content, bodies)
        except InputError as error:
            failed(error)
            return
        model, records, unread = _studied(model, content.studies)
        changed = document.settled_model is not known
        if changed and document.may_replace is not None and not document.may_replace():
            document.told.emit(f"{source.name} was not opened")
            return
        for opened in bodies:
            _register_surface(document, opened)
        target = source if recovered is None else recovered.project
        document.replace(model, content.sections, target, recovered is None, records)
        document.on_disk = seen if recovered is None else recovered.project_stamp
        if recovered is None:
            document.filed.emit(source)
        for problem in problems:
            document.problem.emit("A mesh of the project could not be opened", problem, "note")
        for problem in unread:
            document.problem.emit("A study of the project could not be opened", problem, "note")

    work = lambda p: read_project(source)  # noqa: E731
    document.runner.start(f"Opening {source.name}", work, read, failed, key="open")


def _asked(document: Editor, content: ProjectFile) -> ProjectFile | None:
    if not content.problems:
        return content
    if document.ask is not None:
        return document.ask(content)
    for problem in content.problems:
        document.problem.emit("A mesh of the project is not as it was", problem, "note")
    return content


def _load(content: ProjectFile, progress: Progress) -> tuple[ProjectFile, list[Opened], list[str]]:
    """Read the meshes of a project; one that cannot be read is left out and reported."""
    opened, problems = [], []
    for number, record in enumerate(content.bodies):
        progress(number / len(content.bodies), f"reading {record.name}")
        try:
            opened.append(_read(record))
        except InputError as error:
            problems.append(f"{record.name}: {error}")
    return content, opened, problems


def _read(record: BodyRecord) -> Opened:
    from ffdstudio.project.files.opening import hash_of

    if record.packed is None:  # a changed mesh was accepted: from now on it is this one
        record.sha256 = hash_of(record.path)
    return read_record(record)


def _model(content: ProjectFile, bodies: list[Opened]) -> Model:
    model = Model()
    for command in (*(opened.command for opened in bodies), *lattice_commands(content)):
        model = command.apply(model)
    for command in activation(content, model):
        model = command.apply(model)
    return model


def _studied(
    model: Model, studies: Iterable[StudyFile]
) -> tuple[Model, dict[str, list[Record]], list[str]]:
    """Model with stored studies, their records by key, and what is wrong with others."""
    records: dict[str, list[Record]] = {}
    problems: list[str] = []
    for stored in studies:
        try:
            model = study_command(stored, model).apply(model)
            records[model.studies[-1].key] = stored.records
        except InputError as error:
            problems.append(str(error))
    return model, records, problems
