"""Alt and a letter: those of the menus open menus, whatever panels are there."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QDockWidget, QGroupBox, QLabel

from ffdstudio.gui.action_table import MENUS, ROWS

pytestmark = pytest.mark.display


def letter(text):
    return QKeySequence.mnemonic(text).toString()


MENU_LETTERS = [letter(menu) for menu in MENUS]


def test_every_menu_has_a_letter_of_its_own_that_is_no_shortcut():
    assert "" not in MENU_LETTERS
    assert len(set(MENU_LETTERS)) == len(MENUS)
    assert not {QKeySequence(key).toString() for row in ROWS for key in row.keys} & {*MENU_LETTERS}


def in_panels(window):
    """Texts of all that has a mnemonic in the docks, of pages that are not shown, too."""
    for dock in window.findChildren(QDockWidget):
        for label in dock.findChildren(QLabel):
            if label.buddy() is not None:
                yield label.text()
        for button in dock.findChildren(QAbstractButton):
            yield button.text()
        for box in dock.findChildren(QGroupBox):
            yield box.title()


def test_no_panel_takes_the_letter_of_a_menu(same_user, cube):
    window = same_user.window
    texts = [*in_panels(window)]
    same_user.open(cube)
    same_user.build()
    same_user.trigger("lattice.refit")
    texts += in_panels(window)
    assert sum(bool(letter(text)) for text in texts) > 20
    assert [text for text in texts if letter(text) in MENU_LETTERS] == []


@pytest.mark.parametrize("menu", MENUS)
def test_alt_and_its_letter_open_a_menu(same_user, cube, menu):
    window = same_user.window
    same_user.open(cube)
    same_user.trigger("lattice.new")
    window.activateWindow()
    same_user.qtbot.waitUntil(window.isActiveWindow)
    wanted = window.actions_.menus[menu]
    key = Qt.Key(ord(letter(menu)[-1]))
    QTest.keyClick(window.lattice.builder.margin, key, Qt.KeyboardModifier.AltModifier)
    same_user.qtbot.waitUntil(wanted.isVisible)
    QTest.keyClick(wanted, Qt.Key.Key_Escape)
    same_user.qtbot.waitUntil(lambda: not wanted.isVisible())
