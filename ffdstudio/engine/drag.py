"""Dragging control points: only the points that follow are touched, by one multiply-add each.

With the weights fixed, a common motion D of some control points moves a point by b D, where b
is the sum of w_i B_i / W over them. It is computed when the drag begins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio import threads
from ffdstudio.aliases import Array
from ffdstudio.engine.deformation import SMALL, Deformer, checked_out
from ffdstudio.engine.knots import numbers
from ffdstudio.engine.lattice import Lattice
from ffdstudio.engine.products import influence
from ffdstudio.errors import InputError

SHARE = 32768  # points of a thread's portion


class Drag:
    """A common motion of some control points, prepared; made by `Embedding.drag`.

    Attributes
    ----------
    rows : numpy.ndarray
        (m,) ascending numbers of the points that follow.
    influence : numpy.ndarray
        (m,) share of the motion that each of them follows, above 0 and at most 1.
    start : numpy.ndarray
        (m, 3) where they are when the drag begins.
    """

    def __init__(self, deformer: Deformer, current: Lattice, control_points: ArrayLike) -> None:
        chosen = _chosen(control_points, current.weights.size)
        share = influence(deformer, current, chosen)
        self.rows = np.flatnonzero(share)
        self.influence = share[self.rows]
        self.start = deformer.deform(current)[self.rows]
        self._shape = deformer.points.shape

    def move(self, vector: ArrayLike, out: Array) -> Array:
        """Write the moved points into their rows of `out` and return it.

        Parameters
        ----------
        vector : array_like
            (3,) motion of the control points since the drag began.
        out : numpy.ndarray
            (n, 3) points; the rows that do not follow are left as they are.
        """
        from ffdstudio.engine.kernels import move

        step = numbers(vector, "the motion of a drag")
        if step.shape != (3,) or not np.isfinite(step).all():
            raise InputError(f"the motion of a drag must be 3 finite numbers, got {vector!r}")
        step[step == 0] = -0.0  # adding -0.0 changes no bit, not even those of -0.0
        checked_out(out, self._shape)
        count, kernel = len(self.rows), move()
        size = SHARE if count > SMALL else max(count, 1)

        def move_rows(first: int) -> None:
            last = min(first + size, count)
            kernel(first, last, self.rows, self.start, self.influence, step, out)

        threads.for_each(move_rows, range(0, count, size))
        return out


def _chosen(control_points: ArrayLike, count: int) -> np.ndarray:
    """(count,) bool from flat control point numbers."""
    chosen_ones = np.atleast_1d(np.asarray(control_points))
    if chosen_ones.size and not np.issubdtype(chosen_ones.dtype, np.integer):
        raise InputError("control points to drag are given by their numbers")
    if chosen_ones.size and not (chosen_ones.min() >= 0 and chosen_ones.max() < count):
        raise InputError(f"the lattice has control points 0 to {count - 1}, got {chosen_ones}")
    chosen = np.zeros(count, dtype=bool)
    chosen[chosen_ones.astype(np.intp)] = True
    return chosen
