"""After a power loss at any moment every file is whole: the old one or the new one."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import Lattice, read_mesh, write_mesh
from ffdstudio.exchange import write_lattice
from ffdstudio.files import remove, together, write_bytes
from ffdstudio.project import commands as c
from tests.powerloss import Disk
from tests.project.scenes import BOX, opened, write_cube


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "disk"
    place.mkdir()
    write_cube(place / "cube.su2")
    return place


def one(folder):
    write_bytes(folder / "a.bin", b"old" * 1000)
    return lambda: write_bytes(folder / "a.bin", b"new" * 2000)


def three(folder):
    for name in "abc":
        write_bytes(folder / name, b"old" + name.encode())

    def act():
        with together():
            write_bytes(folder / "a", b"new a")
            write_bytes(folder / "b", b"new b")
            remove(folder / "c")

    return act


def project(folder):
    document = opened(folder / "cube.su2", BOX)
    document.save(folder / "a.ffdproj")

    def act():
        document.do(c.Rename("lattice2", "other"))
        document.save()
        document.journal.save(folder / "a.jsonl")

    return act


def mesh(folder):
    read = read_mesh(folder / "cube.su2")
    shutil.copy(folder / "cube.su2", folder / "out.su2")
    return lambda: write_mesh(read, folder / "out.su2", read.points + 0.5)


def lattice(folder):
    box = Lattice.box([0, 0, 0], [1, 1, 1], (3, 3, 3))
    write_lattice(folder / "a.lattice.json", box)
    return lambda: write_lattice(folder / "a.lattice.json", box.moved(box.control_points + 1))


def found(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def torn(folder: Path, act, flushes: bool = True) -> list[str]:
    """Names of files that some power loss leaves neither old nor new."""
    disk, before = Disk(folder), found(folder)
    disk.flushes = flushes
    with disk.in_place():
        act()
    after = found(folder)
    bad = []
    for state in disk.losses(np.random.default_rng(1), 12):
        for name in before.keys() | after.keys():
            allowed = [files[name] for files in (before, after) if name in files]
            may_lack = name not in before or name not in after
            if (name in state and state[name] not in allowed) or (
                name not in state and not may_lack
            ):
                bad.append(name)
    return bad


ACTIONS = [one, three, project, mesh, lattice]


@pytest.mark.parametrize("action", ACTIONS)
def test_a_power_loss_leaves_every_file_old_or_new(folder, action):
    assert torn(folder, action(folder)) == []


@pytest.mark.parametrize("action", ACTIONS)
def test_the_net_catches_a_write_that_was_not_flushed(folder, action):
    assert torn(folder, action(folder), flushes=False)


def test_the_net_catches_a_write_in_place(folder):
    (folder / "a").write_bytes(b"old")

    def act():
        with (folder / "a").open("wb") as stream:
            stream.write(b"ne")
            stream.flush()
            os.fsync(stream.fileno())
            stream.write(b"w")

    assert "a" in torn(folder, act)


def test_what_is_done_is_durable(folder):
    """Once a write has returned, no power loss takes it back."""
    act = one(folder)
    disk = Disk(folder)
    with disk.in_place():
        act()
    disk.moments = disk.moments[-1:]
    assert all(s["a.bin"] == b"new" * 2000 for s in disk.losses(np.random.default_rng(1), 12))
