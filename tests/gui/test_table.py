"""The action table: complete, without clashes, and everything of it is there."""

from __future__ import annotations

from collections import Counter

import pytest

pytest.importorskip("PySide6")

from PySide6.QtGui import QKeySequence

from ffdstudio.gui.action_table import ROWS
from ffdstudio.gui.dialogs.palette import score
from ffdstudio.gui.dialogs.sheet import sheet


def test_no_key_means_two_things():
    keys = Counter(QKeySequence(k).toString() for row in ROWS for k in row.keys)
    assert "" not in keys
    assert [key for key, count in keys.items() if count > 1] == []


def test_every_action_has_a_name_of_its_own_and_says_what_it_does():
    assert max(Counter(row.name for row in ROWS).values()) == 1
    assert all(row.tip and row.text for row in ROWS)


def test_the_sheet_has_every_key():
    html = sheet()
    for row in ROWS:
        for key in row.keys:
            assert QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText) in html


def test_mnemonics_of_a_menu_are_distinct():
    places = Counter()
    for row in ROWS:
        if "&" in row.text:
            letter = row.text[row.text.index("&") + 1].lower()
            places[row.menu, row.submenu, letter] += 1
    assert [place for place, count in places.items() if count > 1] == []


def test_the_palette_finds_by_letters_in_order():
    names = ["Export mesh…", "Export lattice…", "Elevate", "Undo"]

    def best(letters):
        fits = [(score(letters, n), n) for n in names if score(letters, n) is not None]
        return min(fits)[1]

    assert best("exm") == "Export mesh…"
    assert best("lat") == "Export lattice…"
    assert score("zz", "Undo") is None


@pytest.mark.display
def test_every_row_can_be_carried_out(user):
    """Each name leads to a method of a handler."""
    window = user.window
    for row in ROWS:
        handler, method = row.name.split(".")
        known = row.name in window._special or callable(getattr(window._handlers[handler], method))
        assert known, row.name
