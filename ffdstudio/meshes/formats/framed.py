"""Coordinates that a file gives in local frames: its template holds them as they stand there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.formats.frames import Frame
from ffdstudio.meshes.formats.patch import changed

SLACK = 1e-14  # of the largest coordinate of a node: a smaller change is rounding


@dataclass(frozen=True, eq=False)
class Framing:
    """(n, 3) coordinates as in the file and as x, y, z; frames with the nodes given in each."""

    local: Array
    original: Array
    frames: list[tuple[Frame, Indices]]

    @classmethod
    def of(cls, local: Array, frames: list[tuple[Frame, Indices]]) -> Framing:
        """Framing of the numbers of a file; nodes in no frame are given as x, y, z."""
        points = local.copy()
        for frame, nodes in frames:
            points[nodes] = frame.to_global(local[nodes])
        return cls(local, points, frames)

    def numbers(self, points: Array) -> Array:
        """(n, 3) numbers for the file, the old ones where nothing moves."""
        moved = changed(self.original, points)
        found = np.where(moved, points, self.local)
        for frame, nodes in self.frames:
            found[nodes] = self.local[nodes]
            rows = nodes[moved[nodes].any(axis=1)]
            old = self.local[rows]
            new = frame.to_local(points[rows], old)
            slack = SLACK * (1 + np.abs(old).max(axis=1, initial=0.0, keepdims=True))
            found[rows] = np.where(np.abs(new - old) > slack, new, old)
        return found
