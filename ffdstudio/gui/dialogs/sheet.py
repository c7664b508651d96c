"""The sheet of all keys and mouse moves."""

from __future__ import annotations

from html import escape

from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QTextBrowser, QVBoxLayout, QWidget

from ffdstudio.gui.action_table import MENUS, ROWS

MOUSE: tuple[tuple[str, str], ...] = (
    ("Click a control point", "select it; Shift adds or takes away"),
    ("Drag a control point", "move the selected points in the plane of the picture"),
    ("X, Y, Z during a drag", "lock an axis; Shift+X, Y, Z: lock the plane across it"),
    ("P, then drag the mesh itself", "the lattice is solved for; selected points are held"),
    ("Digits during a drag", "type it: Tab next axis, = for an expression, Return takes it"),
    ("Shift during a drag", "ten times slower"),
    ("Ctrl during a drag", "snap to round steps"),
    ("Esc or right button during a drag", "put everything back"),
    ("Drag the weight handle of a selected point", "change its weight; double click: back to 1"),
    ("Arrow keys", "nudge the selected points along an axis; Shift: ten times finer"),
    ("Drag beside the points, or Alt+drag", "turn about what is under the cursor (2D: shift)"),
    ("Click an end of the axes in the corner", "look from there, in parallel projection"),
    ("Middle button, or Shift+drag beside the points", "shift the view"),
    ("Hold Space", "see everything undeformed, as it was before"),
    ("Wheel, or right button up and down", "come closer or go away"),
)


class ShortcutSheet(QDialog):
    """All rows of the action table that have keys, and what the mouse does."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Shortcuts")
        page = QTextBrowser()
        page.setHtml(sheet())
        layout = QVBoxLayout(self)
        layout.addWidget(page)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        layout.addWidget(buttons)
        self.resize(min(760, parent.width() - 40), min(640, parent.height() - 60))


def sheet() -> str:
    """HTML of the sheet."""
    parts = [_table("Mouse and keys in the picture", MOUSE)]
    for menu in MENUS:
        rows = [(_keys(row.keys), row.tip) for row in ROWS if row.menu == menu and row.keys]
        if rows:
            parts.append(_table(menu.replace("&", ""), rows))
    return "".join(parts)


def _keys(keys: tuple[str, ...]) -> str:
    return ", ".join(QKeySequence(k).toString(QKeySequence.SequenceFormat.NativeText) for k in keys)


def _table(title: str, rows: object) -> str:
    lines = "".join(
        f"<tr><td width='240' style='padding:2px 14px 2px 0'><b>{escape(left)}</b></td>"
        f"<td style='padding:2px 0'>{escape(right)}</td></tr>"
        for left, right in rows  # type: ignore[attr-defined]
    )
    return f"<h3>{escape(title)}</h3><table cellspacing='0'>{lines}</table>"
