"""Which points move with the selected ones, and how: soft selection and mirror editing.

1. Soft: points near a selected one move by a part of its motion, which falls off with the
   distance according to a profile.
2. Mirror: the points opposite the moving ones, seen from a plane, move as a mirror image;
   points on the plane stay on it. One-way: they only stay on it.
3. Partners are found at rest, where a lattice is symmetric if it ever will be.
4. Points in frozen layers never move.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.project.model import Index, LatticeItem

ON_PLANE = 1e-6  # of the diagonal of the net

PROFILES: dict[str, Callable[[Array], Array]] = {
    "smooth": lambda t: t * t * (3 - 2 * t),
    "sphere": lambda t: np.sqrt(t * (2 - t)),
    "linear": lambda t: t,
    "sharp": lambda t: t * t,
    "constant": lambda t: np.sign(t),
}
"""Share of the motion by nearness: 1 at a selected point, 0 at the radius."""


@dataclass(frozen=True)
class Soft:
    """Soft selection: points within `radius` (world units) follow by a `profile`."""

    radius: float
    profile: str = "smooth"


@dataclass(frozen=True)
class Mirror:
    """Symmetry about the plane where coordinate `axis` equals `at`.

    With `both` the other side follows; without, points on the plane just stay on it.
    """

    axis: int
    at: float = 0.0
    both: bool = True


class Spread:
    """How a motion of the selected points spreads over a lattice.

    Attributes
    ----------
    points : tuple of tuple of int
        All points that may move, without frozen ones; ascending.
    share : numpy.ndarray
        (k,) part of the motion each takes.
    """

    def __init__(
        self,
        item: LatticeItem,
        selection: Iterable[Index],
        soft: Soft | None = None,
        mirror: Mirror | None = None,
    ) -> None:
        net, rest = item.current.control_points, item.rest.control_points
        free = ~item.frozen_mask
        chosen = np.zeros(free.shape, dtype=bool)
        chosen[tuple(np.array(sorted(selection), dtype=np.int64).T)] = True
        own = chosen.astype(float)
        if soft is not None:
            own = np.maximum(own, _shares(net, net[chosen], soft))
        other, self._plane = np.zeros(free.shape), mirror
        on_plane = np.zeros(free.shape, dtype=bool)
        if mirror is not None:
            partner = _partners(rest, mirror, ON_PLANE * item.rest.diagonal)
            on_plane = np.abs(rest[..., mirror.axis] - mirror.at) <= ON_PLANE * item.rest.diagonal
            if mirror.both:
                opposite = np.where(partner >= 0, own.ravel()[partner], 0.0)
                other = np.where(on_plane.ravel(), 0.0, opposite).reshape(free.shape)
        moving = free if soft is not None else free & (np.maximum(own, other) > 0)
        self.points: tuple[Index, ...] = tuple(map(tuple, np.argwhere(moving).tolist()))
        self.share = np.maximum(own, other)[moving]
        self._mirrored, self._on_plane = (other > own)[moving], on_plane[moving]

    @property
    def plain(self) -> bool:
        """Whether all points take the same motion."""
        return bool((self.share == 1).all()) and not (self._mirrored | self._on_plane).any()

    def place(self, start: Array, transform: Callable[[Array], Array]) -> Array:
        """(k, 3) positions after a transform of the selected points, by (n, 3) -> (n, 3)."""
        source = start.copy()
        self._reflect(source, self._mirrored, about=True)
        move = transform(source) - source
        self._reflect(move, self._mirrored, about=False)
        if self._plane is not None:
            move[self._on_plane, self._plane.axis] = 0.0
        result: Array = start + self.share[:, None] * move
        return result

    def _reflect(self, array: Array, rows: NDArray[np.bool_], about: bool) -> None:
        """Mirror positions, or vectors, in place."""
        if self._plane is not None:
            centre = 2 * self._plane.at if about else 0.0
            array[rows, self._plane.axis] = centre - array[rows, self._plane.axis]


def _shares(net: Array, chosen: Array, soft: Soft) -> Array:
    from scipy.spatial import cKDTree

    if not len(chosen) or soft.radius <= 0:
        return np.zeros(net.shape[:-1])
    distance = np.asarray(cKDTree(chosen).query(net.reshape(-1, 3))[0])
    nearness = np.clip(1 - distance / soft.radius, 0.0, 1.0).reshape(net.shape[:-1])
    return PROFILES[soft.profile](nearness)


def _partners(rest: Array, mirror: Mirror, slack: float) -> NDArray[np.int64]:
    """Flat index of the point opposite each one; -1 where there is none."""
    from scipy.spatial import cKDTree

    flat = rest.reshape(-1, 3)
    opposite = flat.copy()
    opposite[:, mirror.axis] = 2 * mirror.at - opposite[:, mirror.axis]
    distance, index = cKDTree(flat).query(opposite)
    return np.where(distance <= slack, index, -1)
