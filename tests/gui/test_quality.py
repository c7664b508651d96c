"""Quality and the guard of drags in a window: panel, colours, flight, export, frozen layers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from ffdstudio.engine import Lattice, embed
from ffdstudio.gui.quality.guardline import words
from ffdstudio.meshes import Coverage, Mesh, quality
from ffdstudio.meshes.measures import MEASURES
from ffdstudio.meshes.safety.guard import Guard
from ffdstudio.meshes.safety.limits import PRESETS, Stop
from ffdstudio.project.checks.freezing import advice
from ffdstudio.project.checks.guarding import Verdict
from ffdstudio.project.checks.iterate_cells import coverage_of
from tests.meshes.cell_files import nastran

pytestmark = pytest.mark.display
POINT = (2, 2, 2)


@pytest.fixture(scope="module", autouse=True)
def _kernels_are_compiled() -> None:
    """What may take long in a fresh checkout is done before a window waits for it."""
    corners = np.array(list(np.ndindex(2, 2, 2)), dtype=float)
    mesh = Mesh(corners, {"hexahedron": [[0, 4, 6, 2, 1, 5, 7, 3]]})
    assert not quality(mesh).inverted.any()
    embedding = embed(Lattice.around(corners, (3, 3, 3), (2, 2, 2)), corners)
    drag = embedding.drag(embedding.lattice, [13])
    limits = PRESETS["OpenFOAM"]
    Guard(mesh, corners, drag.influence, drag.rows, limits).stop(np.ones(3))


@pytest.fixture
def cubed(user: Any, cube: Path) -> Any:
    """Window with a cube in a lattice, its quality shown."""
    user.open(cube)
    user.build()
    user.trigger("quality.show")
    user.idle()
    return user


def move(user: Any, vector: tuple[float, float, float], point: tuple[int, ...] = POINT) -> None:
    edit = user.window.document.edit([point])
    edit.translate(vector)
    edit.commit()
    user.idle()


def test_nothing_open_says_what_to_do(user: Any) -> None:
    assert "Open a mesh" in user.window.quality.panel.empty.text()


def test_the_panel_shows_what_the_report_says(cubed: Any) -> None:
    panel, part = cubed.window.quality.panel, cubed.window.quality
    assert panel.currentIndex() == 1
    move(cubed, (0.6, 0.3, 0.0))
    report = part.checks.report("body1")
    skewness = report.statistics("skewness")
    assert f"max {skewness.max:.4g}" in panel.figures.text()
    assert panel.worst.cells()[0] == report.worst("skewness", 1)[0].cell
    assert panel.histogram.plot.bars.opts["height"].max() > 0


@pytest.mark.parametrize("way", ["history", "new"])
def test_two_measured_bodies_can_go_at_once(cubed: Any, square: Path, way: str) -> None:
    window, history = cubed.window, cubed.window.history
    cubed.open(square)
    panel = window.quality.panel
    panel.body.setCurrentIndex(1)
    panel.body.activated.emit(1)
    cubed.idle()
    assert panel.currentIndex() == 1
    if way == "history":
        place = history.visualItemRect(history.item(0)).center()
        QTest.mouseClick(
            history.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, place
        )
    else:
        cubed.script.answers = ["discard"]
        cubed.trigger("file.new")
    cubed.idle()
    assert window.document.model.bodies == ()
    assert "Open a mesh" in panel.empty.text()
    assert window.tree.topLevelItemCount() == 0
    assert cubed.script.told == []


def test_every_measure_names_its_standard(cubed: Any) -> None:
    box = cubed.window.quality.panel.measure
    assert box.count() == len(MEASURES)
    for row, measure in enumerate(MEASURES.values()):
        assert measure.standard in box.itemData(row, Qt.ItemDataRole.ToolTipRole)


def test_colours_go_on_the_mesh_and_off_again(cubed: Any) -> None:
    painter = cubed.window.quality.painter
    cubed.trigger("quality.colour")
    cubed.idle()
    coat = painter.coats["body1"]
    shown = coat.actor.GetMapper().GetInput()
    assert shown.GetCellData().GetScalars().GetNumberOfTuples() == shown.GetNumberOfPolys() == 96
    assert coat.actor.GetVisibility()
    assert cubed.window.quality.legend.isVisible()
    cubed.trigger("quality.colour")
    cubed.idle()
    assert painter.coats == {}
    assert not cubed.window.quality.legend.isVisible()


def test_the_difference_map_is_neutral_before_anything_has_moved(cubed: Any) -> None:
    part = cubed.window.quality
    part.choice.want(colour="change")
    cubed.idle()
    colours = part.painter.coats["body1"].actor.GetMapper().GetInput().GetCellData().GetScalars()
    first = colours.GetTuple3(0)
    assert all(colours.GetTuple3(k) == first for k in range(96))
    move(cubed, (0.6, 0.3, 0.0))
    colours = part.painter.coats["body1"].actor.GetMapper().GetInput().GetCellData().GetScalars()
    assert len({colours.GetTuple3(k) for k in range(96)}) > 5


def test_a_click_on_a_worst_cell_flies_there(cubed: Any) -> None:
    move(cubed, (0.6, 0.3, 0.0))
    part, viewport = cubed.window.quality, cubed.window.viewport
    worst = part.panel.worst
    cell = worst.cells()[2]
    place = worst.visualItemRect(worst.topLevelItem(2)).center()
    QTest.mouseClick(worst.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert part.choice.wanted.cell == cell
    cubed.qtbot.waitUntil(lambda: viewport.view is part.mark.flight.end, timeout=20_000)
    report = part.checks.report("body1")
    np.testing.assert_allclose(
        viewport.view.focal, report.points[_nodes(cubed, cell)].mean(axis=0), atol=0.2
    )
    cubed.painted()
    assert viewport.overlay.layers["worst"]


def _nodes(user: Any, cell: int) -> np.ndarray:
    return user.window.document.model.bodies[0].mesh.cells["hexahedron"][cell]


def test_the_next_worst_cell_by_key(cubed: Any) -> None:
    part = cubed.window.quality
    cubed.trigger("quality.worst")
    cubed.trigger("quality.worst")
    assert part.choice.wanted.cell == part.panel.worst.cells()[1]


def test_limits_count_cells_before_and_now(cubed: Any) -> None:
    move(cubed, (-15.0, 0.0, 0.0))
    cubed.window.quality.choice.want(preset="OpenFOAM")
    cubed.idle()
    limits = cubed.window.quality.panel.limits
    name, before, now = limits.rows[0]
    assert name.text().startswith("non-orthogonality > 70")
    assert name.width() >= name.fontMetrics().horizontalAdvance("non-orthogonality > 70°")
    assert before.text() == "0"
    assert int(now.text()) > 0
    assert now.property("role") == "problem"


def test_a_picked_cell_goes_with_its_mesh(cubed: Any, square: Path) -> None:
    cubed.trigger("quality.worst")
    assert cubed.window.quality.choice.wanted.cell >= 0
    cubed.window.document.clear()
    cubed.open(square)  # its key is the one that the cube had
    assert cubed.window.document.model.bodies[0].key == "body1"
    assert cubed.window.quality.choice.wanted.cell == -1
    assert not cubed.window.viewport.overlay.layers.get("worst")


def test_both_themes_are_worn(cubed: Any) -> None:
    histogram = cubed.window.quality.panel.histogram.plot
    for name in ("dark", "light"):
        cubed.trigger(f"view.{name}")
        background = histogram.backgroundBrush().color().name()
        assert background == cubed.window.studio.theme["base"]


def dragged(user: Any) -> Any:
    """Drag a layer of points far through the cube, up to the moment before the release."""
    document = user.window.document
    document.select([(2, j, k) for j in range(4) for k in range(4)])
    user.idle()
    start = user.at(POINT)
    way = user.pixel(np.array([0.0, 0.5, 0.5])) - user.pixel(np.array([1.0, 0.5, 0.5]))
    user.begin(start, start + way * 2)
    user.qtbot.waitUntil(
        lambda: user.window.tools.feedback.verdict.state == "ready", timeout=20_000
    )
    user.painted()
    return start + way * 2


def released(user: Any, end: Any) -> int:
    QTest.mouseRelease(user.window.viewport, Qt.MouseButton.LeftButton, pos=end)
    user.idle()
    return user.window.document.volume("body1").inverted


def test_a_drag_is_stopped_where_cells_would_invert(cubed: Any) -> None:
    cubed.trigger("quality.guard_stop")
    end = dragged(cubed)
    assert any(
        "stopped at" in str(shape) for shape in cubed.window.viewport.overlay.layers["guard"]
    )
    assert released(cubed, end) == 0
    assert cubed.window.document.volume("body1").moved > 0
    assert not cubed.window.viewport.overlay.layers["guard"]


def test_by_default_a_drag_beyond_the_limit_is_told(cubed: Any) -> None:
    end = dragged(cubed)
    layer = cubed.window.viewport.overlay.layers["guard"]
    assert any("beyond the limit" in str(shape) for shape in layer)
    assert any(getattr(shape, "colour", "") == "danger" for shape in layer)
    assert released(cubed, end) > 0


def test_the_choice_of_the_guard_is_remembered(cubed: Any, make_user: Any) -> None:
    cubed.trigger("quality.guard_stop")
    box = cubed.window.quality.panel.guard
    assert box.mode.currentData() == "stop"
    box.limits.setCurrentIndex(1)
    box.limits.activated.emit(1)
    cubed.window.studio.settings.save()
    other = make_user().window.quality
    assert (other.warden.mode, other.warden.limits) == ("stop", box.limits.itemData(1))


def test_export_of_inverted_cells_is_asked_and_they_can_be_shown(
    cubed: Any, tmp_path: Path
) -> None:
    move(cubed, (-15.0, 0.0, 0.0))
    assert cubed.window.document.volume("body1").inverted
    script = cubed.script
    script.answers = ["show"]
    cubed.trigger("file.export_mesh")
    cubed.idle()
    assert len(script.asked) == 1
    assert "inside out" in script.asked[0].text
    part = cubed.window.quality
    assert part.choice.wanted.measure == "scaled_jacobian"
    cubed.qtbot.waitUntil(lambda: part.choice.wanted.cell >= 0)
    report = part.checks.report("body1")
    assert report.inverted[part.choice.wanted.cell]  # and the camera flies to it
    script.answers, script.targets = ["export"], [tmp_path / "bad.su2"]
    cubed.trigger("file.export_mesh")
    cubed.idle()
    assert (tmp_path / "bad.su2").exists()


def test_export_of_a_sound_mesh_is_not_asked(cubed: Any, tmp_path: Path) -> None:
    move(cubed, (0.2, 0.0, 0.0))
    cubed.script.targets = [tmp_path / "good.su2"]
    cubed.trigger("file.export_mesh")
    cubed.idle()
    assert cubed.script.asked == []
    assert (tmp_path / "good.su2").exists()


def test_layers_are_frozen_where_mesh_lies_on_both_sides(user: Any, square: Path) -> None:
    user.open(square)
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    assert builder.frozen.value() == 0
    for edits, value in ((builder.low, 0.3), (builder.high, 0.8)):
        for edit in edits[:2]:
            edit.selectAll()
            QTest.keyClicks(edit, str(value))
    assert builder.frozen.value() == 1
    assert "both sides of i min, i max, j min and j max" in builder.hint.text()
    assert "C0" in builder.hint.text()
    builder.frozen.setValue(0)
    assert "shear" in builder.hint.text()
    assert builder.frozen.value() == 0
    builder.frozen.setValue(1)
    QTest.mouseClick(builder.make, Qt.MouseButton.LeftButton)
    user.idle()
    ring = user.window.quality.ring.segments
    assert np.abs(ring[..., 2]).max() == 0
    assert np.abs(ring[..., :2] - 0.55).max(axis=-1) == pytest.approx(0.25)
    assert any("C0" in str(shape) for shape in user.window.viewport.overlay.layers["ring"])


def test_the_advice_on_frozen_layers() -> None:
    solid = (6, 6, 6)
    assert advice(solid, [], 0) == ""
    assert "Freeze a layer" in advice(solid, [(0, 1)], 0)
    assert "2 layers stay frozen, so that the shape is C1 there" in advice(solid, [(0, 1)], 2)
    assert advice(solid, [(0, 1)], 2).endswith("frozen on all faces alike.")
    assert "alike" not in advice((6,), [(0, 0), (0, 1)], 2)
    assert "2 layers give C1" in advice(solid, [(0, 1)], 1)
    assert "2 layers" not in advice((4, 6, 6), [(0, 1)], 1)


def test_words_of_the_guard() -> None:
    asked = np.array([2.0, 0, 0])
    assert words(Verdict(asked, asked, state="waiting")) == "guard is being set up …"
    assert words(Verdict(asked, asked, state="ready")) == ""
    near = Verdict(asked, asked, Stop(1.5, "face_skewness", 3), "wing", "ready")
    assert words(near) == "limit 3: face skewness"


def test_the_section_is_coloured_by_the_cells_it_cuts(cubed: Any) -> None:
    cubed.trigger("view.section")
    cubed.idle()
    part = cubed.window.quality
    part.choice.want(measure="volume", colour="value")
    cubed.idle()
    actor, found = cubed.window.sections.actors["body1"], cubed.window.sections.cuts["body1"]
    assert len(found.cells) == len(found.offsets) - 1 == 16
    mesh = cubed.window.document.model.bodies[0].mesh
    origin = np.array([0.5, 0.002 + 0.996 * 0.5, 0.5])
    for cell in found.cells:
        nodes = mesh.points[mesh.cells["hexahedron"][cell]]
        assert nodes[:, 1].min() <= origin[1] <= nodes[:, 1].max()
    assert actor.faces.GetMapper().GetScalarVisibility()
    assert actor.faces.GetMapper().GetInput().GetCellData().GetScalars().GetNumberOfTuples() == 16
    cubed.trigger("quality.colour")
    cubed.idle()
    assert not cubed.window.sections.actors["body1"].faces.GetMapper().GetScalarVisibility()


@pytest.mark.filterwarnings("ignore:.*kept but not shown")
def test_cells_that_are_not_checked_are_told_wherever_cells_are(user: Any, tmp_path: Path) -> None:
    deck = nastran(tmp_path / "deck.bdf", "CHEXA", more="CHEXOTIC,9,1,1,2,3,4\n")
    user.open(deck)
    user.build()
    user.trigger("quality.show")
    user.idle()
    move(user, (0.01, 0.0, 0.0))
    said = "1 cell not checked (1 CHEXOTIC)"
    assert said in user.window.status.cells.text()
    assert "no inverted cells" not in user.window.status.cells.text()
    assert said in user.window.quality.panel.inverted.text()
    assert user.window.quality.panel.topology.text() == "Topology: no faults; 1 region"
    document = user.window.document
    assert document.volume("body1").coverage.missing == 1
    assert coverage_of(document).unchecked == {"CHEXOTIC": 1}


def test_a_guard_that_does_not_know_all_cells_says_so_at_the_cursor() -> None:
    unseen = Coverage({"tetra": 1}, {"CHEXOTIC": 2})
    step = np.array([1.0, 0, 0])
    assert words(Verdict(step, step, Stop(np.inf), "a", "ready", unseen)) == str(unseen)
    assert words(Verdict(step, step, Stop(2.0, "inversion"), "a", "ready", unseen)).endswith(
        "; 2 cells not checked (2 CHEXOTIC)"
    )
