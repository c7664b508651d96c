"""Panels: what they show is the document, what is done in them is a command."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit

from ffdstudio.project import commands as c
from ffdstudio.project.interaction.spread import Mirror
from ffdstudio.project.interaction.tools import Options

pytestmark = pytest.mark.display
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def user(same_user):
    return same_user


@pytest.fixture
def ready(user, cube):
    user.open(cube)
    user.build()
    return user


def labels(user):
    return user.window.document.history.labels


# ---- the start page and opening ---------------------------------------------------------


def test_the_start_page_is_there_while_nothing_is_open(user, cube):
    window = user.window
    assert window.middle.currentWidget() is window.start
    user.open(cube)
    assert window.middle.currentWidget() is window.viewport
    user.script.answers = ["discard"]
    user.trigger("file.new")
    assert window.middle.currentWidget() is window.start
    assert any(cube.name in tile.accessibleName() for tile in window.start.tiles)


def test_an_example_opens_by_a_click(user):
    tile = next(t for t in user.window.start.tiles if "NACA" in t.accessibleName())
    QTest.mouseClick(tile, LEFT)
    user.idle()
    assert user.window.document.model.bodies[0].mesh.dimension == 2


def test_dropped_files_are_opened(user, cube, square):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in (cube, square)])
    copy, none = Qt.DropAction.CopyAction, Qt.KeyboardModifier.NoModifier
    drop = QDropEvent(QPointF(300, 300), copy, data, LEFT, none)
    user.window.dropEvent(drop)
    user.idle()
    assert [b.name for b in user.window.document.model.bodies] == ["cube", "square"]


def test_a_broken_file_is_told_with_its_cause_and_changes_nothing(user, tmp_path):
    path = tmp_path / "broken.su2"
    path.write_text("NDIME= 3\nNELEM= 4\n")
    user.open(path)
    (told,) = user.script.told
    assert "broken.su2" in told.title
    assert "NPOIN" in told.cause
    assert [text for text, _ in told.ways] == ["&Open another…"]
    assert user.window.document.model.bodies == ()
    assert user.window.problems.count() == 1
    assert path not in user.window.studio.settings.recent()


def test_a_project_just_saved_is_the_newest_of_the_recent_files(ready, cube, tmp_path):
    ready.script.targets = [tmp_path / "new.ffdproj"]
    ready.trigger("file.save_as")
    ready.idle()
    assert ready.window.studio.settings.recent()[:2] == [tmp_path / "new.ffdproj", cube]


# ---- the tree ---------------------------------------------------------------------------


def test_the_tree_hides_bodies_and_markers_by_commands(ready):
    tree, document = ready.window.tree, ready.window.document
    body = tree.topLevelItem(0)
    assert [body.child(k).text(0) for k in range(body.childCount())] == ["low", "high"]
    body.child(0).setCheckState(0, Qt.CheckState.Unchecked)
    assert document.model.bodies[0].hidden_markers == {"low"}
    tree.topLevelItem(0).setCheckState(0, Qt.CheckState.Unchecked)
    assert not document.model.bodies[0].visible
    assert labels(ready)[-2:] == ["Hide low", "Hide cube"]
    ready.trigger("view.show_all")
    assert document.model.bodies[0].visible
    assert not document.model.bodies[0].hidden_markers


def test_a_marker_is_shown_alone_by_one_command_also_when_it_was_hidden(ready):
    tree, document = ready.window.tree, ready.window.document
    tree.topLevelItem(0).child(1).setCheckState(0, Qt.CheckState.Unchecked)
    entries = len(labels(ready))
    for _ in range(2):  # the second time there is nothing to do
        tree.menu_of(tree.topLevelItem(0).child(1)).actions()[1].trigger()
        assert document.model.bodies[0].hidden_markers == {"low"}
        assert labels(ready)[entries:] == ["Show high alone"]
    tree.topLevelItem(0).setCheckState(0, Qt.CheckState.Unchecked)
    for _ in range(2):
        ready.trigger("view.show_all")
        assert labels(ready)[entries + 2 :] == ["Show all"]


def test_the_keyboard_stays_on_the_row_of_a_marker(ready):
    tree = ready.window.tree
    tree.topLevelItem(0).setExpanded(True)
    tree.setCurrentItem(tree.topLevelItem(0).child(1))
    for hidden in ({"high"}, set()):
        QTest.keyClick(tree, Qt.Key.Key_Space)
        assert ready.window.document.model.bodies[0].hidden_markers == hidden
        assert tree.currentItem() is tree.topLevelItem(0).child(1)


def test_a_name_that_is_taken_is_refused_and_the_old_one_stays(ready):
    ready.window.tree.topLevelItem(0).setText(0, "Lattice")
    assert "taken" in ready.script.told[0].cause
    assert ready.window.tree.topLevelItem(0).text(0) == "cube"
    ready.window.tree.topLevelItem(0).setText(0, "Cube A")
    assert ready.window.document.model.bodies[0].name == "Cube A"


def test_a_refused_name_is_asked_for_again_and_letters_stay_in_the_tree(ready):
    window, tree = ready.window, ready.window.tree
    window.activateWindow()
    ready.qtbot.waitUntil(window.isActiveWindow)
    tree.setFocus()
    tree.setCurrentItem(tree.topLevelItem(0))
    QTest.keyClick(tree, Qt.Key.Key_F2)
    editor = tree.findChild(QLineEdit)
    editor.clear()
    QTest.keyClick(editor, Qt.Key.Key_Return)
    ready.qtbot.waitUntil(lambda: bool(ready.script.told))
    assert ready.script.told[0].title == "“Rename cube to” did not work"
    ready.qtbot.waitUntil(
        lambda: (
            isinstance(window.focusWidget(), QLineEdit) and tree.isAncestorOf(window.focusWidget())
        )
    )
    editor = window.focusWidget()
    assert editor.text() == "cube"
    QTest.keyClicks(editor, "wings")
    QTest.keyClick(editor, Qt.Key.Key_Return)
    ready.qtbot.waitUntil(lambda: window.document.model.bodies[0].name == "wings")
    assert window.studio.state.mode == "move"


def test_delete_on_a_marker_removes_nothing(ready):
    tree, document = ready.window.tree, ready.window.document
    marker = tree.topLevelItem(0).child(0)
    tree.setCurrentItem(marker)
    marker.setCheckState(0, Qt.CheckState.Unchecked)  # fills the tree anew
    assert tree.currentItem().text(0) == "low"
    QTest.keyClick(tree, Qt.Key.Key_Delete)
    assert len(document.model.bodies) == 1
    tree.setCurrentItem(tree.topLevelItem(0))
    QTest.keyClick(tree, Qt.Key.Key_Delete)
    assert document.model.bodies == ()


def test_a_marker_can_be_what_a_lattice_is_built_around(ready):
    tree = ready.window.tree
    menu = tree.menu_of(tree.topLevelItem(0).child(1))
    menu.actions()[0].trigger()
    assert ready.window.lattice.building
    assert ready.window.lattice.builder.around.currentText() == "cube: high"
    low = ready.window.lattice.builder.draft().lower
    assert 0.4 < low[0] < 1  # the margin of a face is of its own extent


# ---- the builder ------------------------------------------------------------------------


def test_wrong_values_are_explained_beside_their_field_and_nothing_is_made(user, cube):
    user.open(cube)
    user.trigger("lattice.new")
    builder, state = user.window.lattice.builder, user.window.studio.state
    assert state.preview.shape == (6, 4, 4)
    assert user.window.scene.lattices["preview"].count == 96
    builder.degrees[1].setValue(7)
    assert "8 points" in builder.notes["direction 1"].text()
    assert builder.notes["direction 1"].isVisible()
    assert not builder.make.isEnabled()
    assert state.preview is None
    builder.degrees[1].setValue(2)
    assert not builder.notes["direction 1"].isVisible()
    QTest.mouseClick(builder.cancel, LEFT)
    assert user.window.document.model.lattices == ()
    assert "preview" not in user.window.scene.lattices


def test_typed_bounds_take_over_and_the_points_inside_are_counted(user, cube):
    user.open(cube)
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    assert "98" in builder.inside.text()  # all nodes on the surface of 4 x 4 x 4 cells
    field = builder.high[0]
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.3")
    assert builder.around.currentText() == "Everything"  # the other bounds stay laid around it
    assert builder.inside.text().startswith("41 of 98")  # a face of 25 and a ring of 16


def test_an_undeformed_lattice_is_fitted_anew_and_keeps_its_place_in_the_tree(ready):
    ready.trigger("lattice.refit")
    builder = ready.window.lattice.builder
    builder.counts[2].setValue(5)
    QTest.mouseClick(builder.make, LEFT)
    ready.idle()
    assert ready.lattice.rest.shape == (4, 4, 5)
    assert len(ready.window.document.model.lattices) == 1


def test_the_number_of_a_new_knot_is_typed_at_once(ready):
    def look(dialog):
        dialog.show()
        assert dialog.focusWidget() is dialog.place
        QTest.keyClicks(dialog.place, "0.3")
        return dialog.knot == 0.3

    ready.script.dialogs = [look]
    ready.trigger("lattice.insert_knot")
    assert ready.lattice.rest.shape == (5, 4, 4)


def test_the_lattice_that_is_being_built_has_its_letters(user, cube):
    user.open(cube)
    user.trigger("lattice.new")
    user.painted()
    letters = user.window.viewport.overlay.layers["labels"]
    assert [shape.lines[0] for shape in letters] == ["i", "j", "k"]
    user.window.lattice.builder.stop()
    assert not user.window.viewport.overlay.layers["labels"]


def test_names_keep_their_capitals_in_messages(user, cube):
    user.open(cube)
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    builder.counts[0].setValue(400)
    for box in builder.counts[1:]:
        box.setValue(60)
    assert builder.notes["direction 0"].text().startswith("1,440,000 points")


def test_an_empty_scene_says_what_to_do(user, cube):
    hint = user.window.tree._hint
    assert hint.isVisible()
    assert "Ctrl+O" in hint.text()
    user.open(cube)
    assert not hint.isVisible()


def test_a_mesh_is_not_written_over_its_own_source_unasked(ready, cube, tmp_path):
    before = cube.read_bytes()
    start = ready.at((1, 2, 2))
    ready.drag(start, start + QPoint(30, 30))
    ready.script.targets, ready.script.answers = [cube], ["cancel"]
    ready.trigger("file.export_mesh")
    ready.idle()
    assert cube.read_bytes() == before
    ready.script.targets = [cube, tmp_path / "other.su2"]
    ready.script.answers = ["other"]
    ready.trigger("file.export_mesh")
    ready.idle()
    assert cube.read_bytes() == before != (tmp_path / "other.su2").read_bytes()


def test_the_builder_falls_back_to_everything_when_its_body_goes(user, cube, square):
    user.open(cube)
    user.open(square)
    tree, document = user.window.tree, user.window.document
    tree.menu_of(tree.topLevelItem(1)).actions()[0].trigger()
    builder = user.window.lattice.builder
    assert builder.around.currentText() == "square"
    user.trigger("edit.undo")  # its opening
    offered = [builder.around.itemText(k) for k in range(builder.around.count())]
    assert offered == ["Everything", "cube", "cube: low", "cube: high", "Typed bounds"]
    assert builder.around.currentText() == "Everything"
    before = builder.draft().lower
    assert len(set(before)) == 1
    QTest.keyClick(builder.margin, Qt.Key.Key_Up)
    assert builder.draft().lower == pytest.approx((before[0] - 0.01, *before[1:]))
    user.trigger("edit.redo")
    assert builder.around.findText("square") > 0
    document.do(c.Rename(document.model.bodies[0].key, "block"))
    assert builder.around.findText("block: low") > 0


def opened_form(user):
    user.window.activateWindow()
    user.qtbot.waitUntil(user.window.isActiveWindow)
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    user.qtbot.waitUntil(builder.around.hasFocus)
    return builder


@pytest.mark.parametrize("field", ["name", "around", "margin", "rotated", "counts", "low"])
def test_return_creates_and_escape_cancels_from_every_field(user, cube, field):
    user.open(cube)
    window, lattices = user.window, lambda: len(user.window.document.model.lattices)
    for key, count in ((Qt.Key.Key_Escape, 0), (Qt.Key.Key_Return, 1)):
        builder = opened_form(user)
        widget = getattr(builder, field)
        widget = widget[0] if isinstance(widget, list) else widget
        widget.setFocus()
        QTest.keyClick(widget, key)
        assert not window.lattice.building
        assert lattices() == count
        assert window.viewport.hasFocus()


def test_keys_on_the_buttons_of_the_form_do_what_the_buttons_say(user, cube):
    user.open(cube)
    window = user.window
    for key, button in ((Qt.Key.Key_Return, "cancel"), (Qt.Key.Key_Escape, "make")):
        widget = getattr(opened_form(user), button)
        widget.setFocus()
        QTest.keyClick(widget, key)
        assert not window.lattice.building
        assert window.document.model.lattices == ()
    widget = opened_form(user).make
    widget.setFocus()
    QTest.keyClick(widget, Qt.Key.Key_Return)
    assert len(window.document.model.lattices) == 1


def test_return_makes_no_lattice_while_something_is_wrong(user, cube):
    user.open(cube)
    builder = opened_form(user)
    builder.degrees[1].setValue(7)
    QTest.keyClick(builder.degrees[1], Qt.Key.Key_Return)
    assert user.window.lattice.building
    assert user.window.document.model.lattices == ()


def test_typed_bounds_stay_when_bodies_come_and_go(user, cube, square):
    user.open(cube)
    user.trigger("lattice.new")
    builder = user.window.lattice.builder
    type_into(builder.high[0], "0.3")
    user.open(square)
    assert builder.around.currentText() == "Everything"
    assert builder.draft().upper[0] == 0.3


def test_the_form_closes_when_the_lattice_it_refits_is_gone(ready):
    ready.trigger("lattice.refit")
    assert ready.window.lattice.building
    ready.trigger("edit.undo")  # its making
    assert not ready.window.lattice.building
    assert ready.window.studio.state.preview is None


def test_refinement_keeps_what_is_displayed(ready):
    document, key = ready.window.document, ready.window.document.model.bodies[0].key
    start = ready.at((1, 2, 2))
    ready.drag(start, start + QPoint(30, 30))
    before = document.points(key).copy()
    ready.trigger("lattice.elevate_i")

    def insert(dialog):
        dialog.direction.setCurrentIndex(2)
        dialog.place.setText("0.25")
        dialog.place.textEdited.emit("0.25")
        return True

    ready.script.dialogs = [insert]
    ready.trigger("lattice.insert_knot")
    ready.idle()
    assert ready.lattice.rest.degrees[0] == 4
    assert ready.lattice.rest.shape[2] == 5
    assert np.abs(document.points(key) - before).max() < 1e-12


def test_too_many_frozen_layers_are_refused_beside_the_field(ready):
    summary = ready.window.lattice.summary
    summary.frozen.setValue(1)
    assert ready.lattice.frozen == 1
    summary.frozen.setValue(2)
    assert "At most 1 layer leaves" in summary.problem.text()
    assert summary.frozen.value() == 1


def test_freezing_says_how_many_points_it_puts_back(ready):
    document, summary = ready.window.document, ready.window.lattice.summary
    document.do(c.MovePoints("lattice2", ((0, 0, 0), (1, 1, 1)), ((0, 0, -1), (0.3, 0.3, 0.4))))
    summary.frozen.setValue(1)
    assert summary.problem.text().startswith("1 point went back to rest")
    assert labels(ready)[-1] == "Freeze 1 layer, reset 1 point"


# ---- points by number -------------------------------------------------------------------


def type_into(field, text):
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)


def test_positions_displacements_and_weights_can_be_typed_for_many(ready):
    points, lattice = ready.window.points, ready.window.document
    lattice.select([(1, 1, 1), (2, 1, 1)])
    assert points.position.edits[0].placeholderText() == "mixed"
    type_into(points.position.edits[2], "0.7")
    current = ready.lattice.current.control_points
    assert (current[[1, 2], 1, 1, 2] == 0.7).all()
    type_into(points.displacement.edits[0], "0.1")
    moved = ready.lattice.current.control_points - ready.lattice.rest.control_points
    assert moved[[1, 2], 1, 1, 0] == pytest.approx([0.1, 0.1])
    type_into(points.by.edits[0], "0.1")
    moved = ready.lattice.current.control_points - ready.lattice.rest.control_points
    assert moved[[1, 2], 1, 1, 0] == pytest.approx([0.2, 0.2])
    type_into(points.weight, "2.5")
    assert (ready.lattice.current.weights[[1, 2], 1, 1] == 2.5).all()
    assert labels(ready)[2:] == ["Move 2 points"] * 3 + ["Weight of 2 points"]


def test_points_that_were_moved_alike_have_one_displacement(ready):
    ready.window.document.select([(1, 1, 1), (2, 2, 2), (1, 2, 1)])
    points = ready.window.points
    for _ in range(3):
        type_into(points.by.edits[0], "0.1")
    item = ready.lattice
    moved = (item.current.control_points - item.rest.control_points)[..., 0]
    assert moved[1, 1, 1] != moved[2, 2, 2]  # the last digits are not the same
    assert points.displacement.values[0] == pytest.approx(0.3)
    assert points.position.edits[0].placeholderText() == "mixed"


@pytest.mark.parametrize(
    ("text", "word"), [("two", "number"), ("-1", "positive"), ("inf", "finite")]
)
def test_a_wrong_weight_is_explained_below_and_changes_nothing(ready, text, word):
    ready.window.document.select([(1, 1, 1)])
    type_into(ready.window.points.weight, text)
    assert word in ready.window.points.problem.text()
    assert not ready.lattice.deformed


def test_the_weight_slider_is_one_entry_a_drag(ready):
    ready.window.document.select([(1, 1, 1)])
    slider = ready.window.points.slider
    slider.setSliderDown(True)
    for value in (10, 30, 50):
        slider.setValue(value)
        assert ready.lattice.current.weights[1, 1, 1] == pytest.approx(10 ** (value / 100))
    slider.setSliderDown(False)
    assert labels(ready)[2:] == ["Weight of point (1, 1, 1)"]


# ---- selecting, history, transform ------------------------------------------------------


def test_rows_planes_all_invert_grow_and_the_rubber_band(ready):
    document = ready.window.document
    ready.click(ready.at((1, 1, 3)))
    assert document.selection == {(1, 1, 3)}
    ready.trigger("select.row_i")
    assert document.selection == {(i, 1, 3) for i in range(4)}
    ready.trigger("select.plane_j")
    assert len(document.selection) == 16
    ready.trigger("select.invert")
    assert len(document.selection) == 48
    ready.trigger("select.none")
    ready.trigger("select.all")
    assert len(document.selection) == 64
    ready.trigger("select.box_mode")
    size = ready.window.viewport.size()
    ready.drag(QPoint(5, 5), QPoint(size.width() - 5, size.height() // 2))
    assert 0 < len(document.selection) < 64
    ready.trigger("select.grow")
    QTest.keyClick(ready.window.viewport, Qt.Key.Key_Escape)
    assert ready.window.studio.state.mode == "move"


def test_arrow_keys_nudge_the_selection(ready):
    ready.click(ready.at((1, 1, 3)))
    QTest.keyClick(ready.window.viewport, Qt.Key.Key_Up)
    moved = ready.lattice.current.control_points - ready.lattice.rest.control_points
    assert moved[1, 1, 3, 2] > 0
    assert labels(ready)[-1] == "Move point (1, 1, 3)"


def test_arrow_keys_nudge_after_a_button_and_select_all(ready):
    window = ready.window
    window.activateWindow()
    ready.qtbot.waitUntil(window.isActiveWindow)
    raiser = window.lattice.summary.raisers[0]
    raiser.setFocus()
    QTest.keyClick(raiser, Qt.Key.Key_A)
    assert window.viewport.hasFocus()
    QTest.keyClick(window.focusWidget(), Qt.Key.Key_Up)
    assert labels(ready)[-1] == "Move 64 points"


def test_the_history_is_a_list_to_jump_in(ready):
    start = ready.at((1, 2, 2))
    ready.drag(start, start + QPoint(30, 30))
    history = ready.window.history
    assert [history.item(k).text() for k in range(history.count())] == ["Beginning", *labels(ready)]
    place = history.visualItemRect(history.item(2)).center()
    QTest.mouseClick(history.viewport(), LEFT, Qt.KeyboardModifier.NoModifier, place)
    assert not ready.lattice.deformed
    assert ready.window.document.history.position == 2
    assert history.currentRow() == 2


@pytest.mark.parametrize("accept", [True, False])
def test_typed_transformations_are_seen_at_once_and_kept_or_not(ready, accept):
    ready.window.document.select([(1, 1, 1), (2, 1, 1)])

    def turn(dialog):
        dialog.angle.setValue(90)
        assert ready.lattice.deformed  # seen while it is typed
        return accept

    ready.script.dialogs = [turn]
    ready.trigger("edit.transform")
    assert ready.lattice.deformed is accept
    assert ready.window.document.editing is None


def test_typed_transformations_take_along_what_is_opposite(ready):
    ready.window.document.select([(1, 1, 1)])
    ready.window.tools.options = Options(mirror=Mirror(1, 0.5))

    def shift(dialog):
        assert dialog.follow.text() == "Points opposite the plane y = 0.5 follow."
        type_into(dialog.move_by.edits[1], "0.1")
        return True

    ready.script.dialogs = [shift]
    ready.trigger("edit.transform")
    moved = ready.lattice.current.control_points - ready.lattice.rest.control_points
    assert moved[1, 1, 1] == pytest.approx([0, 0.1, 0])
    assert moved[1, 2, 1] == pytest.approx([0, -0.1, 0])
    assert np.count_nonzero(moved) == 2


def test_the_points_panel_says_that_numbers_move_the_selected_points_only(ready):
    points = ready.window.points
    ready.window.document.select([(1, 1, 1)])
    assert points.alone.isHidden()
    ready.trigger("edit.mirror_y")
    assert not points.alone.isHidden()
    ready.trigger("edit.mirror_off")
    assert points.alone.isHidden()


def test_the_points_panel_follows_a_drag(ready):
    start = ready.at((1, 2, 2))
    ready.begin(start, start + QPoint(30, 30))
    shown = ready.window.points.displacement
    ready.qtbot.waitUntil(lambda: any(shown.values), timeout=5000)
    QTest.keyClick(ready.window.viewport, Qt.Key.Key_Escape)
    assert shown.values == [0, 0, 0]


def test_a_flat_mesh_offers_no_number_that_leads_out_of_its_plane(user, square):
    user.open(square)
    user.build((4, 4))
    user.window.document.select([(1, 1)])
    panel = user.window.points
    for field in (panel.position, panel.displacement, panel.by):
        assert [edit.isEnabled() for edit in field.edits] == [True, True, False]

    def look(dialog):
        assert not dialog.move_by.edits[2].isEnabled()
        assert not dialog.scale.edits[2].isEnabled()
        assert not dialog.axis.isEnabled()
        assert dialog.axis.currentText() == "about Z"
        return False

    user.script.dialogs = [look]
    user.trigger("edit.transform")
    assert user.script.dialogs == []


def test_soft_selection_and_symmetry_reach_the_tools(ready):
    ready.trigger("edit.soft")
    ready.trigger("edit.mirror_y")
    options = ready.window.tools.options
    assert options.soft.radius > 0
    assert options.mirror.axis == 1
    ready.trigger("edit.mirror_off")
    assert ready.window.tools.options.mirror is None


# ---- views ------------------------------------------------------------------------------


def test_ghost_section_edges_and_inside_are_switches(ready):
    scene, state = ready.window.scene, ready.window.studio.state
    actor = next(iter(scene.bodies.values()))
    ready.trigger("view.ghost")
    assert ready.window.scene.ghost.parts[0].faces.GetVisibility()
    ready.trigger("view.inside")
    assert actor._dot_data.GetNumberOfVerts() == 98
    ready.trigger("view.edges")
    assert not actor.full.faces.GetProperty().GetEdgeVisibility()
    ready.trigger("view.section")
    ready.idle()
    assert state.shown.section is not None
    assert ready.window.section_bar.isVisible()
    ready.window.section_bar.place.setValue(60)
    ready.idle()
    cut = next(iter(ready.window.sections.actors.values()))
    assert np.ptp(cut.points.array[:, 1]) < 1e-6
    ready.trigger("view.section")
    assert ready.window.sections.actors == {}


def test_axis_views_look_along_the_axes(ready):
    for letter, axis in zip("xyz", np.eye(3), strict=True):
        ready.trigger(f"view.plus_{letter}")
        assert (ready.window.viewport.view.back == axis).all()
        ready.trigger(f"view.minus_{letter}")
        assert (ready.window.viewport.view.back == -axis).all()


def test_a_section_begins_at_the_wing_and_can_be_typed(user, root):
    user.open(root / "sample_meshes" / "wing_air.su2")
    user.trigger("view.section")
    user.idle()
    bar, state = user.window.section_bar, user.window.studio.state
    assert state.shown.section.at == pytest.approx(1.25)  # half the span; the air goes on
    assert bar.number.value == state.shown.section.at
    type_into(bar.number, "0,25")
    user.idle()
    (cut,) = user.window.sections.actors.values()
    assert np.ptp(cut.points.array[:, 1]) < 1e-6
    assert state.shown.section.at == 0.25
    bar.axis.setCurrentIndex(0)
    bar.axis.activated.emit(0)
    assert 0 < state.shown.section.at < 3
    assert bar.letter.text().strip() == "x ="


def test_a_side_view_keeps_what_is_looked_at_and_how_near(user, root):
    user.open(root / "sample_meshes" / "wing_air.su2")
    before = user.window.viewport.view
    user.trigger("view.plus_y")
    after = user.window.viewport.view
    assert (after.back == [0, 1, 0]).all()
    assert (after.focal == before.focal).all()
    assert after.distance == before.distance


def test_the_command_palette_finds_and_runs(ready):
    def choose(palette):
        QTest.keyClicks(palette.line, "degree in")
        QTest.keyClick(palette.line, Qt.Key.Key_Down)
        QTest.keyClick(palette.line, Qt.Key.Key_Return)
        return palette.chosen is not None

    ready.script.dialogs = [choose]
    ready.trigger("help.palette")
    assert ready.lattice.rest.degrees == (3, 4, 3)


@pytest.mark.parametrize(
    ("typed", "label"),
    [
        ("ghost", "View: Undeformed shape"),
        ("theme dark", "View: Theme: Dark"),
        ("symmetry off", "Edit: Symmetry: Off"),
        ("cube recent", "File: Open recent: cube.su2"),
        ("wing in air", "File: Examples: Wing in air: Volume mesh around the wing"),
        ("panels points", "View: Panels: Points"),
        ("qqqq", None),
    ],
)
def test_the_command_palette_searches_submenus_tips_files_and_panels(ready, typed, label):
    def look(palette):
        QTest.keyClicks(palette.line, typed)
        first = palette.list.topLevelItem(0)
        assert (first and first.text(0)) == label
        assert palette.nothing.isHidden() is (label is not None)
        return False

    ready.script.dialogs = [look]
    ready.trigger("help.palette")


def test_themes_change_at_once_and_are_remembered(ready):
    ready.trigger("view.dark")
    assert ready.window.studio.theme.name == "dark"
    assert ready.window.studio.settings.text("theme", "") == "dark"
    ready.idle()
    corner = ready.window.viewport.grabFramebuffer().pixelColor(3, 3)
    assert corner.lightness() < 80
    ready.trigger("view.light")


# ---- keyboard ---------------------------------------------------------------------------


def test_every_control_can_be_reached_by_tab(ready):
    ready.window.document.select([(1, 1, 1)])
    window = ready.window
    reached, widget = set(), window.focusWidget() or window.viewport
    for _ in range(500):
        widget = widget.nextInFocusChain()
        if widget.focusPolicy() & Qt.FocusPolicy.TabFocus:
            reached.add(widget)
    for panel in (window.tree, window.points, window.lattice, window.viewport):
        kinds = (QLineEdit, QAbstractSpinBox, QComboBox, QAbstractButton)
        controls = [c for kind in kinds for c in panel.findChildren(kind) if c.isVisible()]
        inner = [c for c in controls if not isinstance(c.parent(), QAbstractSpinBox)]
        assert all(c in reached for c in inner if c.objectName() != "qt_toolbar_ext_button"), [
            c for c in inner if c not in reached
        ]


def test_tab_leaves_the_picture(ready):
    view = ready.window.viewport
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_Tab)
    assert not view.hasFocus()


def test_a_body_follows_its_walls_by_a_tick_in_its_menu(ready):
    tree, document = ready.window.tree, ready.window.studio.document
    [tick] = [a for a in tree.menu_of(tree.topLevelItem(0)).actions() if a.isCheckable()]
    assert tick.text() == "Volume follows the walls"
    assert not tick.isChecked()
    tick.trigger()
    assert document.model.bodies[0].follows == "walls"
    [tick] = [a for a in tree.menu_of(tree.topLevelItem(0)).actions() if a.isCheckable()]
    assert tick.isChecked()
    document.undo()
    assert document.model.bodies[0].follows == "lattice"
