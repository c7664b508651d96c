"""Studies of a document in its history, in its project file, and as case files."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path

import msgspec
import pytest

import ffdstudio as ffd
from ffdstudio.cli.main import main
from ffdstudio.errors import InputError
from ffdstudio.optimize.build.place import given
from ffdstudio.optimize.consent import Consent, NotTrusted
from ffdstudio.optimize.constraints.thickness import MaxThicknessLimit
from ffdstudio.optimize.methods.descent import Lbfgs
from ffdstudio.optimize.methods.gauss_newton import GaussNewton
from ffdstudio.optimize.methods.slsqp import Slsqp
from ffdstudio.optimize.objectives.contour import ContourSpec
from ffdstudio.optimize.objectives.flow import FlowSpec
from ffdstudio.optimize.objectives.program import ProgramSpec
from ffdstudio.optimize.runs.record import read_log
from ffdstudio.optimize.spec.codec import to_toml
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.studies.casefile import mesh_to_open, read_case_for, write_case
from ffdstudio.project.studies.following import walls_to_follow
from ffdstudio.project.studies.starting import checked, new_lattice, on_lattice, prepare
from tests.optimize.catalog_rows import EVERY

FIT = StudySpec(
    shape=ShapeSpec(source=given("body1"), marker="airfoil", points=101, normalise=False),
    lattice=LatticeSpec(shape=(5, 2), degrees=(3, 1), margin=(0.01, 0.05)),
    objective=ContourSpec(target="naca2412"),
    method=GaussNewton(),
    refinement=RefinementSpec(variables=14),
)
LIFT = msgspec.structs.replace(
    FIT,
    objective=FlowSpec(angles=(1.5,), lift=(0.35,)),
    constraints=(MaxThicknessLimit(lower=0.11),),
    method=Slsqp(),
    refinement=None,
    budget=BudgetSpec(iterations=4),
)
PRESSURE = msgspec.structs.replace(
    FIT,
    objective=FlowSpec(angles=(2.0,), target="section.dat"),
    method=Lbfgs(),
    refinement=RefinementSpec(variables=12, slope=0.8),
    budget=BudgetSpec(iterations=5),
)
STUDIES = {"fit": FIT, "lift": LIFT, "pressure": PRESSURE}


@pytest.fixture
def folder(root, tmp_path):
    """A mesh and a target beside it."""
    place = tmp_path / "meshes"
    place.mkdir()
    shutil.copy(root / "sample_meshes" / "naca0012.su2", place)
    shutil.copy(root / "sample_meshes" / "rae2822.dat", place / "section.dat")
    return place


@pytest.fixture
def document(folder):
    document = Document()
    document.open_mesh(folder / "naca0012.su2")
    return document


def run_in(document, study, name):
    """Run a study as the window does; returns its key."""
    study = checked(study, document.model)
    made = new_lattice(study, document.model)
    document.do(made)
    for command in walls_to_follow(made, document.model):
        document.do(command)
    study = on_lattice(study, document.model.lattices[-1].key)
    document.do(c.AddStudy(name, study))
    key = document.model.studies[-1].key
    history = document.records.begin(key)
    prepare(study, document.model).study.run(history.records.append)
    document.records.ended()
    return key


def lines(records):
    return [json.dumps({**record.line(), "seconds": 0}) for record in records]


# ---- the history ------------------------------------------------------------------------------


def test_studies_come_go_and_get_names_undoably(document):
    document.do(c.AddStudy("Study 1", FIT))
    key = document.model.studies[0].key
    document.records.begin(key).records.append("a record")
    document.do(c.RenameStudy(key, "Fit"))
    document.do(c.DuplicateStudy(key))
    assert [item.name for item in document.model.studies] == ["Fit", "Fit copy"]
    assert document.model.studies[1].spec == FIT
    assert document.records.of(document.model.studies[1].key) == []
    document.do(c.RemoveStudy(key))
    assert [item.name for item in document.model.studies] == ["Fit copy"]
    document.undo()
    assert document.records.of(key) == ["a record"]
    for _ in range(3):
        document.undo()
    assert document.model.studies == ()
    document.do(c.AddStudy("Other", FIT))  # the key is given again
    assert document.records.of(document.model.studies[0].key) == []


def test_names_of_studies_are_their_own(document):
    document.do(c.AddStudy("Study 1", FIT))
    key = document.model.studies[0].key
    for name in ("", "naca0012"):
        with pytest.raises(InputError):
            document.do(c.RenameStudy(key, name))
    assert document.model.free_name("Study 1") == "Study 1 2"
    with pytest.raises(InputError):
        document.do(c.RemoveStudy("study99"))


# ---- the project ------------------------------------------------------------------------------


def test_three_studies_are_saved_and_reopened_with_all_their_records(document, tmp_path):
    keys = [run_in(document, study, name) for name, study in STUDIES.items()]
    before = {name: document.records.of(key) for name, key in zip(STUDIES, keys, strict=True)}
    assert document.modified
    document.save(tmp_path / "three.ffdproj")
    assert not document.modified
    again = Document()
    again.open(tmp_path / "three.ffdproj")
    assert not again.modified
    assert [item.name for item in again.model.studies] == list(STUDIES)
    for item in again.model.studies:
        records = again.records.of(item.key)
        assert lines(records) == lines(before[item.name])
        assert records[-1].ending == before[item.name][-1].ending
        history = again.records.history(item.key)
        lattice = again.model.lattice(item.spec.lattice.file[1:-1])
        again.do(c.UseIterate(lattice.key, history.lattice(-1), "the last"))
        assert again.model.lattice(lattice.key).current == history.lattice(-1)
        again.undo()
    # and they go on: the same study, run again from what was opened, tells the same
    for item in again.model.studies:
        history = prepare(item.spec, again.model).study.run()
        assert lines(history.records) == lines(before[item.name])


def test_a_study_that_has_ended_is_something_to_save(document, tmp_path):
    key = run_in(document, LIFT, "lift")
    document.save(tmp_path / "a.ffdproj")
    assert not document.modified
    document.records.begin(key)
    assert document.modified


@pytest.mark.parametrize("spec", EVERY.values(), ids=list(EVERY))
def test_a_project_gives_back_the_same_study(spec, document, tmp_path):
    shape = msgspec.structs.replace(spec.shape, source=given("body1"))
    spec = msgspec.structs.replace(spec, shape=shape)
    document.do(c.AddStudy("Study 1", spec))
    document.save(tmp_path / "one.ffdproj")
    again = Document()
    again.open(tmp_path / "one.ffdproj")
    assert [item.spec for item in again.model.studies] == [spec]


def test_keys_that_are_given_anew_mean_the_same_bodies_and_lattices(document, folder, tmp_path):
    shutil.copy(folder / "naca0012.su2", folder / "other.su2")
    document.open_mesh(folder / "other.su2")
    document.do(c.Remove("body1"))
    study = msgspec.structs.replace(FIT, shape=ShapeSpec(source=given("body2"), marker="airfoil"))
    document.do(c.AddStudy("Study 1", study))
    document.save(tmp_path / "one.ffdproj")
    again = Document()
    again.open(tmp_path / "one.ffdproj")
    (item,) = again.model.studies
    assert item.spec.shape.source == given(again.model.bodies[0].key) == given("body1")


def test_a_damaged_study_costs_that_study_only(document, tmp_path):
    from ffdstudio.project.files.storage import read_project, write_project

    run_in(document, LIFT, "lift")
    run_in(document, FIT, "fit")
    content = document.snapshot()
    content.studies[0].values["objective"] = {"kind": "magic"}
    write_project(tmp_path / "odd.ffdproj", content)
    again, told = Document(), []
    again.problem.connect(lambda *words: told.append(words))
    again.open(tmp_path / "odd.ffdproj")
    assert [item.name for item in again.model.studies] == ["fit"]
    assert len(again.model.lattices) == 2
    assert any("magic" in words[1] for words in told)
    assert len(read_project(tmp_path / "odd.ffdproj").studies) == 2


def test_a_program_that_came_inside_a_project_needs_leave(document, tmp_path):
    document.do(new_lattice(FIT, document.model))
    study = msgspec.structs.replace(
        on_lattice(FIT, document.model.active),
        objective=ProgramSpec(command=("sh", "-c", "true")), method=Lbfgs(), refinement=None,
    )  # fmt: skip
    document.do(c.AddStudy("Study 1", study))
    assert document.records.source_of(study.objective) is None
    document.save(tmp_path / "stranger.ffdproj")
    again = Document()
    again.open(tmp_path / "stranger.ffdproj")
    spec = again.model.studies[0].spec
    source = again.records.source_of(spec.objective)
    assert source == tmp_path / "stranger.ffdproj"
    with pytest.raises(NotTrusted, match="stranger"):
        prepare(spec, again.model, tmp_path / "runs", source)
    prepare(spec, again.model, tmp_path / "runs", source, Consent(everything=True))


# ---- case files -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_saved_as_a_case_file_gives_the_same_record_to_the_bit(
    name, document, tmp_path, capsys
):
    key = run_in(document, STUDIES[name], name)
    spec = document.model.study(key).spec
    (tmp_path / "cases").mkdir()
    case = tmp_path / "cases" / "study.toml"
    written = write_case(spec, document.model, case)
    assert all(path.exists() for path in written)
    assert main(["optimize", str(case), "-o", str(tmp_path / "out"), "--json"]) in (0, 1)
    capsys.readouterr()
    assert lines(read_log(tmp_path / "out").records) == lines(document.records.of(key))


def test_a_study_that_makes_its_own_lattice_is_the_same_as_a_case(document, tmp_path, capsys):
    case = tmp_path / "new.toml"
    assert write_case(FIT, document.model, case) == [case]
    key = run_in(document, FIT, "fit")
    assert main(["optimize", str(case), "-o", str(tmp_path / "out"), "--json"]) in (0, 1)
    capsys.readouterr()
    assert lines(read_log(tmp_path / "out").records) == lines(document.records.of(key))


def test_a_body_that_an_earlier_lattice_deforms_is_the_same_as_a_case(document, tmp_path, capsys):
    box = ffd.Lattice.box([-0.5, -0.5, 0], [1.5, 0.5, 0], (4, 4), (3, 3))
    bent = box.control_points + [0, 0.02, 0] * (box.control_points[..., :1] > 0.5)
    document.do(c.AddLattice("Before", box, box.moved(bent)))
    key = run_in(document, FIT, "fit")
    case = tmp_path / "bent.toml"
    write_case(document.model.study(key).spec, document.model, case)
    assert len(tomllib.loads(case.read_text())["shape"]["lattices"]) == 1
    assert main(["optimize", str(case), "-o", str(tmp_path / "out"), "--json"]) in (0, 1)
    capsys.readouterr()
    assert lines(read_log(tmp_path / "out").records) == lines(document.records.of(key))


def test_a_case_comes_back_as_a_study_of_the_document(document, folder, tmp_path):
    write_case(PRESSURE, document.model, tmp_path / "a.toml")
    back = read_case_for(tmp_path / "a.toml", document.model)
    assert back.shape == PRESSURE.shape
    assert Path(back.objective.target) == folder / "section.dat"
    own = msgspec.structs.replace(back, objective=PRESSURE.objective)
    assert own == PRESSURE
    empty = read_case_for(tmp_path / "a.toml", Document().model)
    assert mesh_to_open(empty) == folder / "naca0012.su2"
    assert mesh_to_open(back) is None


def test_the_examples_can_be_loaded(root, document):
    for path in (root / "resources" / "cases").glob("*.toml"):
        spec = read_case_for(path, document.model)
        assert to_toml(spec)
        assert checked(spec, document.model) == spec


def test_an_incomplete_study_is_no_case(document, tmp_path):
    odd = msgspec.structs.replace(FIT, objective=ContourSpec(target=""))
    with pytest.raises(InputError, match="target must be text"):
        write_case(odd, document.model, tmp_path / "odd.toml")
    assert not (tmp_path / "odd.toml").exists()


def test_temporary_folders_go_with_their_owner():
    from ffdstudio.project.studies.folders import StudyFolders

    folders = StudyFolders()
    places = [folders.of("study1"), folders.of("study1")]
    (places[0] / "file").write_text("x")
    assert len({*places}) == 2
    folders.close()
    assert not any(place.exists() for place in places)
    assert folders.of("study1").exists()
    folders.close()
