"""Both looks: every colour there, and enough contrast to read by."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6")

from PySide6.QtWidgets import QCheckBox, QLineEdit

from ffdstudio.gui.theme import ROLES, THEMES, Theme


def luminance(colour):
    """Relative luminance of WCAG 2.1."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    light, dark = sorted([luminance(one), luminance(other)], reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_both_themes_have_the_same_names():
    light, dark = (Theme(name) for name in THEMES)
    assert set(light) == set(dark)
    assert set(ROLES.values()) <= set(light)


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("text", ["text", "muted", "danger", "warning", "good", "link"])
@pytest.mark.parametrize("ground", ["window", "base", "alternate"])
def test_text_is_readable(name, text, ground):
    theme = Theme(name)
    assert contrast(theme[text], theme[ground]) >= 4.5


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("mark", ["point", "selected", "hovered", "frozen", "weighted"])
def test_control_points_stand_out_from_the_background(name, mark):
    theme = Theme(name)
    assert contrast(theme[mark], theme["view_bottom"]) >= 1.8
    assert contrast(theme["view_text"], theme["plate"]) >= 7


@pytest.mark.parametrize("name", THEMES)
def test_the_style_sheet_has_no_name_left(name):
    assert "@" not in Theme(name).stylesheet()


@pytest.mark.parametrize("name", THEMES)
def test_an_unchecked_box_has_an_outline_that_is_seen(name, qtbot):
    theme, box = Theme(name), QCheckBox("Comb")
    qtbot.addWidget(box)
    box.setPalette(theme.palette())
    box.setStyleSheet(theme.stylesheet())
    picture = box.grab().toImage()
    row = [picture.pixelColor(x, picture.height() // 2).name() for x in range(20)]
    assert max(contrast(colour, theme["window"]) for colour in row) >= 3
    assert row.count(theme["muted"].lower()) == 2  # left and right


@pytest.mark.parametrize("name", THEMES)
def test_a_checked_box_has_the_same_outline_and_a_mark(name, qtbot):
    theme, box = Theme(name), QCheckBox("Comb")
    qtbot.addWidget(box)
    box.setPalette(theme.palette())
    box.setStyleSheet(theme.stylesheet())
    box.setChecked(True)
    picture = box.grab().toImage()
    colours = [picture.pixelColor(x, y).name() for x in range(16) for y in range(picture.height())]
    assert colours.count(theme["muted"].lower()) >= 30
    inner = [c for c in colours if contrast(c, theme["base"]) > 7 and c != theme["muted"].lower()]
    assert len(inner) >= 5


@pytest.mark.parametrize("name", THEMES)
def test_a_line_to_type_in_has_an_outline_that_is_seen(name, qtbot):
    theme, line = Theme(name), QLineEdit()
    qtbot.addWidget(line)
    line.setStyleSheet(theme.stylesheet())
    picture = line.grab().toImage()
    assert picture.pixelColor(0, picture.height() // 2).name() == theme["outline"]
    assert contrast(theme["outline"], theme["base"]) >= 2.5
