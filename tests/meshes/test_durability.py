"""A full disk, a failing one and a process killed at any moment leave every mesh old or new."""

from __future__ import annotations

import errno
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import Mesh
from tests.faults import DEATH, Disk, assert_sentences, die_in, tree, without_litter
from tests.meshes.specimens import SPECIMENS
from tests.meshes.test_nastran import DECK
from tests.meshes.test_openfoam import CASES, make

pytestmark = pytest.mark.filterwarnings("ignore::ffdstudio.meshes.MeshWarning")
NAMES = ("raw.vtu", "inline_packed.vtu", "v41_binary.msh", "plain.cgns", "packed.cgns")
NAMES += ("classic.exo", "packed.exo", "new_binary.vtk", "binary.stl", "a.lb8.ugrid")
CASE_NAMES = {"case": "ascii", "packed_case": "binary.gz"}
CONVERTED = ("new.su2", "new.vtu", "new.inp", "new.msh", "new.stl", "new.ply", "new.obj")
ALL = (*NAMES, *CASE_NAMES, "deck/main.bdf", *CONVERTED)


@dataclass
class Export:
    """A mesh, where it is written, and the files that its two shapes give there."""

    mesh: Mesh
    path: Path
    shapes: tuple[np.ndarray, np.ndarray]
    trees: list[dict[str, bytes]]

    def write(self, number: int) -> None:
        write_mesh(self.mesh, self.path, self.shapes[number])

    def check(self) -> int:
        """Which shape is there; whatever else there is fails the test."""
        found = without_litter(tree(self.path.parent))
        assert found in self.trees, f"{self.path.name} is neither old nor new"
        return self.trees.index(found)


def source(folder: Path, name: str) -> Path:
    """File of a mesh; the new formats are made from a VTU."""
    if name in CASE_NAMES:
        return make(folder / name, **CASES[CASE_NAMES[name]])
    if name == "deck/main.bdf":
        (folder / "parts").mkdir()
        (folder / "parts" / "nodes.bdf").write_text(DECK)
        (folder / "parts" / "more.bdf").write_text("GRID,11,,5.,1.,1.\n")
        main = "INCLUDE 'parts/nodes.bdf'\nINCLUDE 'parts/more.bdf'\nGRID,9,,1.,1.,1.\n"
        (folder / "main.bdf").write_text("BEGIN BULK\n" + main)
        return folder / "main.bdf"
    made = name if name in NAMES else "raw.vtu"
    SPECIMENS[made](folder / made)
    return folder / made


def assert_reads(path: Path, points: np.ndarray) -> None:
    """Check that a mesh has these points, or some of them where only its surface is written."""
    from scipy.spatial import cKDTree

    distances, _ = cKDTree(points).query(read_mesh(path).points)
    assert 0 < len(distances) <= len(points) + 4 * (path.suffix == ".stl")
    assert distances.max() < 1e-6


@pytest.fixture(scope="module")
def export(tmp_path_factory) -> Callable[[str], Export]:
    known: dict[str, Export] = {}

    def of(name: str) -> Export:
        if name not in known:
            folder = tmp_path_factory.mktemp("source")
            mesh = read_mesh(source(folder, name))
            random = np.random.default_rng(1)
            shapes = [mesh.points + random.random(3) / 8 for _ in range(2)]
            out = tmp_path_factory.mktemp("out") / name.rpartition("/")[2]
            known[name] = Export(mesh, out, (shapes[0], shapes[1]), [])
            for number, points in enumerate(shapes):
                known[name].write(number)
                assert_reads(out, points)
                known[name].trees.append(tree(out.parent))
            assert known[name].trees[0] != known[name].trees[1]
        known[name].write(0)
        return known[name]

    return of


@pytest.mark.parametrize("fault", [errno.EIO, errno.ENOSPC], ids=["EIO", "ENOSPC"])
@pytest.mark.parametrize("name", ALL)
def test_a_disk_that_goes_wrong_at_any_call_leaves_the_old_mesh(export, name, fault):
    work = export(name)
    dry = Disk()
    with dry.in_place():
        work.write(1)
    assert {"create", "write", "fsync", "replace"} <= set(dry.calls)
    said: list[str] = []
    for at in range(len(dry.calls)):
        work.write(0)
        disk = Disk(fault, at)
        try:
            with disk.in_place():
                work.write(1)
        except InputError as error:
            said.append(str(error))
            assert work.check() == 0
        else:  # the call did not matter, or the disk filled up after the last that needs space
            assert work.check() == 1
        assert tree(work.path.parent) == without_litter(tree(work.path.parent))
    assert_sentences(said, fault)


@pytest.mark.parametrize("name", ["raw.vtu", "case", "packed.cgns", "new.msh"])
def test_a_process_that_dies_at_any_call_leaves_the_old_mesh_or_the_new(export, name):
    work = export(name)
    dry = Disk()
    with dry.in_place():
        work.write(1)

    def write(at: int) -> None:
        with Disk(DEATH, at).in_place():
            work.write(1)

    for at in range(len(dry.calls)):
        work.write(0)
        die_in(partial(write, at))
        work.check()
        work.write(1)
        assert work.check() == 1


def survive(works: list[Export], kills: int, seed: int) -> dict[str, int]:
    """Kill a process that writes all meshes, old and new in turn; count what it left."""
    random = np.random.default_rng(seed)

    def cycle() -> None:
        for number in (1, 0):
            for work in works:
                work.write(number)

    def forever() -> None:
        while True:
            cycle()

    begin = time.perf_counter()
    cycle()
    length = time.perf_counter() - begin
    counts = {"kills": kills, "inside a write": 0, "mixed": 0}
    for _ in range(kills):
        before = sum(len(tree(work.path.parent)) for work in works)
        die_in(forever, length * random.random())
        after = sum(len(tree(work.path.parent)) for work in works)
        counts["inside a write"] += after > before
        states = [work.check() for work in works]
        counts["mixed"] += len(set(states)) == 2
        chosen = random.integers(len(works))
        assert_reads(works[chosen].path, works[chosen].shapes[states[chosen]])
    for work in works:  # among all the litter of the dead
        work.write(0)
        assert work.check() == 0
    return counts


@pytest.mark.parametrize("kills", [10, pytest.param(200, marks=pytest.mark.campaign)])
def test_a_process_killed_at_random_moments_leaves_old_or_new_meshes(export, kills):
    names = ("new.su2", "raw.vtu", "v41_binary.msh", "case", "packed_case")
    works = [export(name) for name in (*names, "plain.cgns", "packed.cgns", "packed.exo")]
    counts = survive(works, kills, seed=kills)
    print(counts)  # shown with -s
    assert counts["mixed"]  # the moments were inside the work


def test_a_case_that_holds_another_mesh_is_not_overwritten(tmp_path):
    mesh = read_mesh(make(tmp_path / "a", **CASES["ascii"]))
    other = make(tmp_path / "b", **CASES["ascii"])
    owner = other / "constant" / "polyMesh" / "owner"
    owner.write_bytes(owner.read_bytes().replace(b"(0 ", b"(1 ", 1))
    before = tree(other)
    with pytest.raises(InputError, match=r"holds another mesh \(owner\): choose another folder"):
        write_mesh(mesh, other, mesh.points + 1)
    assert tree(other) == before


@pytest.mark.parametrize(("first", "second"), [("ascii.gz", "ascii"), ("ascii", "ascii.gz")])
def test_a_case_written_over_its_packed_twin_shows_the_new_points(tmp_path, first, second):
    out = make(tmp_path / "a", **CASES[first])
    mesh = read_mesh(make(tmp_path / "b", **CASES[second]))
    write_mesh(mesh, out, mesh.points + 0.25)
    assert (read_mesh(out).points == mesh.points + 0.25).all()
    assert len(list((out / "constant" / "polyMesh").glob("points*"))) == 1
