"""SU2's FFD boxes in cylindrical coordinates: corners in x, y, z, and a box around the x axis.

SU2 turns the eight corners of the definition into radius, angle and distance around the axis
through ``FFD_AXIS`` along x, the angle being that of (y, z) with those beyond a quarter turn taken
a turn lower, and spans the box between them there. Where the corners are those of a box in these
coordinates the lattice is a cylinder's; what they span else has no name and is refused.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.direction import Direction
from ffdstudio.engine.frames import Cylinder, cylinder_net
from ffdstudio.errors import InputError

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
OFF = 1e-9  # of the extent: how well corners agree in a coordinate
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
NAMES = ("radius", "angle", "x")


def cylinder_lattice(
    corners: Array, counts: Sequence[int], orders: Sequence[int] | None, axis: Array
) -> Lattice:
    """Lattice of a box that SU2 spans in cylindrical coordinates.

    Parameters
    ----------
    corners : numpy.ndarray
        (8, 3) corners in x, y, z, in SU2's order.
    counts : sequence of int
        Control points along i, j, k.
    orders : sequence of int or None
        Orders of uniform B-splines, None for Bezier.
    axis : numpy.ndarray
        (3,) point of the axis, which lies along x.

    Raises
    ------
    InputError
        If the corners are not those of a box in cylindrical coordinates, or the control points,
        which SU2 spreads evenly, do not leave them as they are.
    """
    if orders is not None and any(order > 2 for order in orders):
        raise InputError(
            "a box in cylindrical coordinates is read with FFD_BLENDING= BEZIER or order 2 alone"
        )
    ends, order = _ends(_cylindrical(corners - axis))
    frame = Cylinder(tuple(axis.tolist()), X, Y, order)
    directions = [
        Direction.uniform(n, n - 1 if orders is None else 1, *ends[k]) for k, n in enumerate(counts)
    ]
    net = cylinder_net(frame, directions)
    degrees, knots = [d.degree for d in directions], [d.knots for d in directions]
    return Lattice(degrees, knots, net, frame=frame)


def in_space(lattice: Lattice, steps: Array) -> Array:
    """Motions of control points in x, y, z from those in radius, angle and x.

    Each control point moves as the point of the cylinder does that belongs to it.
    """
    frame = lattice.frame
    assert isinstance(frame, Cylinder)
    lines = [lattice.greville(k) for k in range(lattice.dimension)]
    u = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, lattice.dimension)
    there = u + steps.reshape(-1, 3)[:, list(frame.order)]
    motion = frame.world(there, (0, 0, 0)) - frame.world(u, (0, 0, 0))
    motion[(steps.reshape(-1, 3) == 0).all(axis=1)] = 0.0
    return motion.reshape(steps.shape)


def _cylindrical(points: Array) -> Array:
    """Radius, angle and x of points seen from the axis."""
    angle = np.arctan2(points[:, 2], points[:, 1])
    angle[angle > 0.5 * np.pi] -= 2 * np.pi
    return np.stack([np.hypot(points[:, 1], points[:, 2]), angle, points[:, 0]], axis=1)


def _ends(corners: Array) -> tuple[list[tuple[float, float]], tuple[int, int, int]]:
    """Range of each direction, and which coordinate it runs along."""
    cube = np.empty((2, 2, 2, 3))
    for place, corner in zip(CORNERS, corners, strict=True):
        cube[place] = corner
    extent = np.ptp(corners, axis=0)
    ends, order = [], []
    for k in range(3):
        low, high = np.take(cube, 0, axis=k), np.take(cube, 1, axis=k)
        along = int(np.argmax(np.abs(high - low).mean(axis=(0, 1)) / np.maximum(extent, 1e-300)))
        sides = low[..., along], high[..., along]
        rest = np.delete(high - low, along, axis=-1)
        others = np.delete(extent, along)
        if (
            any(np.ptp(side) > OFF * extent[along] for side in sides)
            or (np.abs(rest) > OFF * others).any()
        ):
            raise InputError(
                "the corners, turned from x, y, z into radius, angle and x around the axis as SU2 "
                f"does it, span no box there: direction {'ijk'[k]} does not run along one of them"
            )
        ends.append((float(sides[0].mean()), float(sides[1].mean())))
        order.append(along)
    if sorted(order) != [0, 1, 2]:
        raise InputError("two directions of the box in cylindrical coordinates are the same")
    for (low_end, high_end), along, name in zip(ends, order, "ijk", strict=True):
        if not low_end < high_end:
            raise InputError(
                f"the {NAMES[along]} of a box in cylindrical coordinates must grow along {name}"
            )
    i, j, k = order
    return ends, (i, j, k)
