"""Iterates shown in place of a lattice, and taken over as one entry of the history."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.project.commands import Colour, CreateBox, Rename, Show
from ffdstudio.project.document import Document
from ffdstudio.project.files.journal import read_journal
from ffdstudio.project.studies.scrubbing import scrub


@pytest.fixture
def document() -> Document:
    made = Document()
    made.open_mesh(_square_points())
    made.do(CreateBox("Box", (-1, -1, 0), (2, 2, 0), (5, 3), (3, 2)))
    return made


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def _square_points() -> Path:
    from ffdstudio.meshes import write_mesh
    from ffdstudio.meshes.airfoil import contour_mesh, naca4

    path = Path("section.dat")
    write_mesh(contour_mesh(naca4("0012", points=21)), path)
    return path.resolve()


def _bent(lattice, amount):
    net = lattice.control_points.copy()
    net[2:, :, 1] += amount
    return lattice.moved(net)


def test_a_refined_iterate_is_shown_and_taken_back_without_a_trace(document):
    item = document.model.active_lattice
    before, points = document.model, document.points("body1").copy()
    finer = _bent(item.current.insert_knots(0, [0.4]), 0.1)
    document.select([(0, 0)])
    edit = scrub(document, item.key)
    edit.show(finer)
    document.refresh()
    assert document.model.active_lattice.rest.shape == (6, 3)
    assert not document.selection
    shown = document.points("body1")
    assert np.allclose(shown, _expected(item, finer, points), atol=1e-13)
    edit.abort()
    assert document.model is before
    assert np.array_equal(document.points("body1"), points)
    assert len(document.history.labels) == 2


def _expected(item, finer, points):
    import ffdstudio as ffd

    return ffd.embed(item.rest.insert_knots(0, [0.4]), points).deform(finer)


def test_using_an_iterate_is_one_undoable_entry_that_replays(document):
    item = document.model.active_lattice
    before = document.model
    finer = _bent(item.current.insert_knots(0, [0.4, 0.6]), 0.1)
    edit = scrub(document, item.key)
    edit.show(_bent(item.current, 0.2), "iterate 1")
    edit.show(finer, "iterate 7")
    edit.commit()
    assert document.history.labels[-1] == "Use iterate 7"
    assert document.model.active_lattice.current == finer
    document.journal.save("all.journal")
    steps = [step for _, step in read_journal("all.journal")]
    assert steps[-1].current == finer
    document.undo()
    assert document.model is before


def test_another_edit_keeps_what_is_shown(document):
    item = document.model.active_lattice
    edit = scrub(document, item.key)
    edit.show(_bent(item.current, 0.2), "iterate 3")
    drag = document.edit([(2, 1)])
    drag.translate([0, 0.1, 0])
    drag.commit()
    assert document.history.labels[-2:] == ["Use iterate 3", "Move point (2, 1)"]


def test_an_iterate_of_another_lattice_is_refused(document):
    item = document.model.active_lattice
    edit = scrub(document, item.key)
    with pytest.raises(InputError, match="other knots"):
        edit.show(item.current.elevate_degree(0))
    edit.abort()


def test_views_hear_of_the_old_net_before_its_points(document):
    item = document.model.active_lattice
    edit = scrub(document, item.key)
    edit.show(_bent(item.current.insert_knots(0, [0.4]), 0.1))
    heard = []
    document.structure_changed.connect(
        lambda: heard.append(document.model.active_lattice.rest.shape)
    )
    document.moved.connect(lambda: heard.append("moved"))
    edit.abort()
    assert heard[0] == (5, 3)
    assert heard[-1] == "moved"


@pytest.mark.parametrize(
    "command",
    [
        Show(("body1",), False),
        Colour("body1", "#ff0000"),
        Rename("lattice2", "Net"),
        Show(("lattice2",), False),
    ],
    ids=["hide", "colour", "rename", "hide the lattice"],
)
def test_what_changes_looks_only_leaves_the_iterate_shown(document, command):
    item = document.model.active_lattice
    finer = _bent(item.current.insert_knots(0, [0.4]), 0.1)
    edit = scrub(document, item.key)
    edit.show(finer, "iterate 3")
    heard = []
    document.structure_changed.connect(lambda: heard.append(document.model))
    document.do(command)
    assert document.editing is edit
    assert document.model.active_lattice.current == finer
    assert heard == [document.model]
    labels = document.history.labels
    assert labels[-1] == command.label(document.history.entries[-1].before)
    assert not document.settled_model.active_lattice.deformed
    edit.show(_bent(finer, 0.2), "iterate 4")
    edit.abort()
    assert document.model is document.history.entries[-1].after
    document.undo()
    assert document.history.labels == labels
    assert document.model.active_lattice is item


def test_an_iterate_can_still_be_used_after_something_was_hidden(document):
    item = document.model.active_lattice
    bent = _bent(item.current, 0.1)
    edit = scrub(document, item.key)
    edit.show(bent, "iterate 3")
    document.do(Show(("body1",), False))
    edit.commit()
    assert document.history.labels[-2:] == ["Hide section", "Use iterate 3"]
    assert document.model.active_lattice.current == bent
    assert not document.model.bodies[0].visible


def test_a_refused_look_leaves_the_iterate_shown_and_nothing_done(document):
    edit = scrub(document, "lattice2")
    edit.show(_bent(document.model.active_lattice.current, 0.1))
    labels = document.history.labels
    with pytest.raises(InputError):
        document.do(Rename("lattice2", ""))
    assert document.editing is edit
    assert document.history.labels == labels
