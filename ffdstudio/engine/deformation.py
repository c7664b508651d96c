"""From a lattice's motion to the motion of the points embedded in it.

1. The displaced point is x0 + [R(u; current) - R(u; rest)], the bracket in the form of
   `polynomials`: a lattice at rest, and a cell whose control points rest, change no bit.
2. What a point receives depends on its parameters and on the two lattices alone, never on its
   place in the array, on its neighbours or on threads: nodes that coincide stay so.
3. Work goes in pieces (some chunks, or some cells of one chunk) to threads, and the table of
   polynomials is made for so many cells at a time that it stays in the cache.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ffdstudio import threads
from ffdstudio.aliases import Array
from ffdstudio.engine.lattice import Lattice
from ffdstudio.engine.polynomials import CHANGED, CoefficientTable, Motion, PolynomialCells, padded
from ffdstudio.engine.spans import SpanOrder
from ffdstudio.errors import InputError

TABLE_BYTES = 1 << 20
SMALL = 20000  # points that are not worth a second thread
SUMS = 16  # partial sums over the points, of which each machine makes as many
TASKS_PER_THREAD = 4  # so that a thread that is held up does not hold up the others


class Deformer:
    """The points of an embedding, ready to follow any deformed state of its lattice.

    It owns the parametric coordinates; the embedding hands them over and asks for them back.

    Parameters
    ----------
    lattice : Lattice
        The lattice at rest.
    points : numpy.ndarray
        (n, 3) float64 points; kept, not copied.
    parameters : numpy.ndarray
        (n, d) parametric coordinates; rows outside are ignored.
    inside : numpy.ndarray
        (n,) bool.
    """

    def __init__(
        self, lattice: Lattice, points: Array, parameters: Array, inside: NDArray[np.bool_]
    ) -> None:
        self.lattice = lattice
        self.points = points.view()
        self.points.flags.writeable = False  # one type of array, one compilation
        self.order = SpanOrder(lattice, parameters, inside)
        self.cells = PolynomialCells.of(lattice, self.order.places)

    def parameters(self) -> Array:
        """(n, d) parametric coordinates, NaN outside."""
        return self.order.parameters()

    def deform(self, current: Lattice, out: Array | None = None) -> Array:
        """(n, 3) points x0 + R(u; current) - R(u; rest); outside ones keep their bits."""
        check_space(self.lattice, current)
        out = checked_out(out, self.points.shape)
        if np.may_share_memory(out, self.points):
            raise InputError("the deformed points need an array of their own, not the given one")
        self._displace(Motion.between(self.lattice, current), out, copy=True)
        return out

    def displacement(self, motion: Motion, coordinates: int = 3) -> Array:
        """(n, coordinates) displacements of a motion, zero outside."""
        out = np.empty((len(self.points), coordinates))
        self._displace(motion, out, copy=False)
        return out

    def _displace(self, motion: Motion, out: Array, copy: bool) -> None:
        """Fill `out` with the displacements, on top of the points if they are to be copied."""
        from ffdstudio.engine.kernels import displace  # numba is paid for by its users only

        degrees = padded(self.lattice.degrees)
        kernel = displace(*degrees)
        groups = self.groups(motion.changed)
        fused = len(groups) == 1 and self.order.chunks > 1
        if not fused:
            np.copyto(out, self.points if copy else 0.0)

        def displace_group(group: NDArray[np.intp]) -> None:
            table = CoefficientTable.of(self.cells.part(group), motion)
            pieces, slots = self.order.pieces(group, fused), self.order.slots(group)
            slabs = table.coefficients.reshape(*table.coefficients.shape[:2], degrees[0] + 1, -1)

            def displace_pieces(part: tuple[int, int]) -> None:
                kernel(
                    *part, pieces, self.order.starts, slots, self.order.order, self.order.u,
                    table.ends, table.kinds, table.mask, slabs, motion.step, self.points, copy,
                    out,
                )  # fmt: skip

            self.share(displace_pieces, len(pieces), alone=len(groups) > 1)

        threads.for_each(displace_group, groups)

    def groups(self, chosen: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
        """Cells that the chosen control points influence, in groups whose tables stay small."""
        touched = self.cells.touched(chosen)
        most = max(TABLE_BYTES // (8 * CHANGED * len(self.cells.control)), 1)
        return [touched[k : k + most] for k in range(0, len(touched), most)]

    def parts(self, pieces: int) -> list[tuple[int, int]]:
        """Ranges that make up all the pieces, the same ones on any number of cores."""
        count = 1 if self.order.rows < SMALL else SUMS
        edges = np.unique(np.linspace(0, pieces, count + 1).astype(int)).tolist()
        return list(pairwise(edges))

    def share(
        self, work: Callable[[tuple[int, int]], object], pieces: int, alone: bool = False
    ) -> None:
        """Call `work` with ranges that make up all the pieces, on all cores unless `alone`.

        For work whose result does not depend on how it is cut; see `parts`.
        """
        alone = alone or self.order.rows < SMALL
        count = 1 if alone else threads.count() * TASKS_PER_THREAD
        edges = np.unique(np.linspace(0, pieces, count + 1).astype(int)).tolist()
        threads.for_each(work, pairwise(edges))


def checked_out(out: Array | None, shape: tuple[int, ...]) -> Array:
    """`out`, or a new array; raises `InputError` if it cannot take the result."""
    if out is None:
        return np.empty(shape)
    if not isinstance(out, np.ndarray):
        raise InputError(f"the output must be an array {shape}, got {type(out).__name__}")
    if out.shape != shape or out.dtype != np.float64 or not out.flags.carray:
        raise InputError(
            f"the output must be a writable contiguous float64 array {shape}, "
            f"got {out.dtype} {out.shape}"
        )
    return out


def check_space(lattice: Lattice, current: Lattice) -> None:
    """Raise `InputError` unless both lattices have the same degrees and knots."""
    if not isinstance(current, Lattice):
        raise InputError(f"the deformed lattice must be a Lattice, got {type(current).__name__}")
    if not lattice.same_space(current):
        raise InputError(
            f"the deformed lattice {current} has other degrees or knots than the {lattice} "
            "the points are embedded in"
        )
