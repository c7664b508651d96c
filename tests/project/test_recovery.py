"""What a crash leaves, and how it is found."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ffdstudio.project import Project
from ffdstudio.project import commands as c
from ffdstudio.project.autosave import Autosave
from ffdstudio.project.document import Document
from ffdstudio.project.files.recovery import Session, left_behind
from ffdstudio.project.files.replaying import replay
from tests.project.scenes import BOX, opened, write_cube

DIES = """
import os, sys
from pathlib import Path
from ffdstudio.project.files.recovery import Session
from ffdstudio.project.document import Document
from tests.project.scenes import BOX, opened

document = opened(Path(sys.argv[1]), BOX)
session = Session(Path(sys.argv[2]))
session.write(document.snapshot(), document.journal.copy(), Path("/work/wing.ffdproj"))
document.edit([(1, 1, 1)]).translate([1, 0, 0])
session.write(document.snapshot(), document.journal.copy(), Path("/work/wing.ffdproj"))
print("ready", flush=True)
sys.stdin.read()
"""


def test_a_killed_session_is_found_and_restored(tmp_path: Path, root: Path) -> None:
    mesh, folder = write_cube(tmp_path / "cube.su2"), tmp_path / "recovery"
    process = subprocess.Popen(
        [sys.executable, "-c", DIES, str(mesh), str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=root,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    assert left_behind(folder) == []  # it is alive
    os.kill(process.pid, signal.SIGKILL if sys.platform != "win32" else signal.SIGTERM)
    process.communicate()
    [left] = left_behind(folder)
    assert left.project == Path("/work/wing.ffdproj")
    document = Document()
    document.recover(left)
    assert document.path == left.project
    assert document.modified
    assert document.model.bodies[0].path == mesh
    assert not document.model.lattices[0].deformed  # a drag under way was not an edit yet
    assert left.journal.exists()
    left.discard()
    assert left_behind(folder) == []


SAVES = """
import sys
import time
from pathlib import Path
from ffdstudio.project import commands as c
from ffdstudio.project.files.recovery import Session
from tests.project.scenes import BOX, opened

document = opened(Path(sys.argv[1]), BOX)
session = Session(Path(sys.argv[2]))
for number in range(10**6):
    document.do(c.Rename("body1", f"wing {number}"))
    document.save(Path(sys.argv[3]))
    session.write(document.snapshot(), document.journal.copy(), document.path)
    print(number, flush=True)
"""


@pytest.mark.parametrize("saves", [1, 3, 6])
def test_a_process_killed_while_it_saves_loses_at_most_that_save(
    tmp_path: Path, root: Path, saves: int
) -> None:
    mesh, target = write_cube(tmp_path / "cube.su2"), tmp_path / "a.ffdproj"
    process = subprocess.Popen(
        [sys.executable, "-c", SAVES, str(mesh), str(tmp_path / "recovery"), str(target)],
        stdout=subprocess.PIPE,
        cwd=root,
        text=True,
    )
    assert process.stdout is not None
    last = [process.stdout.readline() for _ in range(saves)][-1]
    time.sleep(0.003 * saves)  # somewhere inside the next ones
    process.kill()
    process.communicate()
    left = left_behind(tmp_path / "recovery")[0]
    for path in (target, left.autosave):
        name = Project.open(path).bodies[0].name
        assert int(name.removeprefix("wing ")) >= int(last)
    assert replay(left.journal).bodies[0].name.startswith("wing")


def test_a_session_that_ends_properly_leaves_nothing(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"), BOX)
    session = Session(tmp_path / "recovery")
    session.write(document.snapshot(), document.journal, None)
    session.close()
    session.close()
    session.write(document.snapshot(), document.journal, None)  # a worker that comes late
    assert left_behind(tmp_path / "recovery") == []
    assert not list((tmp_path / "recovery").iterdir())


def test_what_is_saved_is_forgotten(tmp_path: Path) -> None:
    session = Session(tmp_path / "recovery")
    session.write(Document().snapshot(), Document().journal, None)
    session.forget()
    session._lock.close()  # type: ignore[union-attr] # as death would
    assert left_behind(tmp_path / "recovery") == []


def test_the_newest_comes_first_and_damaged_notes_do_no_harm(tmp_path: Path) -> None:
    sessions = [Session(tmp_path / "recovery") for _ in range(3)]
    for session in sessions:
        session.write(Document().snapshot(), Document().journal, None)
    (sessions[0].folder / "session.json").write_text("{broken")
    for session in sessions:
        session._lock.close()  # type: ignore[union-attr]
    found = [left.folder for left in left_behind(tmp_path / "recovery")]
    assert set(found) == {session.folder for session in sessions}
    assert found.index(sessions[2].folder) < found.index(sessions[1].folder)


def test_no_folder_is_no_crash(tmp_path: Path) -> None:
    assert left_behind(tmp_path / "none") == []


def test_an_edit_after_recovery_still_undoes(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"), BOX)
    session = Session(tmp_path / "recovery")
    session.write(document.snapshot(), document.journal, None)
    session._lock.close()  # type: ignore[union-attr]
    again = Document()
    again.recover(left_behind(tmp_path / "recovery")[0])
    again.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    again.undo()
    assert not again.model.lattices[0].deformed


def test_autosaves_follow_edits_and_end_with_a_save(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"))
    autosave = Autosave(document, tmp_path / "recovery")
    [place] = (tmp_path / "recovery").iterdir()
    saved = place / "autosave.ffdproj"
    autosave.tick()
    assert not saved.exists()  # nothing new since it began
    document.do(BOX)
    autosave.tick()
    assert len(Project.open(saved).lattices) == 1
    first = saved.read_bytes()
    document.edit([(1, 1, 1)]).translate([1, 0, 0])
    autosave.tick()
    assert saved.read_bytes() == first  # a drag is no edit yet
    document.editing.commit()  # type: ignore[union-attr]
    autosave.tick()
    assert saved.read_bytes() != first
    document.save(tmp_path / "a.ffdproj")
    document.do(c.Rename("body1", "wing"))
    document.undo()
    autosave.tick()
    document.do(c.Rename("body1", "wing"))
    document.save()
    autosave.tick()
    assert not saved.exists()
    autosave.close()
    assert not place.exists()


def test_without_a_folder_there_are_no_autosaves_but_a_problem(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    document, problems = Document(), []
    document.problem.connect(lambda title, cause: problems.append(cause))
    autosave = Autosave(document, tmp_path / "file")
    document.do(BOX)
    autosave.tick()
    autosave.close()
    assert len(problems) == 1
