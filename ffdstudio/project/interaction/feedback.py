"""What a tool wants to be drawn over the viewport, and said at the cursor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.project.interaction.dragging import Lock
from ffdstudio.project.view.camera import Camera

if TYPE_CHECKING:
    from ffdstudio.project.checks.guarding import Verdict

STEM, OCTAVE = 40.0, 40.0  # pixels: stem of a weight handle at weight 1, and for twice that
NOISE = 1e-12  # of a displacement: less in a direction is rounding
SHORTEST, LONGEST = 14.0, 180.0


@dataclass(frozen=True, eq=False)
class Feedback:
    """State of the tool under way.

    Attributes
    ----------
    text : str
        Read-out for the cursor.
    at : tuple of float
        Pixel of the cursor.
    band : tuple of float, or None
        Rubber band: x, y of two opposite corners.
    anchor : numpy.ndarray or None
        (3,) world point that was grabbed, or about which is turned or scaled, at the start.
    lock : Lock or None
        Axis or plane the drag stays in, through the anchor.
    radius : float
        Of soft selection about the anchor, world units; 0 for none.
    verdict : Verdict or None
        What the guard says of the drag.
    """

    text: str = ""
    at: tuple[float, float] = (0.0, 0.0)
    band: tuple[float, float, float, float] | None = None
    anchor: Array | None = None
    lock: Lock | None = None
    radius: float = 0.0
    verdict: Verdict | None = None


NOTHING = Feedback()


def weight_handle(camera: Camera, point: Array, weight: float) -> tuple[float, float]:
    """Pixel of the handle of a control point's weight: above it, higher for more weight."""
    x, y = camera.project(point)[0]
    stem = np.clip(STEM + OCTAVE * np.log2(weight), SHORTEST, LONGEST)
    return float(x), float(y - stem)


def vector_text(vector: Array, lock: Lock | None) -> str:
    """Read-out of a displacement."""
    size = float(np.linalg.norm(vector))
    clean = np.where(np.abs(vector) < NOISE * size, 0.0, vector)
    parts = ", ".join(f"{value + 0.0:.4g}" for value in clean)
    name = f"  [{lock.name}]" if lock is not None and lock.name else ""
    return f"Δ {parts}   length {size:.4g}{name}"
