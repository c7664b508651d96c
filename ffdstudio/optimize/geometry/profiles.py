"""Airfoil sections in plane meshes: which markers are one, and their points in Selig's order.

1. A section is a closed chain of line elements, twice as long as high at least, or the one
   chain of an airfoil file. A far field is as high as it is long.
2. Points run from the upper trailing edge over the nose to the lower one. A blunt trailing
   edge is no part of the contour: the chain is opened there.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.quasi2d import is_plane, outlines, plane_axes

SLENDER = 0.5  # height over length, at most
BLUNT = 0.02  # of the chord: how far a trailing edge may reach forward


@dataclass(frozen=True, eq=False)
class Profile:
    """A section in a mesh.

    Attributes
    ----------
    marker : str
        Empty for the lines of an airfoil file.
    nodes : numpy.ndarray
        (n,) nodes of the mesh in Selig's order.
    axes : numpy.ndarray
        (2, 3) along the chord and upwards, in the plane of the section.
    """

    marker: str
    nodes: Indices
    axes: Array = field(default_factory=lambda: np.eye(3)[:2])

    def local(self, points: Array) -> Array:
        """(n, 3) points as seen in the plane of the section, where the third coordinate is 0."""
        flat = points @ self.axes.T
        return np.column_stack([flat, np.zeros(len(flat))])


def profiles(mesh: Mesh) -> list[Profile]:
    """Sections of a plane mesh, or of one that stands for it; the longest first.

    Examples
    --------
    >>> from ffdstudio.meshes.airfoil import contour_mesh, naca4
    >>> [profile.nodes.size for profile in profiles(contour_mesh(naca4("0012", points=21)))]
    [41]
    """
    if not is_plane(mesh):
        return []
    chains, axes = outlines(mesh), plane_axes(mesh)
    if set(mesh.cells) == {"line"}:
        chains[""] = mesh.cells["line"][:, :2]
    flat, found = mesh.points @ axes.T, []
    for name, lines in chains.items():
        nodes = _selig(flat, lines)
        if nodes is not None:
            found.append(Profile(name, nodes, axes))
    return sorted(found, key=lambda p: -float(np.ptp(flat[p.nodes, 0])))


def _selig(points: Array, lines: Indices) -> Indices | None:
    """Nodes of a chain of lines in Selig's order; None if they are no section."""
    order = _chain(points, lines)
    if order is None:
        return None
    x, y = points[order, 0], points[order, 1]
    length = float(np.ptp(x))
    if length == 0 or np.ptp(y) > SLENDER * length:
        return None
    if _area(points[order]) < 0:
        order = order[::-1]
    return _opened(points, order, length)


def _chain(points: Array, lines: Indices) -> Indices | None:
    """Nodes one after the other round a closed chain; points at one place count as one."""
    if len(lines) < 8:
        return None
    places, of_node = np.unique(points[lines.ravel()], axis=0, return_inverse=True)
    ends = of_node.reshape(-1, 2)
    node_of = np.zeros(len(places), dtype=np.int64)
    node_of[of_node.ravel()] = lines.ravel()
    beside: dict[int, list[int]] = {}
    for a, b in ends.tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    loose = [k for k, others in beside.items() if len(others) == 1]
    if len(loose) > 2 or any(len(others) > 2 for others in beside.values()):
        return None
    here = loose[0] if loose else next(iter(beside))
    seen, before = [here], -1
    while True:
        ahead = [k for k in beside[here] if k not in (before, seen[0])]
        if not ahead:
            break
        before, here = here, ahead[0]
        seen.append(here)
    whole = len(seen) == len(places)
    return node_of[np.array(seen)] if whole else None


def _opened(points: Array, order: Indices, length: float) -> Indices:
    """Open a counter-clockwise ring at its trailing edge, leaving out a blunt base."""
    order = np.roll(order, -int(np.argmax(points[order, 0])))
    xy, count = points[order, :2], len(order)
    step = np.roll(xy, -1, axis=0) - xy
    aft = xy[:, 0] > xy[0, 0] - BLUNT * length
    base = (np.abs(step[:, 0]) < 0.3 * np.abs(step[:, 1])) & aft & np.roll(aft, -1)
    above, below = int(np.argmin(base)), int(np.argmin(base[::-1]))
    return order[np.arange(above, count - below + 1) % count]


def _area(points: Array) -> float:
    x, y = points[:, 0], points[:, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
