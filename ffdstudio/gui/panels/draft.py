"""A lattice that is being built, as plain values: what is wrong with them, and the command."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.frozen import leaves_some
from ffdstudio.project.commands import CreateBox

DIRECTIONS = "ijk"
MOST = 200_000  # control points; more of them are neither drawn nor edited with sense


@dataclass(frozen=True)
class Draft:
    """What stands in the fields of the builder; None where it is no number."""

    name: str
    counts: tuple[int, ...]
    degrees: tuple[int, ...]
    lower: tuple[float | None, ...]
    upper: tuple[float | None, ...]
    angles: tuple[float, float, float] | None = None
    spacing: str = "greville"
    frozen: int = 0
    open_faces: tuple[tuple[int, int], ...] = ()
    plane: tuple[tuple[float, ...], ...] | None = None  # right and up of a plane that is not x, y

    @property
    def axes(self) -> Array | None:
        """(d, 3) frame; None for the coordinate axes."""
        if self.plane is not None and len(self.counts) == 2:
            right, up = np.array(self.plane)
            turned = np.eye(3) if self.angles is None else frame(self.angles)
            return np.asarray(turned[:2] @ np.array([right, up, np.cross(right, up)]))
        return None if self.angles is None else frame(self.angles)[: len(self.counts)]

    @property
    def lacks_degree(self) -> bool:
        """Whether a direction has too few points for its degree."""
        return any(degree >= count for count, degree in zip(self.counts, self.degrees, strict=True))

    def problems(self) -> dict[str, str]:
        """Why it cannot be made, by field: "direction 0", "bounds 2", "frozen", "name"."""
        found: dict[str, str] = {}
        for axis, (count, degree) in enumerate(zip(self.counts, self.degrees, strict=True)):
            if degree >= count:
                found[f"direction {axis}"] = f"degree {degree} needs at least {degree + 1} points"
            low, high = self.lower[axis], self.upper[axis]
            if low is None or high is None:
                found[f"bounds {axis}"] = "two numbers are needed"
            elif not high - low > 1e-12 * max(abs(low), abs(high)):
                found[f"bounds {axis}"] = "the upper bound must be above the lower one"
        if not leaves_some(self.counts, self.frozen, self.open_faces):
            found["frozen"] = f"{self.frozen} layers on both sides leave no free point"
        if np.prod(self.counts) > MOST:
            found["direction 0"] = f"{np.prod(self.counts):,} points in all are too many"
        if not self.name.strip():
            found["name"] = "a name is needed"
        return found

    def command(self) -> CreateBox:
        """Command that makes it; only without problems."""
        d = len(self.counts)
        axes = self.axes
        return CreateBox(
            self.name.strip(),
            tuple(float(v or 0.0) for v in self.lower[:d]),
            tuple(float(v or 0.0) for v in self.upper[:d]),
            self.counts,
            self.degrees,
            None if axes is None else tuple(tuple(map(float, row)) for row in axes),
            self.spacing,
            self.frozen,
            self.open_faces,
        )


def frame(angles: tuple[float, float, float]) -> Array:
    """(3, 3) rows are the axes turned about x, then y, then z, in degrees."""
    a, b, c = np.radians(angles)
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    result: Array = (z @ y @ x).T
    return result


def angles_of(axes: Array) -> tuple[float, float, float]:
    """Angles that `frame` makes these axes of."""
    turn = axes.T
    b = np.arcsin(np.clip(-turn[2, 0], -1, 1))
    a, c = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    return tuple(float(round(v, 6)) for v in np.degrees([a, b, c]))  # type: ignore[return-value]


def principal_frame(points: Array, flat: bool) -> Array:
    """(3, 3) right-handed axes along the longest, middle and shortest extent of points.

    Each is turned such that its largest component is positive; `flat` keeps z.
    """
    centred = points - points.mean(axis=0)
    if flat:
        centred = centred * [1, 1, 0]
    _, vectors = np.linalg.eigh(centred.T @ centred)
    axes = vectors.T[::-1].copy()
    if flat:
        axes[2] = [0, 0, 1]
    for row in axes:
        row *= np.sign(row[np.argmax(np.abs(row))])
    axes[2] = np.cross(axes[0], axes[1])
    if axes[2, np.argmax(np.abs(axes[2]))] < 0:  # half a turn less
        axes[1:] *= -1
    return axes


def inside_box(lattice: Lattice, points: Array) -> NDArray[np.bool_]:
    """(n,) which points lie in an undeformed box lattice."""
    local = points @ lattice.axes.T
    low, high = lattice.domain.T
    inside: NDArray[np.bool_] = ((local >= low) & (local <= high)).all(axis=1)
    return inside
