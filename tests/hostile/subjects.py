"""What the campaign opens: a valid file of every kind, and the work that opens it."""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np

from ffdstudio import Lattice, read_mesh, write_mesh
from ffdstudio.cli.optimize import read_case
from ffdstudio.errors import InputError
from ffdstudio.exchange import read_lattice_file, write_lattice
from ffdstudio.optimize.objectives.base import Abilities, Evaluation, Objective, Request
from ffdstudio.optimize.objectives.remembered import Remembered
from ffdstudio.optimize.runs.record import LOG, read_log
from ffdstudio.project import Project
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.files.replaying import export, replay
from tests.hostile.mutators import VICTIM
from tests.meshes.specimens import SPECIMENS
from tests.meshes.test_fuzz import TEXTS, check
from tests.optimize.test_damaged_logs import END, GOOD
from tests.project.scenes import BOX, opened, write_cube

Work = Callable[[Path], object]
CASES = Path(__file__).parents[2] / "resources" / "cases"
SLOW = ("xdmf",)  # a process for each


class Subject(NamedTuple):
    """A valid file, and what to do with a changed one in its place."""

    path: Path
    work: Work


def mesh(path: Path) -> object:
    """Read, look at every part, write, read again."""
    found = read_mesh(path)
    check(found)
    assert not (found.points == VICTIM).any()
    if found.template is not None:
        target = path.with_name(f"out-{path.name}")
        write_mesh(found, target)
        assert target.read_bytes() == path.read_bytes()
        target.unlink()
    return found


def lattice(path: Path) -> object:
    """Read every lattice of a file, use and write it."""
    first = read_lattice_file(path)
    for block in range(min(len(first.blocks), 5) or 1):
        found = read_lattice_file(path, block)
        middle = found.current.domain.mean(axis=1)
        assert np.isfinite(found.current.evaluate(middle[None])).all()
        write_lattice(path.with_name("out.lattice.json"), found.rest, found.current)
    return first


def project(path: Path) -> object:
    """Read it as a script does and as the window does, and save it again."""
    found = Project.open(path)
    document = Document()
    document.problem.connect(_is_told)
    document.open(path)
    if document.path is not None:
        document.save(path.with_name("out.ffdproj"))
    return found


def _is_told(title: str, cause: str, doing: str) -> None:
    sentence(title)
    sentence(cause)


def journal(path: Path) -> object:
    """Repeat it and write what comes of it."""
    model = replay(path)
    return export(model, path.with_name("out"))


def case(path: Path) -> object:
    """Set the study up; it is not run."""
    return read_case(path, path.with_name("out"))


def log(path: Path) -> object:
    """Read the record of a study, and every lattice in it."""
    shutil.copy(path, path.with_name(LOG))
    history = read_log(path.parent)
    return [history.lattice(k) for k in range(len(history.iterates))]


POINTS = np.linspace(0, 1, 12).reshape(4, 3)


class Known(Objective):
    """An objective with one answer."""

    abilities = Abilities()

    def answer(self, request: Request) -> Evaluation:
        return Evaluation(1.5, 2 * request.points, measures={"cl": 0.5})


def evaluation(path: Path) -> object:
    """Ask for what a folder remembers: whatever lies there, the answer is right."""
    kept = Remembered(Known(), path.parent / "known")
    shutil.copy(path, kept._path(POINTS))
    found = kept.answer(Request(POINTS))
    assert np.isfinite(found.value)
    assert found.gradient is not None
    assert found.gradient.shape == POINTS.shape
    return found


def sentence(message: str) -> None:
    """A message for people: one line of some length, not Python's."""
    assert len(message) > 10
    assert "\n" not in message
    assert "Traceback" not in message


# ---- making them ---------------------------------------------------------------------------------


def subjects(folder: Path) -> list[Subject]:
    """Make a valid file of every kind in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    found = [*_meshes(folder), *_lattices(folder), *_projects(folder), *_cases(folder)]
    for made in found:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            made.work(made.path)  # as it is, it is fine
    return found


def _meshes(folder: Path) -> list[Subject]:
    for name, write in SPECIMENS.items():
        write(folder / name)
    for name, data in TEXTS.items():
        (folder / name).write_bytes(data)
    names = [*SPECIMENS, *TEXTS]
    box = meshio.Mesh(np.eye(4, 3), {"tetra": [[0, 1, 2, 3]]})
    for number, form in enumerate(("XML", "Binary", "HDF")):
        box.write(folder / f"x{number}.xdmf", data_format=form)
    return [Subject(folder / n, mesh) for n in (*names, "x0.xdmf", "x1.xdmf", "x2.xdmf")]


def _lattices(folder: Path) -> list[Subject]:
    box = Lattice.box([0, 0, 0], [1, 2, 3], (4, 3, 3), spacing="uniform")
    bezier = Lattice.box([0, 0, 0], [1, 2, 3], (4, 3, 3), (3, 2, 2), spacing="uniform")
    moved = bezier.moved(bezier.control_points + 0.01)
    names = [
        "a.lattice.json",
        "a.geomdl.json",
        "a.splinepy.json",
        "a.g2",
        "a.xyz",
        "a.prm",
        "a.cfg",
    ]
    for name in names:
        current = moved if name == "a.prm" else bezier
        write_lattice(folder / name, bezier, current, adapt="resample")
    write_cube(folder / "boxed.su2")
    write_lattice(folder / "boxed.su2", box, adapt="resample")
    return [Subject(folder / name, lattice) for name in (*names, "boxed.su2")]


def _projects(folder: Path) -> list[Subject]:
    cube = folder / "cube.su2"
    write_cube(cube)
    document = opened(cube, BOX)
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    document.do(c.SaveShape("lattice2", "bent"))
    document.do(c.InsertKnots("lattice2", 0, (0.37,)))
    document.do(c.SetWeights("lattice2", ((1, 2, 2),), (3.0,)))
    document.sections["studies"] = {"one": np.arange(3), "two": [1, {"a": None}]}
    document.save(folder / "plain.ffdproj")
    document.save(folder / "packed.ffdproj", pack_meshes=True)
    document.journal.save(folder / "a.jsonl")
    names = ("plain.ffdproj", "packed.ffdproj")
    return [*(Subject(folder / n, project) for n in names), Subject(folder / "a.jsonl", journal)]


def _cases(folder: Path) -> list[Subject]:
    names = ("contour", "pressure", "lift", "program")
    samples = f"{CASES.parents[1] / 'sample_meshes'}/"
    for name in names:
        text = (CASES / f"{name}.toml").read_text().replace("../../sample_meshes/", samples)
        (folder / f"{name}.toml").write_text(text)
    shutil.copy(CASES / "program.py", folder)
    lines = [json.dumps(line) for line in (GOOD, GOOD, END)]
    (folder / "study.jsonl").write_text("\n".join([*lines, ""]))
    Remembered(Known(), folder / "known").answer(Request(POINTS))
    shutil.copy(next((folder / "known").glob("*.npz")), folder / "known.npz")
    shutil.rmtree(folder / "known")
    return [
        *(Subject(folder / f"{name}.toml", case) for name in names),
        Subject(folder / "study.jsonl", log),
        Subject(folder / "known.npz", evaluation),
    ]


def refused(work: Work, path: Path) -> str:
    """The sentence with which a file is refused; empty if it is not."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            work(path)
    except InputError as error:
        sentence(str(error))
        return str(error)
    return ""


FOR_SUFFIX: dict[str, Work] = {
    ".ffdproj": project, ".toml": case, ".jsonl": journal, ".npz": evaluation, ".log": log,
    ".g2": lattice, ".prm": lattice, ".cfg": lattice, ".json": lattice,
}  # fmt: skip


def work_for(path: Path) -> Work:
    """What opens a file of the corpus."""
    if path.name.startswith("box"):
        return lattice
    return FOR_SUFFIX.get(path.suffix, mesh)
