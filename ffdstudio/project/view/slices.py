"""Section curves: where a plane cuts a displayed surface, and what such a section measures.

1. A triangle that a plane crosses is cut along one segment; segments that share an edge follow
   one another. What is cut is the surface, so any body with faces has sections.
2. In the plane a section is measured as an airfoil is: the chord from nose to trailing edge (the
   two points farthest apart, the trailing edge being the one farther along the first axis),
   the largest thickness and camber across it, and the angle of the chord, whose change is twist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ffdstudio.aliases import Array, Indices

STATIONS = 201


@dataclass(frozen=True)
class Measures:
    """Of a closed section, in the unit of the mesh; the angle in degrees.

    Attributes
    ----------
    chord, thickness, camber : float
        The thickness and the camber are the largest across the chord.
    angle : float
        Of the chord against the first axis of the plane, positive nose up.
    """

    chord: float
    thickness: float
    camber: float
    angle: float


def section_of(points: Array, triangles: Indices, origin: Array, normal: Array) -> Array:
    """(s, 2, 3) segments along which a plane cuts triangles.

    Parameters
    ----------
    points : numpy.ndarray
        (m, 3).
    triangles : numpy.ndarray
        (t, 3) rows of `points`.
    origin, normal : numpy.ndarray
        (3,) of the plane.

    Examples
    --------
    >>> corner = np.array([[0, 0, -1], [2, 0, 1], [0, 2, 1.0]])
    >>> section_of(corner, np.array([[0, 1, 2]]), np.zeros(3), np.array([0, 0, 1.0]))
    array([[[1., 0., 0.],
            [0., 1., 0.]]])
    """
    height = (points - origin) @ normal
    above = height > 0  # what lies on the plane counts as below: every cut has two ends
    corner = above[triangles]
    crossed = triangles[corner.any(axis=1) & ~corner.all(axis=1)]
    if not len(crossed):
        return np.zeros((0, 2, 3))
    side = above[crossed]
    alone = np.where(side.sum(axis=1) == 1, side.argmax(axis=1), (~side).argmax(axis=1))
    rows = np.arange(len(crossed))
    one = crossed[rows, alone]
    ends = []
    for step in (1, 2):
        other = crossed[rows, (alone + step) % 3]
        low, high = np.minimum(one, other), np.maximum(one, other)  # the same bits from both sides
        share = height[low] / (height[low] - height[high])
        ends.append(points[low] + share[:, None] * (points[high] - points[low]))
    return np.stack(ends, axis=1)


def measured(segments: Array, axes: Array) -> Measures | None:
    """Chord, thickness, camber and angle of a section; None if it is none.

    Parameters
    ----------
    segments : numpy.ndarray
        (s, 2, 3).
    axes : numpy.ndarray
        (2, 3) along and up in the plane.
    """
    flat = segments.reshape(-1, 3) @ axes.T
    if len(flat) < 6:
        return None
    nose, tail = _farthest(flat)
    along = tail - nose
    chord = float(np.linalg.norm(along))
    if chord == 0:
        return None
    along = along / chord
    up = np.array([-along[1], along[0]])
    local = np.stack([(flat - nose) @ along, (flat - nose) @ up], axis=1).reshape(-1, 2, 2)
    stations = 0.5 * chord * (1 - np.cos(np.linspace(0, np.pi, STATIONS)))[1:-1]
    heights = [_heights(local, x) for x in stations]
    both = np.array([(h.min(), h.max()) for h in heights if len(h) > 1])
    if not len(both):
        return None
    thickness = float((both[:, 1] - both[:, 0]).max())
    middle = both.mean(axis=1)
    camber = float(middle[np.argmax(np.abs(middle))])
    angle = float(np.degrees(np.arctan2(-along[1], along[0])))
    return Measures(chord, thickness, camber, angle)


def _farthest(flat: Array) -> tuple[Array, Array]:
    """Nose and trailing edge: the two points farthest apart."""
    first = flat[np.argmax(np.linalg.norm(flat - flat.mean(axis=0), axis=1))]
    for _ in range(4):
        second = flat[np.argmax(np.linalg.norm(flat - first, axis=1))]
        again = flat[np.argmax(np.linalg.norm(flat - second, axis=1))]
        if np.array_equal(again, first):
            break
        first = again
    return (first, second) if first[0] <= second[0] else (second, first)


def _heights(local: Array, x: float) -> Array:
    """Where segments (s, 2, 2) cross the line at a distance along the chord."""
    low, high = local[..., 0].min(axis=1), local[..., 0].max(axis=1)
    some = local[(low <= x) & (high > x)]
    share = (x - some[:, 0, 0]) / (some[:, 1, 0] - some[:, 0, 0])
    return np.asarray(some[:, 0, 1] + share * (some[:, 1, 1] - some[:, 0, 1]))
