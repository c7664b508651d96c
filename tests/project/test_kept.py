"""A file of each schema that was ever written is kept, and opens for ever.

``tests/kept`` was written by the versions named in the files' names; nobody makes them anew. Who
raises a schema adds a file of the new one.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import Lattice
from ffdstudio.exchange import read_lattice_file
from ffdstudio.optimize.objectives.remembered import _read
from ffdstudio.optimize.runs.record import LOG, read_log
from ffdstudio.project import Project
from ffdstudio.project.document import Document
from ffdstudio.project.files.replaying import replay

KEPT = Path(__file__).parents[1] / "kept"
POINTS = np.load(KEPT / "points.npy")


def as_it_was(rest: Lattice, current: Lattice) -> None:
    assert rest.shape == (5, 4, 4)
    assert np.array_equal(current.control_points, POINTS)
    assert float(current.weights.max()) > 1


def test_a_project_of_schema_1_opens(tmp_path):
    shutil.copy(KEPT / "project_1.ffdproj", tmp_path)  # its mesh travels in it
    found = Project.open(tmp_path / "project_1.ffdproj")
    assert found.problems == []
    as_it_was(found.lattices[0].rest, found.lattices[0].current)
    assert found.lattices[0].frozen == 1
    assert found.sections["of a later version"]["two"] == [1, {"a": None}]
    document, told = Document(), []
    document.problem.connect(lambda *words: told.append(words))
    document.open(tmp_path / "project_1.ffdproj")
    assert told == []
    item = document.model.lattices[0]
    as_it_was(item.rest, item.current)
    assert list(item.shapes) == ["bent"]
    document.save(tmp_path / "again.ffdproj")
    again = Project.open(tmp_path / "again.ffdproj")
    assert again.lattices[0].current == found.lattices[0].current
    assert np.array_equal(again.sections["of a later version"]["one"], np.arange(3))


def test_a_journal_of_schema_1_is_repeated(tmp_path):
    for name in ("journal_1.jsonl", "cube.su2"):
        shutil.copy(KEPT / name, tmp_path)
    item = replay(tmp_path / "journal_1.jsonl").lattices[0]
    as_it_was(item.rest, item.current)


def test_a_lattice_of_version_1_is_read():
    found = read_lattice_file(KEPT / "lattice_1.lattice.json")
    as_it_was(found.rest, found.current)
    assert (found.frozen, found.units, found.open_faces) == (1, "mm", ((0, 0),))


def test_the_record_of_a_study_is_read(tmp_path):
    shutil.copy(KEPT / "log_1.jsonl", tmp_path / LOG)
    history = read_log(tmp_path)
    assert len(history.iterates) == 7
    assert history.iterates[-1].cost == pytest.approx(4.6627e-07, rel=1e-4)
    assert history.lattice(-1).shape[1] == 2


def test_an_evaluation_is_recalled():
    found = _read(KEPT / "evaluation_1.npz", np.zeros((4, 3)))
    assert found is not None
    assert (found.value, found.measures, found.flow) == (1.5, {"cl": 0.5}, 1)
    assert np.array_equal(found.gradient, np.linspace(0, 1, 12).reshape(4, 3))
