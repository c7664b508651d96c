"""Opening, saving and exporting; what is missing, changed or cannot be written is told."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.exchange import read_lattice_file
from ffdstudio.meshes import read_mesh
from ffdstudio.project import Project
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.files.records import ProjectFile
from ffdstudio.project.running import no_progress
from tests.project.scenes import BOX, opened, write_cube, write_square

BEND = c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),))


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    return write_cube(tmp_path / "cube.su2")


def told(document: Document) -> list[str]:
    """Problems from now on."""
    problems: list[str] = []
    document.problem.connect(lambda title, cause: problems.append(f"{title}: {cause}"))
    return problems


def test_everything_comes_back_from_a_project(cube: Path, tmp_path: Path) -> None:
    document = opened(cube, BOX)
    for command in (
        BEND,
        c.SaveShape("lattice2", "bent"),
        c.SetWeights("lattice2", ((1, 2, 2),), (3.0,)),
        c.FreezeLayers("lattice2", 1),
        c.Show(("lattice2",), False),
        c.Colour("body1", "#123456"),
        c.ShowMarkers("body1", ("low",), False),
        c.CreateBox("Other", (0.0,) * 3, (1.0,) * 3, (3, 3, 3), (2, 2, 2)),
        c.Enable("lattice3", False),
        c.Activate("lattice2"),
    ):
        document.do(command)
    document.sections["studies"] = {"one": np.arange(3)}
    assert document.modified
    document.save(tmp_path / "a.ffdproj")
    assert not document.modified
    again = Document()
    assert told(again) == []
    again.open(tmp_path / "a.ffdproj")
    old, new = document.model, again.model
    assert [vars(i).keys() for i in new.lattices] == [vars(i).keys() for i in old.lattices]
    for a, b in zip(old.lattices, new.lattices, strict=True):
        assert (a.key, a.name, a.frozen, a.visible, a.enabled) == (
            b.key,
            b.name,
            b.frozen,
            b.visible,
            b.enabled,
        )
        assert (a.rest, a.current, dict(a.shapes)) == (b.rest, b.current, dict(b.shapes))
    body = new.bodies[0]
    assert (body.name, body.colour, body.hidden_markers) == ("cube", "#123456", {"low"})
    assert new.active == "lattice2"
    assert again.sections["studies"]["one"].tolist() == [0, 1, 2]
    assert again.points("body1").tobytes() == document.points("body1").tobytes()
    assert not again.modified
    assert again.history.labels == []


def test_the_project_of_the_window_is_that_of_scripts(cube: Path, tmp_path: Path) -> None:
    document = opened(cube, BOX)
    document.do(BEND)
    document.save(tmp_path / "a.ffdproj")
    project = Project.open(tmp_path / "a.ffdproj")
    assert project.lattices[0].current == document.model.lattices[0].current
    assert len(project.mesh("cube").points) == 64


def test_undo_back_to_what_was_saved_is_not_modified(cube: Path, tmp_path: Path) -> None:
    document = opened(cube, BOX)
    document.save(tmp_path / "a.ffdproj")
    document.do(BEND)
    assert document.modified
    document.undo()
    assert not document.modified


def test_saving_needs_a_file_once(cube: Path, tmp_path: Path) -> None:
    document = opened(cube)
    with pytest.raises(InputError, match="no file"):
        document.save()
    document.save(tmp_path / "a.ffdproj")
    document.do(BOX)
    document.save()
    assert len(Project.open(tmp_path / "a.ffdproj").lattices) == 1


def test_what_cannot_be_read_or_written_is_a_problem_and_changes_nothing(
    cube: Path, tmp_path: Path
) -> None:
    document = Document()
    document.open_mesh(cube)
    problems, model = told(document), document.model
    document.open_mesh(tmp_path / "none.su2")
    document.open(cube)
    document.save(tmp_path / "none" / "a.ffdproj")
    document.export_mesh("body1", tmp_path / "none" / "a.su2")
    document.import_lattice(cube)
    document.do(BOX)
    document.export_lattice("lattice2", tmp_path / "none" / "a.lattice.json")
    assert len(problems) == 6
    assert all("none" in text or "cube.su2" in text for text in problems)
    assert document.model.bodies == model.bodies
    assert document.modified


def test_a_missing_mesh_is_asked_for(cube: Path, tmp_path: Path) -> None:
    opened(cube, BOX).save(tmp_path / "a.ffdproj")
    moved = cube.rename(tmp_path / "moved.su2")
    document, asked = Document(), []

    def ask(content: ProjectFile) -> ProjectFile:
        asked.extend(content.problems)
        content.bodies[0].path = moved
        return content

    document.ask = ask
    document.open(tmp_path / "a.ffdproj")
    assert "missing" in asked[0]
    assert document.model.bodies[0].path == moved
    assert document.path == tmp_path / "a.ffdproj"


def test_giving_up_leaves_everything_as_it_was(cube: Path, tmp_path: Path) -> None:
    opened(cube, BOX).save(tmp_path / "a.ffdproj")
    cube.unlink()
    document = Document()
    document.ask = lambda content: None
    document.open(tmp_path / "a.ffdproj")
    assert document.path is None
    assert not document.model.lattices


def test_a_mesh_nobody_finds_is_left_out_and_told(cube: Path, tmp_path: Path) -> None:
    opened(cube, BOX).save(tmp_path / "a.ffdproj")
    cube.unlink()
    document = Document()
    problems = told(document)
    document.open(tmp_path / "a.ffdproj")
    assert not document.model.bodies
    assert len(document.model.lattices) == 1
    assert any("cube.su2" in text for text in problems)


def test_a_changed_mesh_is_told_and_taken_as_it_is(cube: Path, tmp_path: Path) -> None:
    opened(cube, BOX).save(tmp_path / "a.ffdproj")
    write_cube(cube, n=4)
    document = Document()
    problems = told(document)
    document.open(tmp_path / "a.ffdproj")
    assert any("changed" in text for text in problems)
    assert len(document.model.bodies[0].mesh.points) == 125


def test_packed_meshes_travel_in_the_project(cube: Path, tmp_path: Path) -> None:
    document = opened(cube, BOX)
    document.do(BEND)
    document.save(tmp_path / "a.ffdproj", pack_meshes=True)
    document.do(c.Rename("body1", "wing"))
    document.save()  # packed as before
    cube.unlink()
    again = opened_project(tmp_path / "a.ffdproj")
    again.save(tmp_path / "b.ffdproj")
    third = opened_project(tmp_path / "b.ffdproj")
    assert third.points("body1").tobytes() == document.points("body1").tobytes()
    third.export_mesh("body1", tmp_path / "out.su2")
    assert len(read_mesh(tmp_path / "out.su2").points) == 64


def opened_project(path: Path) -> Document:
    document = Document()
    problems = told(document)
    document.open(path)
    assert problems == []
    return document


def test_an_undeformed_mesh_is_exported_as_the_very_file(cube: Path, tmp_path: Path) -> None:
    document = opened(cube, BOX)
    document.export_mesh("body1", tmp_path / "out.su2")
    assert (tmp_path / "out.su2").read_bytes() == cube.read_bytes()


def test_losses_of_an_export_are_told(cube: Path, tmp_path: Path) -> None:
    document = Document()
    document.open_mesh(cube)
    problems = told(document)
    document.export_mesh("body1", tmp_path / "out.vtu")
    assert any("loss" in text for text in problems)


def test_a_plane_mesh_cannot_be_exported_out_of_its_plane(tmp_path: Path) -> None:
    box = c.CreateBox("Box", (-0.1,) * 3, (1.1,) * 3, (4, 4, 2), (3, 3, 1))
    document = opened(write_square(tmp_path / "square.su2"))
    document = Document()
    document.open_mesh(tmp_path / "square.su2")
    document.do(box)
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.3, 0.3, 2.0),)))
    problems = told(document)
    document.export_mesh("body1", tmp_path / "out.su2")
    assert "moves it in z" in problems[0]


def test_lattices_go_out_and_come_in(cube: Path, tmp_path: Path) -> None:
    document = opened(cube, BOX)
    document.do(BEND)
    document.do(c.FreezeLayers("lattice2", 1))
    document.export_lattice("lattice2", tmp_path / "my.lattice.json")
    assert read_lattice_file(tmp_path / "my.lattice.json").frozen == 1
    document.import_lattice(tmp_path / "my.lattice.json")
    new = document.model.lattices[1]
    assert (new.name, new.frozen) == ("my", 1)
    assert new.current == document.model.lattices[0].current


class Threads:
    """A runner that works in threads and delivers when the test says so, the last first."""

    def __init__(self) -> None:
        self.jobs: list = []

    def start(self, label, work, done, failed=None, key="", cancelled=None, line=""):  # type: ignore[no-untyped-def]
        box: list = []
        thread = threading.Thread(target=lambda: box.append(work(no_progress)))
        self.jobs.append((thread, box, done))

    def run(self) -> None:
        jobs, self.jobs = self.jobs[::-1], []
        for thread, _, _ in jobs:
            thread.start()
            thread.join()
        for _, box, done in jobs:
            done(box[0])


def test_an_older_save_never_replaces_a_newer_one(cube: Path, tmp_path: Path) -> None:
    runner = Threads()
    document = opened(cube)
    document.runner = runner
    document.save(tmp_path / "a.ffdproj")
    document.do(BOX)
    document.save(tmp_path / "a.ffdproj")
    runner.run()
    assert len(Project.open(tmp_path / "a.ffdproj").lattices) == 1
    assert not document.modified


@pytest.mark.parametrize("edited", [False, True])
@pytest.mark.parametrize("may", [False, True])
def test_what_was_done_while_a_project_was_read_is_asked_about(
    cube: Path, tmp_path: Path, edited: bool, may: bool
) -> None:
    document, asked = opened(cube, BOX), []
    document.save(tmp_path / "a.ffdproj")
    document.may_replace = lambda: asked.append(True) or may  # type: ignore[func-returns-value]
    runner = document.runner = Threads()
    document.open(tmp_path / "a.ffdproj")
    runner.run()  # its meshes are read next
    if edited:
        document.do(c.Rename("body1", "block"))
    edits = document.settled_model
    while runner.jobs:
        runner.run()
    assert bool(asked) is edited
    assert (document.settled_model is edits) is (edited and not may)


def test_a_new_project_is_empty_and_not_modified(cube: Path) -> None:
    document = opened(cube, BOX)
    document.clear()
    assert not document.model.bodies
    assert not document.modified
    assert document.journal.steps == []


def test_only_what_was_read_or_saved_is_filed(cube: Path, tmp_path: Path) -> None:
    document, filed = Document(), []
    document.filed.connect(filed.append)
    (tmp_path / "broken.su2").write_text("NDIME= 3\n")
    document.open_mesh(tmp_path / "broken.su2")
    document.save(tmp_path / "no folder" / "a.ffdproj")
    assert filed == []
    document.open_mesh(cube)
    document.save(tmp_path / "a.ffdproj")
    document.open(tmp_path / "a.ffdproj")
    assert filed == [cube, tmp_path / "a.ffdproj", tmp_path / "a.ffdproj"]


# ---- two windows on one project ----------------------------------------------------------------


@pytest.fixture
def two(cube: Path, tmp_path: Path) -> tuple[Document, Document]:
    """Two documents that have opened the same project."""
    first, second = opened(cube, BOX), Document()
    first.save(tmp_path / "a.ffdproj")
    second.open(tmp_path / "a.ffdproj")
    return first, second


def test_what_another_window_saved_is_not_replaced_unasked(
    two: tuple[Document, Document], tmp_path: Path
) -> None:
    first, second = two
    first.do(BEND)
    first.save()
    theirs = (tmp_path / "a.ffdproj").read_bytes()
    problems = told(second)
    second.do(c.Rename("lattice2", "mine"))
    second.save()
    assert (tmp_path / "a.ffdproj").read_bytes() == theirs
    assert second.modified
    assert len(problems) == 1
    assert "has been changed by another program" in problems[0]
    second.save(tmp_path / "b.ffdproj")
    assert not second.modified
    first.do(c.Rename("lattice2", "again"))
    first.save()  # nobody else was there
    assert not first.modified


@pytest.mark.parametrize("answer", [True, False])
def test_whoever_may_overwrite_is_asked_once(
    two: tuple[Document, Document], tmp_path: Path, answer: bool
) -> None:
    first, second = two
    first.do(BEND)
    first.save()
    asked: list[Path] = []
    second.may_overwrite = lambda path: bool(asked.append(path) or answer)
    second.do(c.Rename("lattice2", "mine"))
    second.save()
    assert asked == [tmp_path / "a.ffdproj"]
    assert second.modified is not answer
    names = [record.name for record in Project.open(tmp_path / "a.ffdproj").lattices]
    assert (names == ["mine"]) is answer
    second.do(c.Rename("lattice2", "more"))
    second.save()
    assert len(asked) == (1 if answer else 2)


def test_a_file_written_between_two_saves_is_noticed_and_a_removed_one_written_anew(
    two: tuple[Document, Document], tmp_path: Path
) -> None:
    _, first = two
    problems = told(first)
    path = tmp_path / "a.ffdproj"
    path.write_bytes(path.read_bytes())  # the same content, by somebody else
    first.save()
    assert len(problems) == 1
    path.unlink()
    first.save()
    assert path.exists()
    assert len(problems) == 1
