"""The journal: readable, bit exact, refused where it is wrong, and replayed to the same bytes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.cli.main import main
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange import read_lattice, write_lattice
from ffdstudio.optimize.constraints.thickness import MaxThicknessLimit
from ffdstudio.optimize.objectives.contour import ContourSpec
from ffdstudio.optimize.spec.parts import LatticeSpec, ShapeSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.files.command_codec import to_command, to_words
from ffdstudio.project.files.journal import Journal, commands_of, read_journal
from ffdstudio.project.files.replaying import export, replay
from tests.project.scenes import BOX, opened, write_cube

BENT = BOX.lattice.moved(BOX.lattice.control_points * 1.1, BOX.lattice.weights * 0.7)
STUDY = StudySpec(
    shape=ShapeSpec(source="<body1>", marker="foil", points=301),
    lattice=LatticeSpec(file="<lattice2>"),
    objective=ContourSpec(target="rae2822.dat", unit="tolerance"),
    constraints=(MaxThicknessLimit(lower=0.1 + 0.2),),
)
EVERY = [
    c.OpenMesh("/a/b.su2", "ab12", "wing", False, "#aabbcc", ("low", "high"), "strip"),
    BOX,
    c.CreateBox(
        "Turned", (0.0,) * 3, (1.0,) * 3, (3, 3), (2, 2), ((0.6, 0.8, 0.0), (-0.8, 0.6, 0.0))
    ),
    c.Refit("lattice2", BOX),
    c.AddLattice("x", BOX.lattice, BENT, 1, False, False, (("a", BENT),), ((1, 0),)),
    c.CreateBox("Open", (0.0,) * 3, (1.0,) * 3, (4, 3), (2, 2), frozen=1, open_faces=((0, 1),)),
    c.Remove("lattice2"),
    c.Rename("body1", "Flügel »1«"),
    c.Show(("body1", "lattice2"), False),
    c.Isolate("body1"),
    c.IsolateMarker("body1", "low"),
    c.ShowAll(),
    c.ShowMarkers("body1", ("low",), False),
    c.Colour("body1", None),
    c.TreatBoxes("body1", "keep"),
    c.Follow("body1", "walls"),
    c.Activate("lattice2"),
    c.Enable("lattice2", False),
    c.MovePoints("lattice2", ((0, 1, 2),), ((0.1 + 0.2, 1e-300, -0.0),)),
    c.SetWeights("lattice2", ((0, 1, 2), (1, 1, 1)), (1 / 3, 2.0)),
    c.ResetPoints("lattice2"),
    c.ResetPoints("lattice2", ((0, 0, 0),)),
    c.FreezeLayers("lattice2", 1),
    c.InsertKnots("lattice2", 2, (0.1, 0.2)),
    c.ElevateDegree("lattice2", 1, 2),
    c.RemoveKnots("lattice2", 0, (0.5,), 1e-3),
    c.SaveShape("lattice2", "a"),
    c.RemoveShape("lattice2", "a"),
    c.BlendShapes("lattice2", (("a", 0.5), ("b", -1.0))),
    c.UseIterate("lattice2", BENT, "iterate 3"),
    c.AddStudy("Study 1", STUDY),
    c.DuplicateStudy("study3"),
    c.RenameStudy("study3", "Flügel »2«"),
    c.RemoveStudy("study3"),
]


def test_every_command_is_tried_here() -> None:
    assert {type(command) for command in EVERY} == set(c.COMMANDS.values())


@pytest.mark.parametrize("command", EVERY, ids=lambda command: command.verb)
def test_every_command_comes_back_from_its_line_bit_by_bit(command: c.Command) -> None:
    again = to_command(json.loads(json.dumps(to_words(command))))
    assert type(again) is type(command)
    for name in vars(command):
        old, new = getattr(command, name), getattr(again, name)
        if isinstance(old, Lattice):
            assert old == new
            assert old.control_points.tobytes() == new.control_points.tobytes()
        elif name != "shapes":
            assert repr(old) == repr(new)  # repr tells -0.0 from 0.0


@pytest.mark.parametrize(
    "words",
    [
        {},
        {"do": "fly"},
        {"do": "rename", "item": "body1"},
        {"do": "rename", "item": "body1", "name": 3},
        {"do": "rename", "item": "body1", "name": "a", "more": 1},
        {"do": "show", "items": "body1"},
        {"do": "show", "items": ["body1"], "visible": 1},
        {"do": "move points", "item": "l", "points": [[0.5]], "positions": [[0, 0, 0]]},
        {"do": "move points", "item": "l", "points": [[0]], "positions": [["a", 0, 0]]},
        {"do": "open mesh", "path": "a", "mesh": "b"},
        {"do": "blend shapes", "item": "l", "factors": [["a"]]},
        {"do": "add lattice", "name": "a", "rest": {"degrees": [1]}, "current": {}},
        {"do": "refit box", "item": "l", "box": {"name": "a"}},
        {"do": ["rename"]},
    ],
)
def test_lines_that_are_no_commands_are_refused(words: dict) -> None:
    with pytest.raises(InputError):
        to_command(words)


@pytest.fixture
def session(tmp_path: Path) -> Document:
    """A session with most things in it, undo and redo included."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    document = opened(write_cube(folder / "cube.su2"), BOX)
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.5, 0.1, 0.2),)))
    document.do(c.SetWeights("lattice2", ((2, 2, 2),), (1 / 3,)))
    document.do(c.InsertKnots("lattice2", 0, (1 / 3,)))
    document.do(c.Rename("body1", "wing"))
    document.jump(3)
    document.redo()
    document.undo()
    document.do(c.ElevateDegree("lattice2", 1))
    document.do(c.CreateBox("Half", (0.3, 0.0, 0.0), (2.0, 1.0, 1.0), (3, 3, 3), (2, 2, 2)))
    drag = document.edit([(1, 1, 1)])
    drag.translate([0.1, -0.2, 0.05])
    drag.commit()
    return document


def test_a_replay_writes_the_same_bytes_as_the_window(session: Document, tmp_path: Path) -> None:
    session.journal.save(tmp_path / "session.jsonl")
    session.export_mesh("body1", tmp_path / "window.su2")
    written = export(replay(tmp_path / "session.jsonl"), tmp_path / "out")
    assert written[0].moved > 0
    assert (tmp_path / "out" / "cube.su2").read_bytes() == (tmp_path / "window.su2").read_bytes()


def test_saved_reopened_and_replayed_gives_the_same_bytes(
    session: Document, tmp_path: Path
) -> None:
    session.export_mesh("body1", tmp_path / "window.su2")
    session.save(tmp_path / "a.ffdproj")
    again = Document()
    again.open(tmp_path / "a.ffdproj")
    assert [item.name for item in again.model.lattices] == ["Box", "Half"]
    again.export_mesh("body1", tmp_path / "again.su2")
    again.do(c.Rename("lattice3", "Other"))
    again.journal.save(tmp_path / "again.jsonl")
    export(replay(tmp_path / "again.jsonl"), tmp_path / "out")
    expected = (tmp_path / "window.su2").read_bytes()
    assert (tmp_path / "again.su2").read_bytes() == expected
    assert (tmp_path / "out" / "cube.su2").read_bytes() == expected


def test_the_command_line_replays(
    session: Document, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session.journal.save(tmp_path / "session.jsonl")
    assert (
        main(["replay", str(tmp_path / "session.jsonl"), "-o", str(tmp_path / "o"), "--json"]) == 0
    )
    result = json.loads(capsys.readouterr().out)
    assert result["meshes"][0]["moved"] > 0
    assert (tmp_path / "o" / "cube.su2").exists()


def test_a_journal_moves_with_its_meshes(session: Document, tmp_path: Path) -> None:
    session.journal.save(tmp_path / "session.jsonl")
    text = (tmp_path / "session.jsonl").read_text()
    assert "meshes/cube.su2" in text
    assert str(tmp_path) not in text
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "meshes").rename(elsewhere / "meshes")
    (tmp_path / "session.jsonl").rename(elsewhere / "session.jsonl")
    assert len(replay(elsewhere / "session.jsonl").bodies) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: "", "no journal"),
        (lambda text: "{}\n" + text, "no journal"),
        (lambda text: text.replace('"schema": 1', '"schema": 9'), "newer"),
        (lambda text: text.replace("meshes/cube.su2", "meshes/none.su2"), "none.su2"),
        (lambda text: text.replace('"rename"', '"fly"'), "line 7"),
        (lambda text: text.replace('"position": 3', '"position": 99'), "position 99"),
        (lambda text: text.replace('"axis": 0', '"axis": 7'), "line 6"),
        (lambda text: text.replace("0.5, 0.1", "NaN, 0.1"), "NaN"),
        (lambda text: text[:-5], "broken JSON"),
    ],
)
def test_a_journal_that_is_wrong_is_refused_in_one_sentence(
    session: Document,
    tmp_path: Path,
    change,  # type: ignore[no-untyped-def]
    message: str,
) -> None:
    session.journal.save(tmp_path / "a.jsonl")
    (tmp_path / "a.jsonl").write_text(change((tmp_path / "a.jsonl").read_text()))
    with pytest.raises(InputError, match=message) as error:
        replay(tmp_path / "a.jsonl")
    assert "\n" not in str(error.value)


def test_a_mesh_that_has_changed_is_not_replayed(session: Document, tmp_path: Path) -> None:
    session.journal.save(tmp_path / "a.jsonl")
    write_cube(tmp_path / "meshes" / "cube.su2", n=4)
    with pytest.raises(InputError, match="changed"):
        replay(tmp_path / "a.jsonl")


def test_commands_of_a_model_build_it_again(session: Document) -> None:
    model = session.model.without("body1")
    document = Document()
    for command in commands_of(session.model):
        document.do(command)
    for old, new in zip(model.lattices, document.model.lattices, strict=True):
        assert (old.name, old.frozen, old.rest, old.current) == (
            new.name,
            new.frozen,
            new.rest,
            new.current,
        )
    assert document.model.active_lattice is not None
    assert document.model.active_lattice.name == "Half"


def test_bodies_of_files_with_one_name_are_written_under_their_own(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_cube(tmp_path / name / "cube.su2")
    document = opened(tmp_path / "a" / "cube.su2")
    document.open_mesh(tmp_path / "b" / "cube.su2")
    written = export(document.model, tmp_path / "out")
    assert [each.path.name for each in written] == ["cube.su2", "cube 2.su2"]


def test_steps_are_read_as_they_were_recorded(session: Document, tmp_path: Path) -> None:
    session.journal.save(tmp_path / "a.jsonl")
    steps = [step for _, step in read_journal(tmp_path / "a.jsonl")]
    assert steps[1:] == session.journal.steps[1:]
    assert Journal(steps).text(tmp_path) == session.journal.text(tmp_path)
    assert np.count_nonzero([isinstance(step, int) for step in steps]) == 3


@pytest.mark.parametrize("choice", ["update", "strip", "keep"])
def test_what_becomes_of_ffd_boxes_is_replayed_to_the_same_bytes(
    tmp_path: Path, choice: str
) -> None:
    mesh = write_cube(tmp_path / "cube.su2")
    write_lattice(mesh, Lattice.box([-0.2] * 3, [1.2] * 3, (3, 3, 3)), tag="BOX")
    document = opened(mesh, BOX)
    document.problem.disconnect()  # keeping warns
    document.do(c.MovePoints("lattice2", ((1, 1, 1),), ((0.4, 0.3, 0.2),)))
    if choice != "update":
        document.do(c.TreatBoxes("body1", choice))
    document.export_mesh("body1", tmp_path / "out.su2")
    document.journal.save(tmp_path / "a.journal")
    assert main(["replay", str(tmp_path / "a.journal"), "-o", str(tmp_path / "again")]) == 0
    data = (tmp_path / "out.su2").read_bytes()
    assert (tmp_path / "again" / "cube.su2").read_bytes() == data
    assert (b"FFD_NBOX" in data) == (choice != "strip")
    box = read_lattice(mesh)[0]
    if choice != "strip":
        assert (read_lattice(tmp_path / "out.su2")[0] == box) == (choice == "keep")


def test_the_choice_for_ffd_boxes_is_kept_in_the_project(tmp_path: Path) -> None:
    document = opened(write_cube(tmp_path / "cube.su2"))
    document.do(c.TreatBoxes("body1", "strip"))
    document.save(tmp_path / "p.ffdproj")
    again = Document()
    again.open(tmp_path / "p.ffdproj")
    assert again.model.bodies[0].boxes == "strip"
    assert commands_of(again.model)[0].boxes == "strip"  # type: ignore[union-attr]
    with pytest.raises(InputError, match="update, strip, keep"):
        document.do(c.TreatBoxes("body1", "burn"))
