"""Points sorted by knot span: the order in which the kernels process them.

1. Rows are cut into chunks, so that the coordinates of a chunk stay in a core's cache
   while its points are visited out of order; inside a chunk the points of a knot span
   stand together and share one polynomial.
2. A cell is a product of *places*. Along a direction with distinct knots b_0 ... b_s the
   place 2j is the knot b_j itself and 2j + 1 the open span between b_j and b_(j+1). On a
   knot some basis functions vanish exactly, in the polynomial of a span only up to
   rounding: with knots as places of their own, a point on the rim of a support, or on
   the face of a lattice whose outer layers are held, keeps its bits.
3. The parameters are stored once, in processing order, a direction after the other.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.lattice import Lattice

SMALLEST_CHUNK = 16384
LARGEST_CHUNK = 65536  # within it a row is a 16-bit number
POINTS_PER_CELL = 64  # fewer than this in a chunk and a polynomial is not worth loading


class SpanOrder:
    """Parameters of the inside points in processing order, and the way back.

    Attributes
    ----------
    places : numpy.ndarray
        (cells, d) place of each cell that holds points, by direction.
    u : numpy.ndarray
        (d, m) parameters of the inside points.
    order : numpy.ndarray
        (m,) row of each of them, counted from the first row of its chunk.
    starts : numpy.ndarray
        (chunks * cells + 1,) where each cell of each chunk begins in `order`.
    chunk : int
        Rows in a chunk.
    """

    def __init__(self, lattice: Lattice, parameters: Array, inside: NDArray[np.bool_]) -> None:
        self.rows = len(parameters)
        lines = [direction.breaks for direction in lattice.directions]
        sizes = [2 * len(line) - 1 for line in lines]
        codes = _codes(lines, sizes, parameters, inside)
        occupied = np.unique(codes[inside])
        self.places = np.stack(np.unravel_index(occupied, sizes), axis=1)
        self.chunk = _chunk(self.rows, len(occupied))
        count = int(np.count_nonzero(inside))
        self.u = np.empty((lattice.dimension, count))
        self.order = np.empty(count, np.uint16 if self.chunk <= LARGEST_CHUNK else np.uint32)
        self.starts = np.zeros(self.chunks * len(occupied) + 1, dtype=np.int64)
        self._sort(parameters, inside, codes, occupied)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.rows // self.chunk)

    @property
    def cells(self) -> int:
        """Number of cells that hold points."""
        return len(self.places)

    def row_ranges(self) -> NDArray[np.intp]:
        """(chunks, 2) first and last + 1 row of each chunk."""
        first = np.arange(self.chunks) * self.chunk
        return np.stack([first, np.minimum(first + self.chunk, self.rows)], axis=1)

    def parameters(self) -> Array:
        """(n, d) parameters by row, NaN outside."""
        out = np.full((self.rows, len(self.u)), np.nan)
        for rows, part in self.by_chunk():
            out[rows] = self.u[:, part].T
        return out

    def by_chunk(self) -> Iterator[tuple[NDArray[np.intp], slice]]:
        """Yield the rows of a chunk's inside points and where they are in processing order."""
        ends = self.starts[:: max(self.cells, 1)]
        for c in range(self.chunks):
            part = slice(ends[c], ends[c + 1]) if self.cells else slice(0, 0)
            yield self.order[part].astype(np.intp) + c * self.chunk, part

    def slots(self, group: NDArray[np.intp]) -> NDArray[np.intp]:
        """(cells,) position of each cell in a group of cells, -1 for those not in it."""
        slots = np.full(self.cells, -1)
        slots[group] = np.arange(len(group))
        return slots

    def pieces(self, group: NDArray[np.intp], copy: bool = False) -> NDArray[np.intp]:
        """(pieces, 5) portions of work that can be done at the same time.

        Rows to copy (from, to), row that `order` counts from, segments (from, to). A segment is
        a cell of a chunk; its number is chunk * cells + cell. With several chunks they are the
        pieces, with one its cells.
        """
        low, high = self.row_ranges().T
        if len(low) == 1:
            none = np.zeros_like(group)
            return np.stack([none, none, none, group, group + 1], axis=1)
        first = np.arange(len(low)) * self.cells
        return np.stack([low, high if copy else low, low, first, first + self.cells], axis=1)

    def _sort(
        self,
        parameters: Array,
        inside: NDArray[np.bool_],
        codes: NDArray[np.integer],
        occupied: NDArray[np.integer],
    ) -> None:
        counts = self.starts[1:].reshape(self.chunks, len(occupied))
        small = np.uint16 if len(occupied) <= 65536 else np.intp  # 16 bits sort by radix
        done = 0
        for c, (first, last) in enumerate(self.row_ranges()):
            rows = np.flatnonzero(inside[first:last])
            cell = np.searchsorted(occupied, codes[first:last][rows]).astype(small)
            rows = rows[np.argsort(cell, kind="stable")]
            part = slice(done, done + len(rows))
            self.order[part] = rows
            for k in range(len(self.u)):
                self.u[k, part] = parameters[first:last, k][rows]
            counts[c] = np.bincount(cell, minlength=len(occupied))
            done += len(rows)
        np.cumsum(self.starts, out=self.starts)


def _codes(
    lines: list[Array], sizes: list[int], parameters: Array, inside: NDArray[np.bool_]
) -> NDArray[np.integer]:
    """Give every row the number of its cell; rows outside get any number."""
    kind: type[np.integer] = np.int32 if np.prod(sizes, dtype=float) < 2**31 else np.int64
    codes: NDArray[np.integer] = np.zeros(len(parameters), dtype=kind)
    for first in range(0, len(parameters), LARGEST_CHUNK):
        part = slice(first, first + LARGEST_CHUNK)
        for k, line in enumerate(lines):
            u = np.where(inside[part], parameters[part, k], line[0])
            place = np.searchsorted(line, u, "left") + np.searchsorted(line, u, "right") - 1
            codes[part] = codes[part] * sizes[k] + place
    return codes


def _chunk(rows: int, cells: int) -> int:
    """Rows of a chunk; all of them where a chunk would hold too few points of a cell."""
    wanted = max(SMALLEST_CHUNK, POINTS_PER_CELL * cells)
    return max(wanted if wanted <= LARGEST_CHUNK else rows, 1)
