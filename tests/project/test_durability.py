"""A full disk, a failing one and a process killed at any moment leave every project old or new."""

from __future__ import annotations

import errno
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from ffdstudio.project import Project
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.files.exporting import write_body
from ffdstudio.project.files.model_codec import to_file
from ffdstudio.project.files.replaying import replay
from tests.faults import DEATH, Disk, assert_sentences, die_in, tree, without_litter
from tests.project.scenes import BOX, opened, write_cube

SHIFTS = (0.125, 0.25)


class Work:
    """A project with its journal and the mesh it deforms, to be written in two states."""

    def __init__(self, folder: Path, packed: bool = True) -> None:
        mesh = write_cube(folder / "cube.su2")
        self.target, self.packed = folder / "out", packed
        self.target.mkdir()
        self.states = [self._state(mesh, shift) for shift in SHIFTS]

    @staticmethod
    def _state(mesh: Path, shift: float) -> Document:
        document = opened(mesh, BOX)
        document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.3, 0.3, shift),)))
        return document

    def save(self, number: int) -> None:
        document = self.states[number]
        content = to_file(document.settled_model, document.sections)
        Project(content).save(self.target / "a.ffdproj", pack_meshes=self.packed)

    def write_journal(self, number: int) -> None:
        self.states[number].journal.save(self.target / "a.jsonl")

    def export(self, number: int) -> None:
        model = self.states[number].settled_model
        write_body(model.bodies[0], model.steps, self.target / "cube.su2")

    def write(self, number: int) -> None:
        for part in (self.save, self.write_journal, self.export):
            part(number)

    def read(self) -> list[int]:
        """Which state project, journal and mesh are in; damage fails the test."""
        project = Project.open(self.target / "a.ffdproj")
        assert project.problems == []
        assert len(project.mesh(project.bodies[0].name).points) == 64
        replayed = replay(self.target / "a.jsonl")
        nets = [project.lattices[0].current, replayed.lattices[0].current]
        found = [SHIFTS.index(net.control_points[1, 1, 1, 2]) for net in nets]
        points = read_mesh(self.target / "cube.su2").points
        shapes = [np.array_equal(points, self.exported[k]) for k in (0, 1)]
        return [*found, shapes.index(True)]

    def prepare(self) -> None:
        """Remember what is exported; leave the first state."""
        self.exported = []
        for number in (1, 0):
            self.write(number)
            self.exported.insert(0, read_mesh(self.target / "cube.su2").points)
            assert not np.array_equal(self.exported[0], read_mesh(self.target.parent / "cube.su2"))


@pytest.fixture
def work(tmp_path) -> Work:
    made = Work(tmp_path)
    made.prepare()
    return made


@pytest.mark.parametrize("fault", [errno.EIO, errno.ENOSPC], ids=["EIO", "ENOSPC"])
@pytest.mark.parametrize("part", [0, 1, 2], ids=["project", "journal", "mesh"])
def test_a_disk_that_goes_wrong_at_any_call_leaves_the_old_file(work, part, fault):
    run = (work.save, work.write_journal, work.export)[part]
    dry = Disk()
    with dry.in_place():
        run(1)
    assert {"create", "write", "fsync", "replace"} <= set(dry.calls)
    said: list[str] = []
    for at in range(len(dry.calls)):
        run(0)
        expected = [0, 0, 0]
        try:
            with Disk(fault, at).in_place():
                run(1)
        except InputError as error:
            said.append(str(error))
        else:  # only the flush of the folder after the rename does not matter
            expected[part] = 1
        assert work.read() == expected
        assert sorted(tree(work.target)) == ["a.ffdproj", "a.jsonl", "cube.su2"]
    assert_sentences(said, fault)


def test_a_process_that_dies_at_any_call_leaves_the_old_project_or_the_new(work):
    dry = Disk()
    with dry.in_place():
        work.write(1)

    def write(at: int) -> None:
        with Disk(DEATH, at).in_place():
            work.write(1)

    for at in range(len(dry.calls)):
        work.write(0)
        die_in(partial(write, at))
        found = work.read()
        assert found == sorted(found, reverse=True)  # what is written first is new first
        work.write(1)
        assert work.read() == [1, 1, 1]


@pytest.mark.parametrize("kills", [10, pytest.param(200, marks=pytest.mark.campaign)])
def test_a_process_killed_at_random_moments_leaves_old_or_new_files(work, kills):
    random = np.random.default_rng(kills)

    def forever() -> None:
        while True:
            work.write(1)
            work.write(0)

    begin = time.perf_counter()
    work.write(1), work.write(0)
    length = time.perf_counter() - begin
    counts = {"kills": kills, "inside a write": 0, "mixed": 0}
    for _ in range(kills):
        before = len(tree(work.target))
        die_in(forever, length * random.random())
        counts["inside a write"] += len(tree(work.target)) > before
        counts["mixed"] += len(set(work.read())) == 2
    work.write(1)  # among all the litter of the dead
    assert work.read() == [1, 1, 1]
    assert sorted(without_litter(tree(work.target))) == ["a.ffdproj", "a.jsonl", "cube.su2"]
    print(counts)  # shown with -s


def test_what_a_crash_left_in_a_case_does_not_change_the_mesh(tmp_path):
    case = tmp_path / "case" / "constant" / "polyMesh"
    case.mkdir(parents=True)
    for name in ("points", "faces"):
        (case / name).write_text(name)
    project = Project()
    project.add_mesh(tmp_path / "case")
    project.save(tmp_path / "a.ffdproj")
    (case / ".points.0123abcd").write_text("half of")
    assert Project.open(tmp_path / "a.ffdproj").problems == []


@pytest.mark.parametrize("fault", [errno.EIO, errno.ENOSPC], ids=["EIO", "ENOSPC"])
def test_no_room_to_lay_out_a_packed_mesh_is_said(work, fault):
    project = Project.open(work.target / "a.ffdproj")
    name, dry = project.bodies[0].name, Disk()
    with dry.in_place():
        project.mesh(name)
    said: list[str] = []
    for at in range(len(dry.calls)):
        try:
            with Disk(fault, at).in_place():
                points = project.mesh(name).points
        except InputError as error:
            said.append(str(error))
        else:  # it was to make a folder that is there already
            assert len(points) == 64
    assert_sentences(said, fault)
