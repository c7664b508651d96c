"""Room between a shape and the faces of its lattice: as much as it takes to move the shape.

1. Room is a fraction of the largest extent of the shape, one for each direction: a thin section
   needs as much of it above and below as in front, for that is where its skin is moved.
2. It is enough when the skin can move by `wanted_move`: 8 % of the chord of a section; of a
   body in space its thickness, if that is less than 8 % of its length.
3. Faces seated on a plane have no room and need none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Mask
from ffdstudio.engine import Lattice
from ffdstudio.engine import knots as kv
from ffdstudio.engine.boxes import Frame
from ffdstudio.errors import InputError
from ffdstudio.project.placing.estimate import reaches

SHARE = 0.08  # of the chord
TRIED = np.round(np.linspace(0.05, 0.5, 19), 3)  # room as a fraction: from little to much
USUAL = 0.3  # where no room is enough: nets so fine that one point alone moves little
FLAT = 1e-9  # of the largest extent: no extent at all


def extents(frame: Frame, nodes: Array) -> Array:
    """(d,) extent of nodes along the directions of a frame."""
    return np.asarray(np.ptp(nodes @ frame.axes.T, axis=0))


def wanted_move(sizes: Array) -> float:
    """By how much a skin should be able to move, from the extents of the shape.

    Examples
    --------
    >>> wanted_move(np.array([1.0, 0.12])), wanted_move(np.array([1.2, 2.5, 0.12]))
    (0.08, 0.12)
    """
    largest = float(sizes.max(initial=0.0))
    solid = np.sort(sizes[sizes > FLAT * largest])
    if len(sizes) < 3 or len(solid) < 3:
        return SHARE * largest
    return min(SHARE * largest, max(float(solid[0]), SHARE * float(solid[1])))


def with_room(frame: Frame, nodes: Array, room: ArrayLike) -> tuple[Array, Array]:
    """Lower and upper corner, (3,) each, of nodes with room around them.

    Parameters
    ----------
    frame : Frame
    nodes : numpy.ndarray
        (n, 3).
    room : array_like
        Fractions of the largest extent, one for all directions or one for each.

    Raises
    ------
    InputError
        If the room is no finite fraction of at least 0, or there are no nodes.

    Examples
    --------
    >>> with_room(Frame.of(None, 2), np.array([[0, 0, 0], [4, 1.0, 0]]), 0.25)
    (array([-1., -1.,  0.]), array([5., 2., 0.]))
    """
    lower, upper = frame.bounds(nodes, 0.0)
    fractions = kv.numbers(room, "the margin")
    if not (np.isfinite(fractions).all() and (fractions >= 0).all()):
        raise InputError(f"the margin must be a finite fraction of at least 0, got {room!r}")
    d = len(frame.axes)
    if fractions.shape not in ((), (d,)):
        raise InputError(f"{d} directions need 1 or {d} margins")
    sizes = extents(frame, nodes)
    largest = float(sizes.max())
    thin = np.where((sizes <= FLAT * largest) & (fractions == 0), 0.5, 0.0)  # a face has no volume
    by = (fractions + thin) * (largest or 1.0)
    lower[:d] -= by
    upper[:d] += by
    return lower, upper


def fitting_room(
    frame: Frame,
    nodes: Array,
    net: tuple[Sequence[int], Sequence[int] | None],
    bounds_with: Callable[[Array], tuple[Array, Array]],
    free: Mask,
    wanted: float,
) -> Array:
    """(d,) least room in each direction that lets the skin move as wanted.

    Parameters
    ----------
    frame : Frame
    nodes : numpy.ndarray
        (n, 3) the skin, or enough points of it.
    net : tuple
        Control points and degrees of the directions.
    bounds_with : callable
        Lower and upper corner for room: `with_room`, with faces seated where they belong.
    free : numpy.ndarray
        Which control points are not frozen.
    wanted : float
        By how much the skin should be able to move.
    """

    def enough(room: Array) -> bool:
        lattice = Lattice.box(*bounds_with(room), net[0], net[1], frame.axes)
        return bool(reaches(lattice, free, nodes).min() >= wanted)

    d = len(frame.axes)
    room = np.full(d, next((r for r in TRIED if enough(np.full(d, r))), USUAL))
    for axis in np.argsort(-extents(frame, nodes)):  # where there is more than it takes, less
        for less in TRIED[room[axis] > TRIED]:
            smaller = np.where(np.arange(d) == axis, less, room)
            if enough(smaller):
                room = smaller
                break
    return room
