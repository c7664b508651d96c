"""The lattice of a study: one at hand, one in a file, or a box by a rule."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.knots import clamped_uniform
from ffdstudio.errors import InputError
from ffdstudio.optimize.build.place import Place
from ffdstudio.optimize.build.shape import lattice_pair
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.parts import LatticeSpec
from ffdstudio.optimize.variables.space import Insertion

LARGEST = 20_000  # control points
MARGIN, ACROSS = 0.01, 0.05  # of the extents: how far a lattice of fits reaches beyond a section


class Begun(NamedTuple):
    """A lattice as a study begins with it.

    Attributes
    ----------
    rest : Lattice
    current : Lattice or None
        If it is deformed.
    knots : tuple of Insertion
        Knots to be inserted first, which count as the study's own.
    """

    rest: Lattice
    current: Lattice | None = None
    knots: tuple[Insertion, ...] = ()


def lattice_of(spec: LatticeSpec, shape: Shape, place: Place) -> Begun:
    """Lattice of a study around its shape.

    Raises
    ------
    InputError
        If it cannot be read or has too many control points.
    """
    if spec.file:
        rest, current = lattice_pair(spec.file, place)
        return Begun(rest, None if current == rest else current)
    assert spec.shape is not None
    if np.prod(spec.shape, dtype=float) > LARGEST:
        raise InputError(f"[lattice] shape: more than {LARGEST} control points")
    if not spec.movable:
        return Begun(box_of(spec, spec.shape, shape))
    return _movable(spec, spec.shape, shape)


def box_of(spec: LatticeSpec, counts: tuple[int, ...], shape: Shape) -> Lattice:
    """Box with so many control points, by the rule of a description."""
    degrees = list(spec.degrees) if spec.degrees is not None else None
    if degrees is None and shape.mesh is None and shape.flat and len(counts) == 2:
        degrees = [3, counts[1] - 1]
    if spec.lower is not None and spec.upper is not None:
        corners = _three(spec.lower), _three(spec.upper)
        return Lattice.box(*corners, counts, degrees, spacing=spec.spacing)
    margin = _margins(spec, len(counts), shape)
    return Lattice.around(shape.seen, counts, degrees, margin, spacing=spec.spacing)


def section_box(points: Array, counts: tuple[int, int], spacing: str = "greville") -> Lattice:
    """Lattice around the (n, 3) points of a section as fits have it: cubic along the chord."""
    degrees = (3, counts[1] - 1)
    return Lattice.around(points, counts, degrees, (MARGIN, ACROSS), spacing=spacing)


def _margins(spec: LatticeSpec, count: int, shape: Shape) -> float | list[float]:
    """Margins as shares of the extents, with the room across that is asked for."""
    if not spec.room:
        return spec.margin if isinstance(spec.margin, float) else list(spec.margin)
    extent = np.ptp(shape.seen, axis=0)[:count]
    longest = int(np.argmax(extent))
    margins = np.broadcast_to(np.asarray(spec.margin, dtype=np.float64), count).copy()
    across = np.arange(count) != longest
    sizes = np.where(extent > 0, extent, extent[longest])
    wanted = spec.room * extent[longest] / sizes
    margins[across] = np.maximum(margins, wanted)[across]
    return [float(margin) for margin in margins]


def _movable(spec: LatticeSpec, counts: tuple[int, ...], shape: Shape) -> Begun:
    """Box without inner knots along i, and those that are inserted into it."""
    degree = spec.degrees[0] if spec.degrees is not None else min(3, counts[0] - 1)
    rest = box_of(spec, (degree + 1, *counts[1:]), shape)
    low, high = rest.domain[0]
    inner = clamped_uniform(counts[0], degree, low, high)[degree + 1 : -degree - 1]
    return Begun(rest, None, tuple(Insertion(0, float(knot)) for knot in inner))


def _three(corner: tuple[float, ...]) -> NDArray[np.float64]:
    return np.array((*corner, 0.0, 0.0, 0.0)[:3])
