"""Section curves in a window: before and now, live, with what they measure."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6")

from ffdstudio.project.interaction import numeric_edits
from ffdstudio.project.interaction.transforms import rotation
from ffdstudio.samples import sample

pytestmark = pytest.mark.display


def test_a_twisted_tip_is_measured_live(user: Any) -> None:
    user.open(sample("wing_skin.vtu"))
    user.build((4, 4, 4))
    user.trigger("view.slices")
    panel = user.window.slices.panel
    user.qtbot.waitUntil(lambda: panel.cut is not None, timeout=20_000)
    panel.place.setValue(380)
    user.qtbot.waitUntil(lambda: panel.measures[0] is not None, timeout=20_000)
    user.idle()
    before, now = panel.measures
    assert before == now
    assert "twist 0°" in panel.text.text()
    document = user.window.document
    document.select([(i, 3, k) for i in range(4) for k in range(4)])
    tip = document.points("body1")
    pivot = tip[np.argmax(tip[:, 1])]
    numeric_edits.transform(document, rotation([0, 1, 0], 10.0, pivot))
    user.idle()
    user.qtbot.waitUntil(lambda: panel.measures[1] != panel.measures[0], timeout=20_000)
    user.idle()
    before, now = panel.measures
    assert 3 < abs(now.angle - before.angle) < 12
    assert now.thickness == pytest.approx(before.thickness, rel=0.3)
