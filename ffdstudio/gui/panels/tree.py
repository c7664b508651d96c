"""The tree of bodies with their markers, and lattices: names, visibility, what is active."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QPoint, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QColor, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QColorDialog,
    QHeaderView,
    QMenu,
    QTreeWidget,
    QTreeWidgetItem,
)

from ffdstudio.gui.panels.fields import note
from ffdstudio.gui.resources import icon
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.ways import Way
from ffdstudio.project import commands as c
from ffdstudio.project.model import Body, LatticeItem
from ffdstudio.project.view.volume import countable

EMPTY = "Nothing is open yet. Open a mesh (Ctrl+O), drop files into the window, or try an example."
WALLS_TIP = (
    "The lattices move the walls alone, and the volume follows them: boundary layers keep their "
    "heights, also where a lattice is tight or cuts the mesh. While you drag, all nodes are shown "
    "as the lattice carries them."
)
KEY, MARKER = Qt.ItemDataRole.UserRole, Qt.ItemDataRole.UserRole + 1
Place = tuple[str, str | None]
CHECKABLE = Qt.ItemFlag.ItemIsUserCheckable


class TreePanel(QTreeWidget):
    """Mirrors the model; every change becomes a command."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._filling = False
        self._open: set[str] = set()
        self.lattice_around: Callable[[str, str], None] = lambda key, marker: None
        self.setAccessibleName("Bodies, markers and lattices")
        self.setColumnCount(2)
        self.setHeaderHidden(True)
        self.setUniformRowHeights(True)
        self.setIconSize(QSize(16, 16))
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.header().setStretchLastSection(False)
        self.header().setMinimumSectionSize(20)
        self.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.customContextMenuRequested.connect(self._on_menu)
        self.itemChanged.connect(self._on_item_changed)
        self.itemDoubleClicked.connect(self._on_double_click)
        self.itemExpanded.connect(lambda item: self._open.add(item.data(0, KEY)))
        self.itemCollapsed.connect(lambda item: self._open.discard(item.data(0, KEY)))
        self._hint = note(EMPTY)
        self._hint.setParent(self.viewport())
        self._hint.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._hint.setMargin(9)
        self._listening = Listening((studio.document.structure_changed, self.fill))
        self.fill()

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, _theme: Theme) -> None:
        """Draw the icons anew."""
        self.fill()

    @property
    def chosen_key(self) -> str | None:
        """Key of the body or lattice that is marked, or that the marked marker belongs to."""
        item = self.currentItem()
        return None if item is None else item.data(0, KEY)

    def chosen_body(self) -> Body | None:
        """Body that is marked."""
        bodies = {body.key: body for body in self._studio.document.model.bodies}
        return bodies.get(self.chosen_key or "")

    # ---- filling ----------------------------------------------------------------------------

    def fill(self) -> None:
        """Show the model.

        Rows are kept as long as they stand for the same things: a change of a row is told from
        inside Qt's code for that row, which crashes if the row is gone when it goes on. The
        keyboard and the scroll bar so keep their places, too.
        """
        self._filling = True
        wanted = self._wanted()
        if [_place_of(item) for item in self._rows()] != wanted:
            self._build(wanted)
        self._dress()
        self._filling = False
        self._hint.setVisible(not wanted)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._hint.setGeometry(self.viewport().rect())

    def _wanted(self) -> list[Place]:
        """Key of each row, and marker of those below a body."""
        model, found = self._studio.document.model, []
        for body in model.bodies:
            found += [(body.key, None), *((body.key, name) for name in body.mesh.marker_counts)]
        return found + [(lattice.key, None) for lattice in model.lattices]

    def _rows(self) -> list[QTreeWidgetItem]:
        """All rows from top to bottom, folded ones too."""
        found = []
        for number in range(self.topLevelItemCount()):
            top = self.topLevelItem(number)
            assert top is not None
            found.append(top)
            found += [child for k in range(top.childCount()) if (child := top.child(k))]
        return found

    def _build(self, places: list[Place]) -> None:
        """Make all rows anew; the same one is marked again, or the one it belonged to."""
        chosen, there = _place_of(self.currentItem()), self.verticalScrollBar().value()
        self.clear()
        parent = None
        for key, marker in places:
            item = QTreeWidgetItem()
            item.setData(0, KEY, key)
            item.setData(0, MARKER, marker)
            item.setTextAlignment(1, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            if marker is None or parent is None:
                parent = item
                self.addTopLevelItem(item)
            else:
                parent.addChild(item)
            if (key, marker) in (chosen, (chosen[0], None)):
                self.setCurrentItem(item)
        for item in self._rows():
            item.setExpanded(item.data(0, MARKER) is None and item.data(0, KEY) in self._open)
        self.verticalScrollBar().setValue(there)

    def _dress(self) -> None:
        """Write and colour all rows."""
        model, theme = self._studio.document.model, self._studio.theme
        bodies = {body.key: body for body in model.bodies}
        for item in self._rows():
            key, marker = _place_of(item)
            if marker is not None:
                self._dress_marker(item, bodies[key], marker)
            elif key in bodies:
                self._dress_body(item, bodies[key], theme)
            else:
                self._dress_lattice(item, model.lattice(key), key == model.active, theme)

    def _write(self, item: QTreeWidgetItem, name: str, note: str, visible: bool) -> None:
        item.setText(0, name)
        item.setText(1, note)
        item.setFlags(item.flags() | CHECKABLE | Qt.ItemFlag.ItemIsEditable)
        item.setCheckState(0, Qt.CheckState.Checked if visible else Qt.CheckState.Unchecked)
        item.setForeground(1, QColor(self._studio.theme["muted"]))

    def _dress_body(self, item: QTreeWidgetItem, body: Body, theme: Theme) -> None:
        self._write(item, body.name, count_text(len(body.mesh.points)), body.visible)
        item.setIcon(0, icon("cube", body.colour or theme["mesh"]))
        item.setToolTip(0, f"{body.path}\n{len(body.mesh.points)} nodes")

    def _dress_marker(self, item: QTreeWidgetItem, body: Body, name: str) -> None:
        count = body.mesh.marker_counts[name]
        self._write(item, name, count_text(count), name not in body.hidden_markers)
        item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
        item.setToolTip(0, f"Marker {name}: {count} boundary elements")

    def _dress_lattice(
        self, item: QTreeWidgetItem, lattice: LatticeItem, active: bool, theme: Theme
    ) -> None:
        note = "×".join(str(n) for n in lattice.rest.shape)
        self._write(item, lattice.name, note, lattice.visible)
        colour = theme["selected"] if active else theme["muted"]
        item.setIcon(0, icon("grid" if lattice.enabled else "grid-off", colour))
        font = item.font(0)
        font.setBold(active)
        item.setFont(0, font)
        state = "being edited" if active else "double click to edit it"
        item.setToolTip(0, f"Lattice {lattice.name}: {state}")

    # ---- what the user does -----------------------------------------------------------------

    def _on_item_changed(self, item: QTreeWidgetItem, column: int) -> None:
        if self._filling or column != 0:
            return
        key, marker = item.data(0, KEY), item.data(0, MARKER)
        visible = item.checkState(0) == Qt.CheckState.Checked
        model = self._studio.document.model
        command: c.Command
        if marker is not None:
            command = c.ShowMarkers(key, (marker,), visible)
        elif visible != model.item(key).visible:
            command = c.Show((key,), visible)
        elif item.text(0) != model.item(key).name:
            command = c.Rename(key, item.text(0))
        else:
            return
        if not self._studio.do(command):
            self.fill()
            if isinstance(command, c.Rename):  # after the editor that has just been closed
                QTimer.singleShot(0, self, lambda: self._rename(key))

    def _rename(self, key: str) -> None:
        """Ask for a name again, with the keyboard here: letters would be commands elsewhere."""
        for item in self._rows():
            if _place_of(item) == (key, None):
                self.setFocus(Qt.FocusReason.OtherFocusReason)
                self.setCurrentItem(item)
                self.editItem(item, 0)

    def _on_double_click(self, item: QTreeWidgetItem) -> None:
        key = item.data(0, KEY)
        if any(lattice.key == key for lattice in self._studio.document.model.lattices):
            self._studio.do(c.Activate(key))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        item = self.currentItem()
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and item is not None:
            self._on_double_click(item)
        elif event.key() == Qt.Key.Key_Delete and item is not None:
            if item.data(0, MARKER) is None:  # a marker is part of its mesh
                self._studio.do(c.Remove(item.data(0, KEY)))
        else:
            super().keyPressEvent(event)

    def _on_menu(self, place: QPoint) -> None:
        item = self.itemAt(place) or self.currentItem()
        if item is not None:
            self.menu_of(item).popup(self.viewport().mapToGlobal(place))

    def menu_of(self, item: QTreeWidgetItem) -> QMenu:
        """Context menu of a row."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        key, marker = item.data(0, KEY), item.data(0, MARKER)
        do: Callable[[Any], object] = self._studio.do

        def add(text: str, action: Callable[[], object]) -> None:
            new = QAction(text, menu)
            new.triggered.connect(lambda: action())
            menu.addAction(new)

        if marker is not None:
            add("Lattice around this marker…", lambda: self.lattice_around(key, marker))
            add("Show this marker alone", lambda: self._only(key, marker))
            return menu
        if any(body.key == key for body in self._studio.document.model.bodies):
            add("Lattice around this body…", lambda: self.lattice_around(key, ""))
            add("Isolate", lambda: do(c.Isolate(key)))
            add("Colour…", lambda: self._ask_colour(key))
            self._add_way(menu, key)
        else:
            on = self._studio.document.model.lattice(key).enabled
            add("Edit this lattice", lambda: do(c.Activate(key)))
            add("Switch off" if on else "Switch on", lambda: do(c.Enable(key, not on)))
        add("Rename", lambda: self.editItem(item, 0))
        add("Remove", lambda: do(c.Remove(key)))
        return menu

    def _add_way(self, menu: QMenu, key: str) -> None:
        """A tick: the lattices move the walls of a body alone, and its volume follows them."""
        body = self._studio.document.model.body(key)
        new = QAction("Volume follows the walls", menu)
        new.setCheckable(True)
        new.setChecked(body.follows == Way.WALLS)
        new.setEnabled(countable(body.mesh))
        new.setToolTip(WALLS_TIP)
        new.triggered.connect(
            lambda on: self._studio.do(c.Follow(key, Way.WALLS if on else Way.LATTICE))
        )
        menu.addAction(new)
        menu.setToolTipsVisible(True)

    def _only(self, key: str, marker: str) -> None:
        body = self._studio.document.model.body(key)
        others = frozenset(body.mesh.markers) - {marker}
        if not body.visible or body.hidden_markers != others:
            self._studio.do(c.IsolateMarker(key, marker))

    def _ask_colour(self, key: str) -> None:
        body = self._studio.document.model.body(key)
        dialog = QColorDialog(QColor(body.colour or self._studio.theme["mesh"]), self)
        dialog.setWindowTitle(f"Colour of {body.name}")
        if self._studio.asker.run(dialog):
            self._studio.do(c.Colour(key, dialog.currentColor().name()))


def _place_of(item: QTreeWidgetItem | None) -> Place:
    """Key and marker of a row."""
    return ("", None) if item is None else (item.data(0, KEY), item.data(0, MARKER))


def count_text(count: int) -> str:
    """Short form of a count.

    Examples
    --------
    >>> count_text(950), count_text(12_345), count_text(1_234_567)
    ('950', '12.3 k', '1.23 M')
    """
    if count < 1000:
        return str(count)
    if count < 1_000_000:
        return f"{count / 1000:.3g} k"
    return f"{count / 1_000_000:.3g} M"
