"""The points that an objective sees: a section or a surface, in a useful order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.geometry.contour import Contour
from ffdstudio.optimize.geometry.sections import DENSE_POINTS
from ffdstudio.optimize.variables.metrics import Surface


@dataclass
class Shape:
    """Points that the objective sees.

    Attributes
    ----------
    points : numpy.ndarray
        (n, 3); of a 2D contour in Selig's order.
    surface : Surface
    mesh : Mesh, optional
        That they belong to.
    nodes : numpy.ndarray, optional
        Their numbers in it; those of the section that they were sampled from.
    triangles : numpy.ndarray, optional
        Of a surface in 3D.
    contour : numpy.ndarray, optional
        Where the section is among the points of a whole mesh, in Selig's order.
    outline : numpy.ndarray, optional
        (m, 3) nodes that a section was sampled from, if it was.
    judged : numpy.ndarray, optional
        (k, 3) points that errors are measured at, if there are such.
    placed : bool
        Whether a section lies wherever it lies; else it has a chord of 1.
    """

    points: Array
    surface: Surface
    mesh: Mesh | None = None
    nodes: NDArray[np.int64] | None = None
    triangles: NDArray[np.int64] | None = None
    contour: NDArray[np.int64] | None = None
    outline: Array | None = None
    judged: Array | None = None
    placed: bool = True

    @property
    def flat(self) -> bool:
        """Whether it is a section."""
        return self.triangles is None

    @cached_property
    def chord(self) -> Chord | None:
        """Where the section lies; None for a surface in 3D."""
        if not self.flat:
            return None
        within = self.section if self.outline is None else self.outline
        return Chord.of(within) if self.placed else Chord(0.0, 0.0, 1.0)

    @property
    def section(self) -> Array:
        """(n, 3) points without those of the mesh around."""
        return self.points if self.contour is None else self.points[self.contour]

    @property
    def local(self) -> Array:
        """(n, 3) points of the section in chords, or of the surface as it is."""
        return self.in_chords(self.section)

    def in_chords(self, points: Array) -> Array:
        """(n, 3) points in chords of the section, or as they are."""
        return points if self.chord is None or self.chord.unit else self.chord.local(points)

    @property
    def seen(self) -> Array:
        """(m, 3) points that a lattice is put around."""
        return self.points[self.surface.mass > 0] if self.outline is None else self.outline

    @cached_property
    def dense(self) -> Array:
        """(k, 3) points that errors are measured at: many of a section, its own of a surface."""
        if self.judged is not None:
            return self.judged
        if self.chord is None:
            return self.points
        outline = self.section if self.outline is None else self.outline
        found = Contour.through(self.chord.local(outline)).sample(DENSE_POINTS)
        return self.chord.world(found)


def selig_order(points: Array, lines: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes of a closed chain of lines from the trailing edge over the upper side and back.

    The trailing edge, the node of the largest x, comes first and last.

    Raises
    ------
    InputError
        If the lines are not one closed chain.
    """
    neighbours: dict[int, list[int]] = {}
    for a, b in lines.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    if any(len(near) != 2 for near in neighbours.values()):
        raise InputError("the marker is not one closed contour")
    start = max(neighbours, key=lambda k: (points[k, 0], points[k, 1]))
    first = max(neighbours[start], key=lambda k: points[k, 1])
    chain = [start, first]
    while chain[-1] != start:
        a, b = neighbours[chain[-1]]
        chain.append(b if a == chain[-2] else a)
    if len(chain) != len(lines) + 1:
        raise InputError("the marker is not one closed contour")
    return np.array(chain, dtype=np.int64)
