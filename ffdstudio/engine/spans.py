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

from ffdstudio import threads
from ffdstudio.aliases import AnyArray, Array, Indices
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
        from ffdstudio.engine import sorting  # numba is paid for by its users only

        self.rows = len(parameters)
        lines = tuple(direction.breaks for direction in lattice.directions)
        sizes = np.array([2 * len(line) - 1 for line in lines])
        scales = np.array([(len(line) - 1) / (line[-1] - line[0]) for line in lines])
        whole = int(np.prod(sizes, dtype=float))
        codes = np.empty(self.rows, np.int32 if whole < 2**31 else np.int64)
        seen = np.zeros(whole, np.uint8)

        def code(part: tuple[int, int]) -> None:
            sorting.code_rows(*part, parameters, inside, lines, scales, sizes, codes, seen)

        edges = range(0, self.rows, LARGEST_CHUNK)
        threads.for_each(code, [(k, min(k + LARGEST_CHUNK, self.rows)) for k in edges])
        occupied = np.flatnonzero(seen)
        self.places = np.stack(np.unravel_index(occupied, sizes), axis=1)
        self.chunk = _chunk(self.rows, len(occupied))
        numbers = np.zeros(whole, np.int64)
        numbers[occupied] = np.arange(len(occupied))
        self._sort(parameters, codes, numbers)

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

    def _sort(self, parameters: Array, codes: AnyArray, numbers: Indices) -> None:
        """Bring the rows of each chunk into the order of their cells."""
        from ffdstudio.engine import sorting

        self.starts = np.zeros(self.chunks * self.cells + 1, dtype=np.int64)
        counts = self.starts[1:].reshape(self.chunks, self.cells)
        ranges = self.row_ranges().tolist()

        def count(c: int) -> None:
            sorting.count_cells(*ranges[c], codes, numbers, counts[c])

        threads.for_each(count, range(self.chunks))
        np.cumsum(self.starts, out=self.starts)
        self.u = np.empty((parameters.shape[1], int(self.starts[-1])))
        small = self.chunk <= LARGEST_CHUNK
        self.order: AnyArray = np.empty(self.u.shape[1], np.uint16 if small else np.uint32)
        at = self.starts[:-1].reshape(self.chunks, self.cells).copy()

        def place(c: int) -> None:
            sorting.place_rows(*ranges[c], codes, numbers, at[c], parameters, self.u, self.order)

        threads.for_each(place, range(self.chunks))


def _chunk(rows: int, cells: int) -> int:
    """Rows of a chunk; all of them where a chunk would hold too few points of a cell."""
    wanted = max(SMALLEST_CHUNK, POINTS_PER_CELL * cells)
    return max(wanted if wanted <= LARGEST_CHUNK else rows, 1)
