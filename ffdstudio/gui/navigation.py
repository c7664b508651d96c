"""Where the viewer stands and how the mouse moves him: plain arithmetic, no window.

VTK's interactor styles render by themselves, react to single letters and know nothing of a
mesh locked to its plane; these few functions replace them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array

ANGLE = 30.0  # degrees from the lower to the upper border in perspective
DEGREES_PER_PIXEL = 0.4
STEP = 1.2  # one click of the wheel

AXIS_VIEWS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "+x": ((1, 0, 0), (0, 0, 1)),
    "-x": ((-1, 0, 0), (0, 0, 1)),
    "+y": ((0, 1, 0), (0, 0, 1)),
    "-y": ((0, -1, 0), (0, 0, 1)),
    "+z": ((0, 0, 1), (0, 1, 0)),
    "-z": ((0, 0, -1), (0, 1, 0)),
    "corner": ((1, -1.4, 0.9), (0, 0, 1)),
}


@dataclass(frozen=True)
class View:
    """A viewer's place: what is in the centre, from which side, from how far.

    Attributes
    ----------
    focal : numpy.ndarray
        (3,) world point in the centre of the picture.
    back, up : numpy.ndarray
        (3,) unit vectors at right angles: towards the viewer, and upwards in the picture.
    distance : float
        From the focal point to the eye. In parallel projection it gives the scale, such
        that switching the projection keeps the size of what lies at the focal point.
    parallel : bool
    flat : bool
        Locked to the x-y plane, as for two-dimensional meshes: no turning.
    """

    focal: Array
    back: Array
    up: Array
    distance: float = 1.0
    parallel: bool = False
    flat: bool = False

    @property
    def right(self) -> Array:
        """(3,) unit vector to the right in the picture."""
        return np.cross(self.up, self.back)

    @property
    def half_height(self) -> float:
        """Half the height of the picture at the focal point, in world units."""
        return self.distance * float(np.tan(np.radians(ANGLE / 2)))


def looking(back: ArrayLike, up: ArrayLike, like: View | None = None) -> View:
    """View from a side; focal point, distance and projection of another view."""
    towards = _unit(np.asarray(back, dtype=float))
    upwards = np.asarray(up, dtype=float)
    upwards = _unit(upwards - towards * (upwards @ towards))
    if like is None:
        return View(np.zeros(3), towards, upwards)
    return replace(like, back=towards, up=upwards)


def fitted(view: View, bounds: ArrayLike, aspect: float) -> View:
    """View moved so that the box ``[[xmin, ymin, zmin], [xmax, ymax, zmax]]`` fills the picture."""
    low, high = np.asarray(bounds, dtype=float)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    centre = (low + high) / 2
    across = np.abs((corners - centre) @ np.array([view.right, view.up]).T).max(axis=0)
    depth = np.abs((corners - centre) @ view.back).max()
    needed = max(across[0] / max(aspect, 1e-3), across[1], 1e-9 * (1 + np.abs(centre).max()))
    distance = 1.12 * needed / np.tan(np.radians(ANGLE / 2)) + (0 if view.parallel else depth)
    return replace(view, focal=centre, distance=float(distance))


def orbit(view: View, dx: float, dy: float, pivot: ArrayLike | None = None) -> View:
    """Turn by a mouse move in pixels (y downwards), as on a turntable: the horizon stays level.

    About the vertical through the pivot, by default the focal point, and about the horizontal
    in the picture; what is at the pivot stays where it is seen.

    Examples
    --------
    >>> view = looking([0, -1, 0.0], [0, 0, 1.0])
    >>> orbit(view, 90 / DEGREES_PER_PIXEL, 0).back.round(6) + 0.0
    array([-1.,  0.,  0.])
    """
    if view.flat:
        return view
    about = _turn(np.eye(3)[2], -dx * DEGREES_PER_PIXEL * (1.0 if view.up[2] >= -1e-9 else -1.0))
    turn = about @ _turn(view.right, -dy * DEGREES_PER_PIXEL)
    turned = looking(turn @ view.back, turn @ view.up, view)
    if pivot is None:
        return turned
    centre = np.asarray(pivot, dtype=float)
    return replace(turned, focal=centre + turn @ (view.focal - centre))


def levelled(view: View) -> View:
    """View whose right is horizontal: as on a turntable.

    Straight from above or below the up vector is kept.
    """
    vertical = np.array([0.0, 0.0, 1.0])
    if view.flat or abs(view.back[2]) > 1 - 1e-9:
        return view
    return looking(view.back, vertical if view.up[2] >= 0 else -vertical, view)


def pan(view: View, dx: float, dy: float, height: float) -> View:
    """Shift by a mouse move in pixels, so that the focal plane sticks to the cursor."""
    scale = 2 * view.half_height / height
    return replace(view, focal=view.focal - scale * (dx * view.right - dy * view.up))


def zoom(view: View, steps: float, x: float = 0.0, y: float = 0.0, height: float = 1.0) -> View:
    """Come closer by wheel `steps`; what is `x` right of and `y` above the centre stays there."""
    factor = STEP**-steps
    scale = 2 * view.half_height / height * (1 - factor)
    focal = view.focal + scale * (x * view.right + y * view.up)
    return replace(view, focal=focal, distance=view.distance * factor)


TRIAD, CORNER = 34.0, 58.0  # pixels: arms of the triad, and its place in the lower left corner


def triad_ends(view: View, height: float) -> dict[str, tuple[float, float]]:
    """Pixels of the six ends of the triad by side of `AXIS_VIEWS`; those in front come first.

    Examples
    --------
    >>> view = looking([0, 0, 1.0], [0, 1.0, 0])
    >>> {k: (round(x), round(y)) for k, (x, y) in triad_ends(view, 100).items()}["+x"]
    (92, 42)
    """
    ends = {}
    for axis, letter in enumerate("xyz"):
        for sign, mark in ((1.0, "+"), (-1.0, "-")):
            along = sign * np.eye(3)[axis]
            place = CORNER + TRIAD * float(along @ view.right)
            lift = height - CORNER - TRIAD * float(along @ view.up)
            ends[mark + letter] = (float(along @ view.back), place, lift)
    ordered = sorted(ends.items(), key=lambda pair: -pair[1][0])
    return {name: (x, y) for name, (_, x, y) in ordered}


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _turn(axis: Array, degrees: float) -> Array:
    """Rotation matrix about a unit vector (Rodrigues)."""
    angle = np.radians(degrees)
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    result: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return result
