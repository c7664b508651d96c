"""Volume of a body in 3D."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.surfaces import open_loops, oriented
from ffdstudio.optimize.constraints.base import Quantity, Values
from ffdstudio.optimize.geometry.shapes import Shape
from ffdstudio.optimize.spec.limits import ConstraintSpec

FLAT = 1e-6  # of the loop's size: how far the edge of an opening may leave its plane


class Volume(Quantity):
    """Volume inside a triangulated surface (divergence theorem), wherever it lies.

    A surface may be open where its edge lies in a plane: half a wing at its symmetry plane. Each
    such opening is closed by a flat cap that moves with the edge. Triangles are turned alike.

    Parameters
    ----------
    triangles : numpy.ndarray
        (k, 3) indices of the points.

    Raises
    ------
    InputError
        At the first evaluation, if an opening lies in no plane, or edges have more than two
        triangles: there is no inside then.

    Examples
    --------
    The unit cube's corner, a tetrahedron of volume 1/6, without the side on the plane x = 0:

    >>> corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> volume = Volume(np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3]]))
    >>> bool(np.isclose(volume(corner + [0, 10, 0]).values[0], 1 / 6))
    True
    """

    def __init__(self, triangles: NDArray[np.int64]) -> None:
        self.triangles = triangles
        self._closed: Indices | None = None

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        if self._closed is None:
            self._closed = closed(self.triangles, points)
        centre = points[self._closed[:, 0]].mean(axis=0)  # far from the origin digits are lost
        a, b, c = (points[self._closed[:, k]] - centre for k in range(3))
        rows = np.zeros_like(points)
        for k, across in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
            np.add.at(rows, self._closed[:, k], across / 6)
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
        sign = 1.0 if volume >= 0 else -1.0
        return Values(np.array([sign * volume]), sign * rows.reshape(1, -1))


def closed(triangles: Indices, points: Array) -> Indices:
    """Return a surface with caps on its openings, which have to be flat.

    Raises
    ------
    InputError
        If an opening lies in no plane, or the surface has no two sides.
    """
    _, first, same = np.unique(points, axis=0, return_index=True, return_inverse=True)
    merged = first[same.ravel()][triangles]  # points that lie on one another are one
    merged = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
    surface = oriented(merged)
    caps = []
    for loop in open_loops(surface):
        _refuse_bent(points[loop])
        fan = np.column_stack([np.full(len(loop) - 2, loop[0]), loop[2:], loop[1:-1]])
        caps.append(fan)
    return np.concatenate([surface, *caps])


def _refuse_bent(edge: Array) -> None:
    """Refuse an opening whose edge leaves its plane."""
    spread = edge - edge.mean(axis=0)
    sizes = np.linalg.svd(spread, compute_uv=False)
    if len(edge) > 3 and sizes[2] > FLAT * sizes[0]:
        x, y, z = edge.mean(axis=0)
        raise InputError(
            f"the surface is open, and the edge of its opening around ({x:.4g}, {y:.4g}, {z:.4g}) "
            "lies in no plane: there is no volume inside"
        )


class VolumeLimit(ConstraintSpec, frozen=True, kw_only=True, tag="volume"):
    """Volume inside a surface; openings in a plane, such as that of symmetry, are closed."""

    title = "Volume"
    needs = "surface"

    def quantity(self, shape: Shape) -> Quantity:
        """See `ConstraintSpec`."""
        assert shape.triangles is not None
        return Volume(shape.triangles)
