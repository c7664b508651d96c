"""The line of a drag with the place where the guard would have it end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ffdstudio.gui.overlay import Line, Ring, Shape, Text
from ffdstudio.gui.viewport import Viewport
from ffdstudio.project.checks.guarding import Verdict
from ffdstudio.project.interaction.feedback import Feedback
from ffdstudio.project.interaction.tools import Tools
from ffdstudio.project.view.camera import Camera

TICK = 8.0  # pixels to each side of the line
NEAR = 4.0  # times the drag: a limit beyond that is not drawn
BELOW = 44.0  # pixels below the cursor, where the read-out of the drag is not


class GuardLine:
    """Fills a layer of the overlay while points are dragged."""

    def __init__(self, viewport: Viewport, tools: Tools) -> None:
        self._viewport, self._tools = viewport, tools
        tools.changed.connect(self._on_feedback)
        viewport.painted.connect(self._on_feedback)

    def close(self) -> None:
        """Stop listening."""
        self._tools.changed.disconnect(self._on_feedback)
        self._viewport.painted.disconnect(self._on_feedback)

    def _on_feedback(self) -> None:
        camera = self._viewport.camera_now()
        self._viewport.overlay.put("guard", shapes(camera, self._tools.feedback))


def shapes(camera: Camera, said: Feedback) -> Iterator[Shape]:
    """What to draw of a drag's guard."""
    verdict, anchor = said.verdict, said.anchor
    if verdict is None or verdict.state == "none":
        return
    if not verdict.asked.any():  # of a path that is no straight drag there is only a word
        yield from _said(verdict, said)
        return
    if anchor is None:
        return
    amplitude = verdict.stop.amplitude
    drawn = np.isfinite(amplitude) and amplitude < NEAR
    places = [anchor, anchor + verdict.asked]
    places.append(anchor + (amplitude if drawn else 1.0) * verdict.asked)
    start, cursor, limit = camera.project(np.array(places))
    if not np.isfinite([start, cursor, limit]).all():
        return
    colour = "danger" if verdict.beyond else "warning" if verdict.unseen.missing else "good"
    yield Line(tuple(start), tuple(limit if verdict.beyond else cursor), colour, 2.0)
    way = cursor - start
    length = float(np.linalg.norm(way))
    if drawn and length > 1:
        across = TICK * np.array([-way[1], way[0]]) / length
        yield Line(tuple(cursor), tuple(limit), colour, 1.5, True)
        yield Line(tuple(limit - across), tuple(limit + across), colour, 3.0)
        yield Ring(tuple(limit), 3.0, colour, filled=True)
    yield from _said(verdict, said)


def _said(verdict: Verdict, said: Feedback) -> Iterator[Shape]:
    text = words(verdict)
    if text:
        at = said.at[0] + 18, said.at[1] + BELOW
        yield Text(at, (text,), "danger" if verdict.beyond else "view_text", plate=True)


def words(verdict: Verdict) -> str:
    """What the guard says at the cursor; nothing where no limit is in sight.

    Cells that the guard does not know are told in any case: no drag of them is known to be safe.
    """
    if verdict.state == "waiting":
        return "guard is being set up …"
    amplitude = verdict.stop.amplitude
    unseen = str(verdict.unseen) if verdict.unseen.missing else ""
    if not (np.isfinite(amplitude) and amplitude < NEAR):
        return unseen
    path = np.isfinite(verdict.place)
    far = "the limit" if path else f"{amplitude * float(np.linalg.norm(verdict.asked)):.4g}"
    held = verdict.held or (verdict.vector != verdict.asked).any()
    if path and not held and not verdict.beyond:
        return unseen  # how much of an angle is left is said by the read-out once it is reached
    said = "stopped at" if held else "beyond the limit" if verdict.beyond else "limit"
    said = "beyond" if path and verdict.beyond and not held else said
    return f"{said} {far}: {verdict.reason}" + (f"; {unseen}" if unseen else "")
