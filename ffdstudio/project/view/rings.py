"""The ring where smoothness ends: where the faces of a lattice cut the displayed surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.project.view.surface import DisplaySurface

ON_FACE = 1e-9  # of the diagonal: what is nearer to a face than that lies on it


def ring(lattice: Lattice, surface: DisplaySurface, rest: Array, now: Array) -> Array:
    """(s, 2, 3) line segments on a surface where it leaves a box lattice.

    Parameters
    ----------
    lattice : Lattice
        Undeformed.
    surface : DisplaySurface
    rest, now : numpy.ndarray
        (m, 3) displayed points as the lattice was laid around them, and where they are.

    Notes
    -----
    Polygons are fanned out into triangles; a triangle with corners on both sides is cut where
    its edges leave the box.

    Examples
    --------
    >>> from ffdstudio.meshes import Mesh
    >>> from ffdstudio.project.view.surface import surface_of
    >>> mesh = Mesh([[0, 0, 0], [2, 0, 0], [0, 2, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> box = Lattice.box([-1, -1], [1, 3], (3, 3), (2, 2))
    >>> ring(box, surface_of(mesh), mesh.points, mesh.points)[..., 0].tolist()
    [[1.0, 1.0]]
    """
    local = rest @ lattice.axes.T
    low, high = lattice.domain.T
    slack = ON_FACE * lattice.diagonal
    outside = ((local < low - slack) | (local > high + slack)).any(axis=1)
    triangles = _triangles(surface)
    some, every = outside[triangles].any(axis=1), outside[triangles].all(axis=1)
    triangles = triangles[some & ~every]
    # the corner that is alone on its side comes first: both crossings lie on its edges
    beyond = outside[triangles]
    lonely = np.where(beyond.sum(axis=1) == 1, beyond.argmax(axis=1), (~beyond).argmax(axis=1))
    a, b, c = np.take_along_axis(triangles, (lonely[:, None] + np.arange(3)) % 3, axis=1).T
    ends = []
    for other in (b, c):
        inner, outer = np.where(outside[a], other, a), np.where(outside[a], a, other)
        share = _leaving(local[inner], local[outer], low, high)[:, None]
        ends.append(now[inner] + share * (now[outer] - now[inner]))
    return np.stack(ends, axis=1)


def _leaving(inner: Array, outer: Array, low: Array, high: Array) -> Array:
    """(k,) share of the way at which lines from inside to outside leave the box."""
    bound = np.where(outer > high, high, np.where(outer < low, low, outer))
    way = outer - inner
    share = np.where(bound != outer, (bound - inner) / np.where(way == 0, 1.0, way), 1.0)
    return np.asarray(np.clip(share, 0.0, 1.0).min(axis=1))


def _triangles(surface: DisplaySurface) -> NDArray[np.int64]:
    """(t, 3) displayed points: the polygons, fanned out."""
    sizes = np.diff(surface.offsets)
    begin = surface.offsets[:-1]
    fans = [
        np.stack([surface.connectivity[begin[some] + k] for k in (0, step, step + 1)], axis=1)
        for step in range(1, int(sizes.max(initial=2)) - 1)
        for some in [sizes > step + 1]
    ]
    return np.concatenate(fans) if fans else np.zeros((0, 3), dtype=np.int64)
