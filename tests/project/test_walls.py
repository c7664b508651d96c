"""Bodies whose volume follows their walls: displayed, checked, stored, replayed, written."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.engine import embed
from ffdstudio.errors import InputError
from ffdstudio.meshes import inverted, read_mesh
from ffdstudio.meshes.following import carry_walls
from ffdstudio.meshes.ways import Way
from ffdstudio.project import commands as c
from ffdstudio.project.checks.guarding import DragGuard
from ffdstudio.project.document import Document
from ffdstudio.project.files.replaying import export, replay
from ffdstudio.samples import sample
from tests.project.scenes import opened

TIGHT = c.CreateBox("Tight", (-0.01, -0.07, 0.0), (1.01, 0.07, 0.0), (6, 2), (3, 1))
RAISED = c.MovePoints("lattice2", ((2, 1), (3, 1)), ((0.4, 0.17, 0.0), (0.6, 0.17, 0.0)))


@pytest.fixture
def scene(tmp_path: Path) -> Document:
    """A section in its air, in a lattice that is tight around it, raised by a tenth."""
    (tmp_path / "meshes").mkdir()
    mesh = tmp_path / "meshes" / "naca0012.su2"
    shutil.copy(sample("naca0012.su2"), mesh)
    document = opened(mesh, TIGHT)
    document.do(RAISED)
    return document


def expected(document: Document) -> np.ndarray:
    body, item = document.model.bodies[0], document.model.lattices[0]
    move = lambda points: embed(item.rest, points).deform(item.current)  # noqa: E731
    return carry_walls(body.mesh, move).points


def test_the_volume_follows_and_no_cell_is_inverted(scene: Document) -> None:
    assert scene.volume("body1").inverted > 0
    carried = scene.points("body1").copy()
    scene.do(c.Follow("body1", "walls"))
    volume = scene.volume("body1")
    assert volume.inverted == 0
    assert np.array_equal(volume.points, expected(scene))
    nodes = scene.surface("body1").nodes
    assert np.array_equal(scene.points("body1"), volume.points[nodes])
    scene.undo()
    assert np.array_equal(scene.points("body1"), carried)
    assert scene.volume("body1").inverted > 0


def test_a_drag_shows_what_the_lattice_does_and_settles_after_it(scene: Document) -> None:
    scene.do(c.Follow("body1", "walls"))
    drag = scene.edit([(2, 1)])
    drag.translate([0, 0.02, 0])
    scene.refresh()
    drag.commit()
    assert scene.volume("body1").inverted == 0
    assert np.array_equal(scene.volume("body1").points, expected(scene))


def test_what_it_followed_by_is_kept_for_the_next_edit(scene: Document) -> None:
    scene.do(c.Follow("body1", "walls"))
    first = scene.volume("body1").by
    scene.do(c.MovePoints("lattice2", ((2, 1),), ((0.4, 0.1, 0.0),)))
    assert first is not None
    assert scene.volume("body1").by is first


def test_written_saved_and_replayed_it_is_the_same(scene: Document, tmp_path: Path) -> None:
    scene.do(c.Follow("body1", "walls"))
    scene.export_mesh("body1", tmp_path / "window.su2")
    mesh = read_mesh(tmp_path / "window.su2")
    assert np.array_equal(mesh.points, expected(scene))
    assert inverted(scene.model.bodies[0].mesh, mesh.points).count == 0
    scene.save(tmp_path / "a.ffdproj")
    again = Document()
    again.open(tmp_path / "a.ffdproj")
    assert again.model.bodies[0].follows is Way.WALLS
    again.export_mesh("body1", tmp_path / "again.su2")
    scene.journal.save(tmp_path / "session.jsonl")
    export(replay(tmp_path / "session.jsonl"), tmp_path / "out")
    again.do(c.Rename("lattice2", "Other"))
    again.journal.save(tmp_path / "again.jsonl")
    export(replay(tmp_path / "again.jsonl"), tmp_path / "more")
    bytes_of = (tmp_path / "window.su2").read_bytes()
    for path in ("again.su2", "out/naca0012.su2", "more/naca0012.su2"):
        assert (tmp_path / path).read_bytes() == bytes_of


def test_at_rest_it_is_written_byte_for_byte(tmp_path: Path) -> None:
    document = opened(sample("naca0012.su2"), TIGHT)
    document.do(c.Follow("body1", "walls"))
    document.export_mesh("body1", tmp_path / "out.su2")
    assert (tmp_path / "out.su2").read_bytes() == sample("naca0012.su2").read_bytes()


def test_a_guard_of_what_the_lattice_carries_leaves_it_alone(scene: Document) -> None:
    guard = DragGuard(scene)
    guard.mode = "stop"
    guard.prepare([(2, 1)])
    assert guard._watched is not None
    scene.do(c.Follow("body1", "walls"))
    guard.prepare([(2, 1)])
    assert guard._watched is None


def test_labels_and_ways(scene: Document) -> None:
    scene.do(c.Follow("body1", "walls"))
    scene.do(c.Follow("body1", "lattice"))
    assert scene.history.labels[-2:] == [
        "naca0012 follows its walls", "naca0012 is carried by the lattice",
    ]  # fmt: skip
    with pytest.raises(InputError, match="follows its walls or the lattice"):
        scene.do(c.Follow("body1", "wind"))
