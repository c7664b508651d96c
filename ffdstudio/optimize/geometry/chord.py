"""Where a section lies and how long it is.

Everything aerodynamic is meant for x from 0 to 1 and y from the trailing edge's middle: the
coefficients of the panel method, the distance to a tabulated section, Kulfan's tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array


@dataclass(frozen=True)
class Chord:
    """Where a section lies: its coordinates in chords are ``(x - origin) / length``."""

    x: float
    y: float
    length: float

    @classmethod
    def of(cls, contour: Array) -> Chord:
        """Chord of (n, 2+) points in Selig's order.

        Examples
        --------
        >>> Chord.of(np.array([[3.0, 1.1], [1.0, 1.0], [3.0, 0.9]]))
        Chord(x=1.0, y=1.0, length=2.0)
        """
        low, high = contour[:, 0].min(), contour[[0, -1], 0].max()
        middle = 0.5 * (contour[0, 1] + contour[-1, 1])
        tiny = 1e-9 * (high - low)  # so that a unit chord stays exactly one
        x, y = (0.0 if abs(v) < tiny else float(v) for v in (low, middle))
        return cls(x, y, float(high - x))

    @property
    def unit(self) -> bool:
        """Whether nothing has to be changed."""
        return self == Chord(0.0, 0.0, 1.0)

    @property
    def origin(self) -> Array:
        """(3,) nose's abscissa and trailing edge's height."""
        return np.array([self.x, self.y, 0.0])

    def local(self, points: Array) -> Array:
        """(n, 3) points in chords."""
        return (points - self.origin) / self.length

    def world(self, points: Array) -> Array:
        """(n, 3) points in the units of the mesh, from chords."""
        return points * self.length + self.origin


UNIT = Chord(0.0, 0.0, 1.0)
