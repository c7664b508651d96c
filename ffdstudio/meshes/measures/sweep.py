"""One pass over the cells of a block, shared among the cores, that leaves few of them to solve.

Rows are taken in batches of fixed size, whatever the number of threads, so that nothing that is
found depends on it, and no array is as long as the mesh has cells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ffdstudio import threads
from ffdstudio.aliases import AnyArray, Array, Indices, Mask
from ffdstudio.meshes.measures.bezier import HEX_EDGES
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.corners import jacobians, signs

BATCH, PIECE = 1 << 20, 1 << 15
SMALL = 4096  # cells below which NumPy is as quick
KINDS = {"hexahedron": 1, "wedge": 2}  # as in `cell_kernels`


@dataclass(frozen=True, eq=False)
class Sweep:
    """What all passes need to know.

    Attributes
    ----------
    rest : numpy.ndarray
        Undeformed extended points, which tell the signs.
    moved : numpy.ndarray
        Mask of the extended points that move: cells without one are passed over.
    flat : bool
        Whether plane cells lie in z = 0 rather than on a surface in space.
    """

    rest: Array
    moved: Mask
    flat: bool

    @property
    def largest(self) -> float:
        """Largest coordinate."""
        return float(np.abs(self.rest).max(initial=0.0))

    def flipped(self, block: CellBlock, here: Array) -> Iterator[tuple[Indices, Indices]]:
        """Rows with a corner that lost its sign, and others that may be negative inside."""
        if len(block.nodes) < SMALL:
            yield self._by_numpy(block, here)
            return
        from ffdstudio.meshes.measures.cell_kernels import FLIPPED, INSIDE, flips

        given = self.rest, here, self.moved, self.flat, self.largest, *_inside(block)
        for first, flags in _batches(flips, block, given):
            yield first + np.flatnonzero(flags & FLIPPED), first + np.flatnonzero(flags == INSIDE)

    def doubtful(
        self, block: CellBlock, start: Array, move: Array, far: Callable[[], float]
    ) -> Iterator[tuple[Indices, Indices]]:
        """Rows with a corner that may lose its volume up to an amplitude, and others inside.

        `far` is asked again for each batch: what was found in one shortens the way of the next.
        """
        if len(block.nodes) < SMALL:  # all of them are in doubt
            rows = np.flatnonzero(self.moved[block.nodes].any(axis=1))
            yield rows, rows
            return
        from ffdstudio.meshes.measures.cell_kernels import DOUBT, INSIDE, doubtful

        common = self.rest, start, move, self.moved, self.flat, start is self.rest, self.largest
        for first in range(0, len(block.nodes), BATCH):
            part = block[first : first + BATCH]
            given = *common, far(), *_inside(block)
            for _, flags in _batches(doubtful, part, given):
                at = first + np.flatnonzero(flags & DOUBT), first + np.flatnonzero(flags & INSIDE)
                yield at

    def _by_numpy(self, block: CellBlock, here: Array) -> tuple[Indices, Indices]:
        """The same without a kernel, which would take longer to load: `flipped` of a few cells."""
        rows = np.flatnonzero(self.moved[block.nodes].any(axis=1))
        part, up = block[rows], None if self.flat or len(block.corners[0]) == 4 else self.rest
        sign = signs(part, self.rest, up)
        bad = ((jacobians(part, here, up) * sign <= 0) & (sign != 0)).any(axis=0)
        return rows[bad], rows[~bad]


def _inside(block: CellBlock) -> tuple[int, AnyArray]:
    """Kind of the cells for what the kernels know of their inside, and its table of edges."""
    return KINDS.get(block.type, 0), np.array(HEX_EDGES)


def still(array: AnyArray) -> AnyArray:
    """Contiguous read-only view: kernels are compiled once, whoever made an array."""
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view


def _batches(
    kernel: Callable[..., None], block: CellBlock, given: tuple[object, ...]
) -> Iterator[tuple[int, AnyArray]]:
    """First row and flags of each batch."""
    table, nodes = np.array(block.corners), still(block.nodes)
    given = tuple(still(value) if isinstance(value, np.ndarray) else value for value in given)
    for first in range(0, len(block.nodes), BATCH):
        end = min(first + BATCH, len(block.nodes))
        flags = np.empty(end - first, dtype=np.uint8)

        def work(begin: int, first: int = first, end: int = end, flags: AnyArray = flags) -> None:
            stop = min(begin + PIECE, end)
            kernel(begin, stop, nodes, table, *given, flags[begin - first : stop - first])

        threads.for_each(work, range(first, end, PIECE))
        yield first, flags
