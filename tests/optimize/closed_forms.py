"""Sections whose flow is known: the images of circles by Karman and Trefftz, and by Joukowski."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CENTRE = -0.08 + 0.06j  # of the circle through 1


@dataclass(frozen=True)
class Transformed:
    """A circle transformed; an edge of 0 degrees is Joukowski's cusp."""

    edge: float = 15.0
    angle: float = 5.0
    centre: complex = CENTRE

    @property
    def start(self) -> float:
        """Angle of the trailing edge on the circle."""
        return float(np.angle(1 - self.centre))

    def _zeta(self, theta: np.ndarray) -> np.ndarray:
        return self.centre + abs(1 - self.centre) * np.exp(1j * theta)

    def at(self, theta: np.ndarray) -> np.ndarray:
        """Complex points of the section."""
        zeta, power = self._zeta(theta), 2 - self.edge / 180
        a, b = (1 + 1 / zeta) ** power, (1 - 1 / zeta) ** power
        return power * (a + b) / (a - b)

    def speed(self, theta: np.ndarray) -> np.ndarray:
        """Speed on the section over the free stream's."""
        zeta, power, alpha = self._zeta(theta), 2 - self.edge / 180, np.radians(self.angle)
        out, radius = zeta - self.centre, abs(1 - self.centre)
        circulation = 4 * np.pi * radius * np.sin(alpha - self.start)
        velocity = np.exp(-1j * alpha) - radius**2 * np.exp(1j * alpha) / out**2
        velocity = velocity + 1j * circulation / (2 * np.pi * out)
        a, b = (1 + 1 / zeta) ** power, (1 - 1 / zeta) ** power
        da = -power / zeta**2 * (1 + 1 / zeta) ** (power - 1)
        db = power / zeta**2 * (1 - 1 / zeta) ** (power - 1)
        slope = power * ((da + db) * (a - b) - (a + b) * (da - db)) / (a - b) ** 2
        return np.abs(velocity / slope)

    def theta(self, count: int) -> np.ndarray:
        """Even angles on the circle, from the trailing edge round."""
        return self.start + np.linspace(0, 2 * np.pi, count)

    def nodes(self, count: int) -> np.ndarray:
        """(count, 2) points, the trailing edge first and last; chord 1 at the origin."""
        with np.errstate(all="ignore"):
            z = self.at(self.theta(count))
        z[[0, -1]] = 2 - self.edge / 180
        return np.column_stack([z.real - self._nose, z.imag]) / self.chord

    @property
    def _nose(self) -> float:
        return float(self.at(np.linspace(2, 4, 20001)).real.min())

    @property
    def chord(self) -> float:
        """Length of the section before it is scaled."""
        return 2 - self.edge / 180 - self._nose

    @property
    def lift(self) -> float:
        """Lift coefficient, from the circulation."""
        radius = abs(1 - self.centre)
        return float(8 * np.pi * radius * np.sin(np.radians(self.angle) - self.start)) / self.chord
