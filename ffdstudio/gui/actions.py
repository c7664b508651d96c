"""Menus, toolbar and shortcuts made from the action table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QSize
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu, QToolBar

from ffdstudio.gui.action_table import MENUS, ROWS, ActionRow
from ffdstudio.gui.resources import icon
from ffdstudio.gui.theme import Theme
from ffdstudio.project.view.volume import countable

if TYPE_CHECKING:
    from ffdstudio.project.document import Document

NATIVE = QKeySequence.SequenceFormat.NativeText


def conditions(document: Document) -> dict[str, bool]:
    """Which of the conditions that rows need hold now."""
    model = document.model
    active = model.active_lattice
    volume = any(body.mesh.dimension == 3 for body in model.bodies)
    solid = active is not None and active.rest.dimension == 3
    return {
        "": True,
        "anything": bool(model.bodies or model.lattices),
        "body": bool(model.bodies),
        "bodies": len(model.bodies) > 1,
        "volume body": any(b.mesh.dimension == 3 and countable(b.mesh) for b in model.bodies),
        "volume scene": volume or (bool(model.lattices) and not model.bodies),
        "lattice": active is not None,
        "lattices": len(model.lattices) > 1,
        "volume lattice": solid,
        "box lattice": active is not None and not active.deformed,
        "selection": bool(document.selection),
        "volume selection": bool(document.selection) and solid,
        "undo": document.history.undo_label is not None,
        "redo": document.history.redo_label is not None,
    }


class Actions:
    """The `QAction` of each row, in the menus and the toolbar of a window."""

    def __init__(self, window: QMainWindow, run: Callable[[str, bool], None]) -> None:
        self.by_name: dict[str, QAction] = {}
        self.menus: dict[str, QMenu] = {name: window.menuBar().addMenu(name) for name in MENUS}
        self.toolbar = QToolBar("Toolbar", window)
        self.toolbar.setObjectName("toolbar")
        self.toolbar.setIconSize(QSize(20, 20))
        self._groups: dict[str, QActionGroup] = {}
        self._submenus: dict[str, QMenu] = {}
        for row in ROWS:
            self._add(window, row, run)
        window.addToolBar(self.toolbar)

    def _add(self, window: QMainWindow, row: ActionRow, run: Callable[[str, bool], None]) -> None:
        action = QAction(row.text, window)
        action.setObjectName(row.name)
        action.setCheckable(row.check)
        action.setShortcuts([QKeySequence(keys) for keys in row.keys])
        keys = ", ".join(QKeySequence(k).toString(NATIVE) for k in row.keys)
        action.setToolTip(f"{row.plain.rstrip('…')}: {row.tip}" + (f" ({keys})" if keys else ""))
        action.setStatusTip(row.tip + (f"  [{keys}]" if keys else ""))
        action.triggered.connect(lambda on=False, name=row.name: run(name, on))
        if row.group:
            self._groups.setdefault(row.group, QActionGroup(window)).addAction(action)
        self._place(row, action)
        self.by_name[row.name] = action

    def _place(self, row: ActionRow, action: QAction) -> None:
        menu = self.menus[row.menu]
        if row.submenu:
            if row.submenu not in self._submenus:
                self._submenus[row.submenu] = menu.addMenu(row.submenu)
            menu = self._submenus[row.submenu]
        if row.line_before:
            menu.addSeparator()
        menu.addAction(action)
        if row.toolbar:
            if row.line_before:
                self.toolbar.addSeparator()
            self.toolbar.addAction(action)

    @property
    def shortcuts(self) -> list[QKeySequence]:
        """All keys of all actions."""
        return [keys for action in self.by_name.values() for keys in action.shortcuts()]

    def paint_with(self, theme: Theme) -> None:
        """Draw the icons in a theme's colour."""
        for row in ROWS:
            if row.icon:
                self.by_name[row.name].setIcon(icon(row.icon, theme["text"]))

    def enable(self, holds: Mapping[str, bool]) -> None:
        """Enable what the conditions allow."""
        for row in ROWS:
            self.by_name[row.name].setEnabled(holds[row.needs])

    def check(self, name: str, on: bool) -> None:
        """Set the mark of a switch without carrying it out."""
        self.by_name[name].setChecked(on)
